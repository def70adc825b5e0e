// SPDX-License-Identifier: BSD-3-Clause
#include "compare/likelihood_learning.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/pose.h"
#include "base/random.h"
#include "place/bev_grid.h"
#include "place/gravity.h"
#include "search/distance_field.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"

namespace xview {
namespace {

constexpr int kWrongPoses = 12;  ///< per window
constexpr double kApart_m = 25;
constexpr double kThinning_m = 1;  ///< surface samples are thinned to one per block
constexpr std::uint64_t kLearningSeed = 5;

/// Positions along a recording with the direction of travel.
struct Travel {
  std::vector<Eigen::Vector2d> positions;
  double headingAt(std::size_t i) const {
    const std::size_t at = std::clamp<std::size_t>(i, 1, positions.size() - 2);
    const Eigen::Vector2d d = positions[at + 1] - positions[at - 1];
    return std::atan2(d.y(), d.x());
  }
};

/// The turn that takes a window upright, as a query is turned; where the window does not tell, its
/// true pose does, which brings it to the upright frame of the map.
Eigen::Isometry3d alignmentOf(const PreprocessedFrame* first, const PreprocessedFrame* last,
                              const LabelSet& labels, const std::string& mode,
                              const Eigen::Isometry3d& T_aligned_query) {
  std::vector<PlaceBuilder::SharedFrame> frames;
  for (const PreprocessedFrame* f = first; f != last; ++f)
    frames.emplace_back(PlaceBuilder::SharedFrame(), f);  // owned by the caller, who waits
  const Gravity gravity = gravityOf(frames, labels, mode);
  if (gravity.known) return Eigen::Isometry3d(gravity.alignment);
  return Eigen::Isometry3d(
      alignmentFromUp(T_aligned_query.linear().transpose() * Eigen::Vector3d::UnitZ()));
}

/// The BEV grid of frames that `upright` turns.
BevGrid bevOf(const PreprocessedFrame* first, const PreprocessedFrame* last, const LabelSet& labels,
              const Eigen::Isometry3d& upright) {
  BevGridBuilder builder(labels);
  for (const PreprocessedFrame* f = first; f != last; ++f)
    builder.add(f->cloud, f->weights, f->resolves_thin, upright, f->aerial);
  return builder.build();
}

/// Calls body(x, y) for the samples of a channel in the query frame, surfaces thinned.
template <class Body>
void forEachSample(const BevGrid& view, std::size_t channel, Body&& body) {
  std::set<std::pair<int, int>> taken;
  for (const BevSample& s : view.samples[channel]) {
    const std::pair<int, int> block{static_cast<int>(std::floor(s.x / kThinning_m)),
                                    static_cast<int>(std::floor(s.y / kThinning_m))};
    if (!isObject(static_cast<BevChannel>(channel)) && !taken.insert(block).second) continue;
    body(view.origin_x + s.x, view.origin_y + s.y);
  }
}

void countAt(const search::DistanceField& field, const BevGrid& view,
             const Eigen::Isometry3d& T_map_query, double height, std::size_t channel,
             std::array<double, search::kDistanceBins>& counts) {
  forEachSample(view, channel, [&](double x, double y) {
    const Eigen::Vector3d p = T_map_query * Eigen::Vector3d(x, y, height);
    const std::uint8_t bin = field.binAt(channel, p.x() - field.originX(), p.y() - field.originY());
    if (bin < search::kDistanceBins) ++counts[bin];
  });
}

std::vector<Eigen::Isometry3d> wrongPoses(const Travel& map, const Travel& query,
                                          std::size_t middle,
                                          const Eigen::Isometry3d& T_query_sensor,
                                          const Eigen::Vector3d& truth, Random& random) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < kWrongPoses; ++i) {
    std::size_t at = 0;
    for (int tries = 0; tries < 50; ++tries) {
      at = random.below(static_cast<std::uint32_t>(map.positions.size()));
      if ((map.positions[at] - truth.head<2>()).norm() >= kApart_m) break;
    }
    const double yaw = map.headingAt(at) - query.headingAt(middle) + (i % 2 ? M_PI : 0) +
                       random.uniform(-.05, .05);
    const Eigen::Vector2d goal =
        map.positions[at] + Eigen::Vector2d(random.uniform(-2, 2), random.uniform(-2, 2));
    Eigen::Isometry3d T = poseFromYaw({goal.x(), goal.y(), 0}, yaw);
    T.translation().head<2>() -= (T.linear() * T_query_sensor.translation()).head<2>();
    poses.push_back(T);
  }
  return poses;
}

}  // namespace

