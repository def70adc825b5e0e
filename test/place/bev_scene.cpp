// SPDX-License-Identifier: BSD-3-Clause
#include "bev_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/label_sets.h"

namespace xview::test {

namespace {

constexpr double kStep_m = 0.25;

/// Middles of steps between two ends.
std::vector<double> steps(double from, double to) {
  std::vector<double> result;
  const int count = std::max(1, static_cast<int>(std::lround((to - from) / kStep_m)));
  for (int i = 0; i < count; ++i) result.push_back(from + (i + 0.5) * (to - from) / count);
  return result;
}

}  // namespace

LabelSet bevLabels() {
  std::vector<StatedClass> classes;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(Kind::none); ++k) {
    const Kind kind = static_cast<Kind>(k);
    classes.push_back({k, toString(kind), Role::surface, kind});
  }
  classes.push_back({kIgnoredLabel, toString(Kind::none), Role::ignored, Kind::none});
  return labelSetOf("plan", classes);
}

BevScene& BevScene::point(Kind kind, double x, double y, double z, float weights, bool near) {
  Point p;
  p.getVector3fMap() = Eigen::Vector3d(x, y, z).cast<float>();
  p.label = kind == Kind::none ? kIgnoredLabel : static_cast<std::uint32_t>(kind);
  cloud_.points.push_back(p);
  weights_.push_back(weights);
  near_.push_back(near);
  return *this;
}

BevScene& BevScene::patch(Kind kind, double x0, double y0, double x1, double y1,
                          const Height& height) {
  for (const double y : steps(y0, y1)) {
    for (const double x : steps(x0, x1)) point(kind, x, y, height(x, y));
  }
  return *this;
}

BevScene& BevScene::patch(Kind kind, double x0, double y0, double x1, double y1, double z) {
  return patch(kind, x0, y0, x1, y1, [z](double, double) { return z; });
}

BevScene& BevScene::wall(Kind kind, double x0, double y0, double x1, double y1, double z0,
                         double z1) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  for (const double s : steps(0, length)) {
    column(kind, x0 + s / length * (x1 - x0), y0 + s / length * (y1 - y0), z0, z1);
  }
  return *this;
}

BevScene& BevScene::column(Kind kind, double x, double y, double z0, double z1) {
  for (const double z : steps(z0, z1)) point(kind, x, y, z);
  return *this;
}

BevScene BevScene::reversed() const {
  BevScene result = *this;
  std::reverse(result.cloud_.points.begin(), result.cloud_.points.end());
  std::reverse(result.weights_.begin(), result.weights_.end());
  std::reverse(result.near_.begin(), result.near_.end());
  return result;
}

void BevScene::addTo(BevGridBuilder& builder, bool aerial,
                     const Eigen::Isometry3d& T_bev_cloud) const {
  builder.add(cloud_, weights_, near_, T_bev_cloud, aerial);
}

BevGrid BevScene::view(bool aerial, const Eigen::Isometry3d& T_bev_cloud) const {
  BevGridBuilder builder(bevLabels());
  addTo(builder, aerial, T_bev_cloud);
  return builder.build();
}

BevScene junction() {
  BevScene scene;
  scene.patch(Kind::road, 2, 16, 62, 24, 0.1).patch(Kind::road, 28, 24, 36, 60, 0.1);
  scene.patch(Kind::lane_marking, 2, 19.5, 62, 20.5, 0.1);
  scene.patch(Kind::sidewalk, 2, 13, 62, 16, 0.2).patch(Kind::sidewalk, 24, 24, 28, 60, 0.2);
  scene.patch(Kind::terrain, 2, 4, 62, 13, 0.2).patch(Kind::terrain, 36, 24, 62, 60, 0.2);
  scene.wall(Kind::building, 10.1, 6.3, 30.1, 6.3, 0.2, 7)
      .wall(Kind::fence, 32.2, 8.3, 60, 8.9, 0.2, 1.7);
  scene.wall(Kind::building, 12.3, 26.1, 12.3, 50, 0.2, 7);
  for (const double x : {8.1, 23.3, 44.6}) scene.column(Kind::pole, x, 15.2, 0.2, 5);
  scene.column(Kind::sign, 26.4, 30.2, 0.2, 3).column(Kind::light, 26.2, 52.2, 0.2, 4);
  for (const double y : {33.3, 45.8}) {
    scene.column(Kind::trunk, 45.2, y, 0.2, 2);
    scene.patch(Kind::vegetation, 42.5, y - 2.5, 47.5, y + 2.5, [y](double px, double py) {
      return 7 - 0.3 * ((px - 45) * (px - 45) + (py - y) * (py - y));
    });
  }
  scene.wall(Kind::vehicle, 50, 22.2, 54, 22.2, 0.3, 1.4)
      .wall(Kind::vehicle, 50, 23.8, 54, 23.8, 0.3, 1.4);
  scene.patch(Kind::vehicle, 50, 22.2, 54, 23.8, 1.4);
  scene.column(Kind::other_object, 20.3, 14.2, 0.2, 1.4);
  return scene;
}

const GroundCell* knownAt(const BevGrid& view, double x, double y) {
  const auto cx = static_cast<std::int32_t>(std::floor((x - view.origin_x) / view.cell_m));
  const auto cy = static_cast<std::int32_t>(std::floor((y - view.origin_y) / view.cell_m));
  for (const GroundCell& cell : view.known) {
    if (cell.x == cx && cell.y == cy) return &cell;
  }
  return nullptr;
}

Eigen::Vector2d inFrame(const BevGrid& view, const BevSample& sample) {
  return {view.origin_x + sample.x, view.origin_y + sample.y};
}

double distanceTo(const BevGrid& view, BevChannel channel, double x, double y) {
  double best = std::numeric_limits<double>::infinity();
  for (const BevSample& s : view[channel]) {
    best = std::min(best, (inFrame(view, s) - Eigen::Vector2d(x, y)).norm());
  }
  return best;
}

}  // namespace xview::test
