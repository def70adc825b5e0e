// SPDX-License-Identifier: BSD-3-Clause
#include "place/network.h"

#include "place/opencv_network.h"
#include "process/module.h"

namespace xview {

std::unique_ptr<Network> Network::open(const std::string& model_path, NetworkInput input) {
  static const auto open = reinterpret_cast<decltype(&xviewOpenNetwork)>(
      moduleFunction("xview_network", "xviewOpenNetwork", "networks that label images"));
  return std::unique_ptr<Network>(open(model_path, input));
}

}  // namespace xview
