// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/base/frame.h"

namespace xview::io {

/// PNG uint16 (times depth_scale), TIFF/EXR float32 metres, or PFM; not finite and negative values
/// become 0. Throws Error.
DepthImage readDepth(const std::string& path, const Camera& camera);
/// PNG uint8 or uint16 with one channel. Throws Error.
LabelImage readLabels(const std::string& path);
/// camera.yaml; throws Error that lists all missing keys.
Camera readCamera(const std::string& path);

/// PNG or JPEG of 8 bits; grey images become colours. Throws Error.
ColorImage readColors(const std::string& path);
/// YAML of how a network wants its images: {labels, ids, width, height, mean, std, order: rgb|bgr};
/// only `labels` must be there. Throws Error with path:line.
NetworkInput readNetworkInput(const std::string& path);

void writeDepthPng(const std::string& path, const DepthImage& depth, double depth_scale);
void writeLabelPng(const std::string& path, const LabelImage& labels);
void writeCamera(const std::string& path, const Camera& camera);

}  // namespace xview::io
