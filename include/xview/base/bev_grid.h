// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace xview {

/// Channel of a bird's-eye view (BEV). Each is matched with itself only.
enum class BevChannel : std::uint8_t {
  // area: one sample per cell
  road,
  sidewalk,
  terrain,
  lane_marking,
  // upright surfaces: one sample per cell at the mean of its points
  building,
  wall_foot,
  fence,
  low_vegetation,
  canopy,
  vehicle_surface,
  other_surface,
  // lines between ground classes: midpoints between cells
  border_road_sidewalk,
  border_sidewalk_terrain,
  border_road_terrain,
  // anything that stands there, whatever its label
  obstacle_low,
  obstacle_high,
  // objects: one sample each
  pole,
  sign,
  light,
  pole_like,
  vehicle,
  tree,
  trunk,
  other_object,
  count
};

constexpr std::size_t kBevChannels = static_cast<std::size_t>(BevChannel::count);

const char* toString(BevChannel channel);
inline bool isArea(BevChannel c) { return c <= BevChannel::lane_marking; }
inline bool isBorder(BevChannel c) {
  return c >= BevChannel::border_road_sidewalk && c <= BevChannel::border_road_terrain;
}
inline bool isObject(BevChannel c) { return c >= BevChannel::pole; }

/// A sample, relative to the origin of its grid.
struct BevSample {
  float x = 0, y = 0, z = 0;  ///< z: ground height at the sample [m]
};

/// A cell that was seen, with its ground height.
struct GroundCell {
  std::int32_t x = 0, y = 0;  ///< cell index: floor(p / cell_m)
  float z = 0;                ///< ground height relative to the origin [m]
  bool measured = false;      ///< ground points fell into it; else z comes from the neighbourhood
};

/// Row by row: by y, then x.
struct InRowOrder {
  template <class Cell>
  bool operator()(const Cell& a, const Cell& b) const {
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  }
};

/// Bird's-eye view of a place: samples of surfaces and objects by channel, on a grid of cell_m.
/// Cells that are not among `known` were never observed, which is not the same as empty.
struct BevGrid {
  double cell_m = 0.5;
  double origin_x = 0, origin_y = 0, origin_z = 0;  ///< p_bev = origin + sample
  /// Turns the frame so that z points up: p_bev = alignment * p_frame. Identity if the frame is
  /// gravity-aligned already.
  Eigen::Quaterniond alignment = Eigen::Quaterniond::Identity();
  bool aerial = false;  ///< most of it was seen from the air: roofs and crowns are known, what is
                        ///< below is not
  std::array<std::vector<BevSample>, kBevChannels> samples;
  std::vector<GroundCell> known;  ///< sorted by (y, x)

  std::vector<BevSample>& operator[](BevChannel c) { return samples[static_cast<std::size_t>(c)]; }
  const std::vector<BevSample>& operator[](BevChannel c) const {
    return samples[static_cast<std::size_t>(c)];
  }
  std::size_t sampleCount() const;
  const GroundCell* knownCell(std::int32_t x, std::int32_t y) const;  ///< null if it was not seen
};

}  // namespace xview
