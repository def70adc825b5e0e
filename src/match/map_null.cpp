// SPDX-License-Identifier: BSD-3-Clause
#include "match/map_null.h"

#include <cmath>
#include <map>
#include <set>

#include "xview/types/random.h"

namespace xview {
namespace {

constexpr int kDraws = 300;
constexpr double kSight_m = 30, kApart_m = 25;
constexpr double kBlock_m = 2;  ///< samples are thinned to one per block
constexpr std::uint64_t kSeed = 11;

double headingAt(const std::vector<Eigen::Vector2d>& path, std::size_t i) {
  const Eigen::Vector2d d = path[i + 1] - path[i - 1];
  return std::atan2(d.y(), d.x());
}

/// Samples of a channel by 30 m block, thinned.
class NearbySamples {
 public:
  explicit NearbySamples(const std::vector<PlanSample>& samples) {
    std::set<std::pair<int, int>> taken;
    for (const PlanSample& s : samples) {
      const std::pair<int, int> thin{static_cast<int>(std::floor(s.x / kBlock_m)),
                                     static_cast<int>(std::floor(s.y / kBlock_m))};
      if (taken.insert(thin).second) blocks_[blockOf(s.x, s.y)].push_back(s);
    }
  }
  template <class Body>
  void around(const Eigen::Vector2d& p, Body&& body) const {
    const auto [bx, by] = blockOf(p.x(), p.y());
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto it = blocks_.find({bx + dx, by + dy});
        if (it == blocks_.end()) continue;
        for (const PlanSample& s : it->second) {
          const double x = s.x - p.x(), y = s.y - p.y();
          if (x * x + y * y <= kSight_m * kSight_m) body(x, y);
        }
      }
    }
  }

 private:
  static std::pair<int, int> blockOf(double x, double y) {
    return {static_cast<int>(std::floor(x / kSight_m)), static_cast<int>(std::floor(y / kSight_m))};
  }
  std::map<std::pair<int, int>, std::vector<PlanSample>> blocks_;
};

struct WrongPose {
  Eigen::Vector2d from, to;
  double yaw;
};

std::vector<WrongPose> drawWrongPoses(const std::vector<Eigen::Vector2d>& path) {
  std::vector<WrongPose> poses;
  Random random(kSeed);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::size_t j = 1 + random.below(static_cast<std::uint32_t>(path.size() - 2));
    const std::size_t i = 1 + random.below(static_cast<std::uint32_t>(path.size() - 2));
    const Eigen::Vector2d jitter(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5));
    const double yaw =
        headingAt(path, i) - headingAt(path, j) + (draw % 2 ? M_PI : 0) + random.uniform(-.03, .03);
    if ((path[i] - path[j]).norm() >= kApart_m) poses.push_back({path[j], path[i] + jitter, yaw});
  }
  return poses;
}

}  // namespace

MapNull mapNull(const PlanView& map, const std::vector<Eigen::Vector2d>& path,
                const PlanField& field) {
  MapNull null{};
  if (path.size() < 4) return null;
  const std::vector<WrongPose> poses = drawWrongPoses(path);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const NearbySamples samples(map.samples[c]);
    for (const WrongPose& pose : poses) {
      const double cosine = std::cos(pose.yaw), sine = std::sin(pose.yaw);
      samples.around(pose.from, [&](double x, double y) {
        const double px = pose.to.x() + cosine * x - sine * y,
                     py = pose.to.y() + sine * x + cosine * y;
        const std::uint8_t bin =
            field.bin(c, static_cast<std::int32_t>(std::floor(px / field.cellSize())),
                      static_cast<std::int32_t>(std::floor(py / field.cellSize())));
        if (bin < kDistanceBins) ++null[c][bin];
      });
    }
  }
  return null;
}

}  // namespace xview
