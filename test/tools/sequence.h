// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview::test {

/// Writes a sequence folder that is small and in order: `frames` images of 64 x 48 pixels that show
/// a road, a wall and three poles 6 to 12 m ahead, while the camera moves 0.5 m per frame;
/// classes.yaml, camera.yaml, TUM poses.
void writeSequence(const std::string& folder, int frames = 4);

}  // namespace xview::test
