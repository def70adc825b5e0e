// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "xview/view/scene.h"

namespace xview {

struct HtmlViewOptions {
  std::size_t most_points = 1000000;  ///< of each cloud, evenly thinned; each costs 20 bytes
};

/// A page with a 3-D view to turn, shift and zoom, and a switch per layer. It holds everything it
/// needs: opens from file:// without a network.
std::string htmlView(const Scene& scene, const HtmlViewOptions& options = {});

}  // namespace xview
