// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/base/bev_grid.h"

namespace xview {

/// What the samples of a channel become where fewer classes are told apart: samples of other
/// channels, or of none.
struct ChannelMove {
  BevChannel from;
  std::vector<BevChannel> to;
};
using ChannelMoves = std::vector<ChannelMove>;

/// Makes them in order.
void moveSamples(const ChannelMoves& moves, BevGrid& bev);

}  // namespace xview
