// SPDX-License-Identifier: BSD-3-Clause
#include "bev_town.h"

#include <cmath>
#include <map>

namespace xview::test {
namespace {

constexpr double kStep_m = 0.2;

using CellKey = std::pair<std::int32_t, std::int32_t>;  // (y, x)

CellKey cellOf(const Eigen::Vector2d& p, double cell_m) {
  return {static_cast<std::int32_t>(std::floor(p.y() / cell_m)),
          static_cast<std::int32_t>(std::floor(p.x() / cell_m))};
}

/// One sample per cell at the mean of its points (objects: each point).
std::vector<BevSample> drawn(const std::vector<Eigen::Vector2d>& points, BevChannel channel,
                             double cell_m) {
  struct Mean {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int count = 0;
  };
  std::map<CellKey, Mean> cells;
  std::vector<BevSample> samples;
  for (const Eigen::Vector2d& p : points) {
    if (isObject(channel))
      samples.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), 0});
    Mean& mean = cells[cellOf(p, cell_m)];
    mean.sum += p;
    ++mean.count;
  }
  if (isObject(channel)) return samples;
  for (const auto& [cell, mean] : cells) {
    const Eigen::Vector2d p = mean.sum / mean.count;
    samples.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), 0});
  }
  return samples;
}

}  // namespace

void BevTown::object(BevChannel channel, double x, double y) {
  points_[static_cast<std::size_t>(channel)].emplace_back(x, y);
}

void BevTown::line(BevChannel channel, double x0, double y0, double x1, double y1) {
  const int steps = std::max(1, static_cast<int>(std::hypot(x1 - x0, y1 - y0) / kStep_m));
  for (int i = 0; i <= steps; ++i) {
    object(channel, x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps);
  }
}

void BevTown::area(BevChannel channel, double x0, double y0, double x1, double y1) {
  for (double y = y0; y < y1; y += kStep_m) line(channel, x0, y, x1, y);
}

void BevTown::house(double x0, double y0, double x1, double y1) {
  for (const BevChannel c : {BevChannel::building, BevChannel::wall_foot, BevChannel::obstacle_low,
                             BevChannel::obstacle_high}) {
    line(c, x0, y0, x1, y0);
    line(c, x0, y1, x1, y1);
    line(c, x0, y0, x0, y1);
    line(c, x1, y0, x1, y1);
  }
}

void BevTown::street(double x0, double x1, double y, Random& random) {
  area(BevChannel::road, x0, y - 3, x1, y + 3);
  for (const double side : {-1.0, 1.0}) {
    line(BevChannel::border_road_sidewalk, x0, y + side * 3, x1, y + side * 3);
    area(BevChannel::sidewalk, x0, y + side * 3 - (side < 0 ? 2 : 0), x1,
         y + side * 3 + (side > 0 ? 2 : 0));
    for (double x = x0; x < x1;) {
      const double width = random.uniform(6, 14), front = y + side * random.uniform(7, 11);
      if (random.uniform() < 0.7)
        house(x, std::min(front, front + side * 8), x + width, std::max(front, front + side * 8));
      else
        line(BevChannel::fence, x, y + side * 6, x + width, y + side * 6);
      x += width + random.uniform(1, 6);
    }
    for (double x = x0; x < x1; x += random.uniform(8, 25)) {
      const BevChannel pole = random.uniform() < 0.6 ? BevChannel::pole : BevChannel::sign;
      const double py = y + side * random.uniform(3.3, 4.7);
      object(pole, x, py);
      object(BevChannel::pole_like, x, py);
      if (random.uniform() < 0.6)
        object(BevChannel::tree, x + random.uniform(3, 6), y + side * random.uniform(5, 7));
    }
  }
}

void BevTown::repeat(double dx, double dy) {
  for (auto& channel : points_) {
    const std::size_t count = channel.size();
    for (std::size_t i = 0; i < count; ++i) channel.push_back(channel[i] + Eigen::Vector2d(dx, dy));
  }
}

BevTown BevTown::mirrored() const {
  BevTown town = *this;
  for (auto& channel : town.points_) {
    for (Eigen::Vector2d& p : channel) p.y() = -p.y();
  }
  return town;
}

BevGrid BevTown::view(const Eigen::Vector2d& place, double radius_m,
                      const Eigen::Isometry3d& T_frame_town, double origin_x,
                      double origin_y) const {
  BevGrid view;
  view.origin_x = origin_x;
  view.origin_y = origin_y;
  const Eigen::Vector3d origin(origin_x, origin_y, 0);
  const auto toFrame = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return (T_frame_town * Eigen::Vector3d(p.x(), p.y(), 0) - origin).head<2>();
  };
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    std::vector<Eigen::Vector2d> seen;
    for (const Eigen::Vector2d& p : points_[c]) {
      if ((p - place).norm() < radius_m) seen.push_back(toFrame(p));
    }
    view.samples[c] = drawn(seen, static_cast<BevChannel>(c), view.cell_m);
    for (BevSample& s : view.samples[c]) {
      const Eigen::Vector3d p = T_frame_town.inverse() * (origin + Eigen::Vector3d(s.x, s.y, 0));
      s.z = static_cast<float>(groundHeight(p.x(), p.y()) + T_frame_town.translation().z());
    }
  }
  const Eigen::Vector2d centre = toFrame(place);
  const auto [y0, x0] = cellOf(centre.array() - radius_m, view.cell_m);
  const auto [y1, x1] = cellOf(centre.array() + radius_m, view.cell_m);
  for (std::int32_t y = y0; y <= y1; ++y) {
    for (std::int32_t x = x0; x <= x1; ++x) {
      const Eigen::Vector2d p = view.cell_m * Eigen::Vector2d(x + 0.5, y + 0.5);
      if ((p - centre).norm() > radius_m) continue;
      const Eigen::Vector3d town =
          T_frame_town.inverse() * (origin + Eigen::Vector3d(p.x(), p.y(), 0));
      view.known.push_back(
          {x, y,
           static_cast<float>(groundHeight(town.x(), town.y()) + T_frame_town.translation().z()),
           true});
    }
  }
  return view;
}

BevTown randomTown(std::uint64_t seed) {
  Random random(seed);
  BevTown town;
  for (const double y : {-45.0, 0.0, 45.0}) town.street(-120, 120, y, random);
  return town;
}

std::vector<Eigen::Vector3d> driveThrough() {
  std::vector<Eigen::Vector3d> path;
  for (const double y : {-45.0, 0.0, 45.0}) {
    for (double x = -110; x <= 110; x += 2) path.emplace_back(x, y, 1.5);
  }
  return path;
}

}  // namespace xview::test
