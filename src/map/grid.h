// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace xview {

/// Resolution of stored single-precision coordinates: one centimetre.
constexpr double kStoredSteps = 100;  // per metre

/// Nothing farther from its origin than this fits into a map [m].
constexpr double kFarthest_m = 1e7;

/// Coordinate in whole centimetres. `what` names the owner in the message.
inline std::int64_t toSteps(double metres, const char* what) {
  if (!(std::abs(metres) <= kFarthest_m)) {
    throw std::out_of_range(std::string(what) + " at " + std::to_string(metres) +
                            " m from the origin; at most 10000 km fit into a map");
  }
  return std::llround(metres * kStoredSteps);
}

inline float toMetres(std::int64_t steps) {
  return static_cast<float>(static_cast<double>(steps) / kStoredSteps);
}

inline std::int64_t floorDivide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

/// Row id of a tile: packs its indices so that ids do not change when tiles are added.
constexpr std::int64_t kTileIndexBias = std::int64_t{1} << 19;
inline std::int64_t tileId(std::int64_t x, std::int64_t y, std::int64_t z) {
  return ((z + kTileIndexBias) << 40) | ((y + kTileIndexBias) << 20) | (x + kTileIndexBias);
}
inline bool isTileIndex(std::int64_t i) { return i >= -kTileIndexBias && i < kTileIndexBias; }

}  // namespace xview
