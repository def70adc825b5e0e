// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "place/bev_grid.h"

namespace xview::test {

/// A label set with one class of each kind; the id of a class is its Kind. 100 is ignored.
LabelSet bevLabels();
constexpr std::uint32_t kIgnoredLabel = 100;

/// Points put together by hand, one weight each, and what the BEV grid makes of them.
class BevScene {
 public:
  using Height = std::function<double(double x, double y)>;

  BevScene& point(Kind kind, double x, double y, double z, float weights = 1, bool near = true);
  /// A horizontal patch, a point every 0.25 m.
  BevScene& patch(Kind kind, double x0, double y0, double x1, double y1, const Height& height);
  BevScene& patch(Kind kind, double x0, double y0, double x1, double y1, double z);
  /// A vertical sheet from (x0, y0) to (x1, y1), a point every 0.25 m.
  BevScene& wall(Kind kind, double x0, double y0, double x1, double y1, double z0, double z1);
  BevScene& column(Kind kind, double x, double y, double z0, double z1);
  /// Points in another order.
  BevScene reversed() const;

  LabelledCloud cloud() const { return cloud_; }
  BevGrid view(bool aerial = false,
               const Eigen::Isometry3d& T_bev_cloud = Eigen::Isometry3d::Identity()) const;
  void addTo(BevGridBuilder& builder, bool aerial = false,
             const Eigen::Isometry3d& T_bev_cloud = Eigen::Isometry3d::Identity()) const;

 private:
  LabelledCloud cloud_;
  std::vector<float> weights_;
  std::vector<bool> near_;
};

/// A junction with pavements, houses, poles, trees and cars: something in almost every channel.
BevScene junction();

/// The cell of a view, or null where it was not seen. Coordinates of the frame [m].
const GroundCell* knownAt(const BevGrid& view, double x, double y);

/// A sample in coordinates of the frame.
Eigen::Vector2d inFrame(const BevGrid& view, const BevSample& sample);

/// Distance from a point of the frame to the nearest sample of a channel; infinite if it has none.
double distanceTo(const BevGrid& view, BevChannel channel, double x, double y);

}  // namespace xview::test