search::LikelihoodTable learnLikelihoods(const map::SemanticMap& given,
                                         const std::vector<PreprocessedFrame>& frames,
                                         std::vector<Eigen::Isometry3d> T_map_sensor,
                                         double window_m, const Options& options) {
  if (T_map_sensor.size() != frames.size())
    throw UsageError("learnLikelihoods() needs one pose per frame");
  if (!(window_m > 0)) throw UsageError("window_m must be > 0");
  const Scaled<map::SemanticMap> canonical(given, 1 / given.size);
  const map::SemanticMap& map = *canonical;
  for (Eigen::Isometry3d& T : T_map_sensor) scaleLengths(1 / given.size, T);
  window_m /= given.size;
  search::LikelihoodTable table;
  if (frames.size() < 3 || map.poses.size() < 3) return table;
  const search::DistanceField field(map.bev);
  // Views from above are drawn upright, so everything is compared in upright frames.
  const Eigen::Isometry3d T_aligned_map(map.bev.alignment);
  for (Eigen::Isometry3d& T : T_map_sensor) T = T_aligned_map * T;
  Travel map_travel;
  for (const Eigen::Isometry3d& T : map.poses)
    map_travel.positions.push_back((T_aligned_map * T.translation()).head<2>());
  std::vector<Eigen::Isometry3d> T_odom_sensor;
  for (const PreprocessedFrame& frame : frames) T_odom_sensor.push_back(frame.T_odom_sensor);
  const std::vector<double> distance = pathLengths(T_odom_sensor);
  Random random(kLearningSeed);
  for (double from = 0; from + window_m <= distance.back() + 1; from += window_m / 3) {
    const auto first = static_cast<std::size_t>(
        std::lower_bound(distance.begin(), distance.end(), from) - distance.begin());
    const auto last = static_cast<std::size_t>(
        std::upper_bound(distance.begin(), distance.end(), from + window_m) - distance.begin());
    const std::size_t middle = std::min((first + last) / 2, frames.size() - 1);
    const Eigen::Isometry3d T_map_odom = T_map_sensor[middle] * T_odom_sensor[middle].inverse();
    const Eigen::Isometry3d upright = alignmentOf(frames.data() + first, frames.data() + last,
                                                  map.labels, options.gravity, T_map_odom);
    const BevGrid view = bevOf(frames.data() + first, frames.data() + last, map.labels, upright);
    const Eigen::Isometry3d T_true = T_map_odom * upright.inverse();
    const Eigen::Isometry3d T_query_sensor = upright * T_odom_sensor[middle];
    const double height = T_query_sensor.translation().z();
    Travel query_travel;
    for (const Eigen::Isometry3d& T : T_odom_sensor)
      query_travel.positions.push_back((upright * T.translation()).head<2>());
    const auto wrong = wrongPoses(map_travel, query_travel, middle, T_query_sensor,
                                  T_map_sensor[middle].translation(), random);
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      search::DistanceCounts& counts =
          table.at(search::viewpointOf(view.aerial, map.bev.aerial), static_cast<BevChannel>(c));
      countAt(field, view, T_true, height, c, counts.at_true);
      for (const Eigen::Isometry3d& T : wrong) countAt(field, view, T, height, c, counts.at_wrong);
    }
  }
  return table;
}

}  // namespace xview
