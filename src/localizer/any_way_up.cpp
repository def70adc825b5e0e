// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/any_way_up.h"

#include <utility>

#include "map/contents.h"
#include "place/gravity.h"
#include "place/shapes_any_way_up.h"
#include "xview/place_builder.h"

namespace xview {
namespace {

/// Side of a voxel, in canonical lengths: 10 cm in a room. Where the map has more of them than
/// kManyVoxels they are larger; of the largest ones there may be kMostVoxels.
constexpr double kVoxel_m = 0.4, kLargest_m = 0.81, kCoarser = 1.26;
constexpr std::size_t kManyVoxels = 8000, kMostVoxels = 13000, kMostPoints = 300000;
constexpr std::size_t kMostPoses = 3;
constexpr double kLeastOnMap = 0.05;   ///< a pose with less is none (FeaturePose::share)
constexpr double kUpSigma_rad = 0.03;  ///< of such a pose

std::vector<Eigen::Vector3d> positionsOf(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Isometry3d& T : poses) positions.push_back(T.translation());
  return positions;
}

}  // namespace

const match::FeatureCloud* FeatureIndex::ofMap() const {
  std::call_once(made_, [&] {
    const std::size_t points = map::countsOf(map_).points;
    if (points == 0 || points > kMostPoints) return;
    LabelledCloud all;
    all.origin = map_.cloud.origin;
    const auto add = [&](const LabelledCloud& some) {
      all.points.insert(all.points.end(), some.points.begin(), some.points.end());
    };
    map::forPoints(
        map_, [](const PlaneCell&) { return true; }, add);
    const std::vector<Eigen::Vector3d> seen_from = positionsOf(map_.poses);
    for (double voxel_m = kVoxel_m; voxel_m <= kLargest_m; voxel_m *= kCoarser) {
      const bool is_largest = voxel_m * kCoarser > kLargest_m;
      if (match::voxelCount(all, voxel_m) > (is_largest ? kMostVoxels : kManyVoxels)) continue;
      of_map_.emplace(all, seen_from, voxel_m, threads_);
      return;
    }
  });
  return of_map_ ? &*of_map_ : nullptr;
}

bool FeatureIndex::takes(const Query& query) const {
  if (map_.size == kTownScale && query.sensor != Sensor::cloud) return false;
  if (query.cloud.empty() || query.cloud.size() > kMostPoints) return false;
  const match::FeatureCloud* of_map = ofMap();
  return of_map && match::voxelCount(query.cloud, of_map->voxel()) <= kMostVoxels;
}

match::FeatureCloud FeatureIndex::described(const Query& query) const {
  return {query.cloud, positionsOf(query.poses), ofMap()->voxel(), threads_};
}

std::vector<match::FeaturePose> FeatureIndex::propose(const match::FeatureCloud& query) const {
  std::vector<match::FeaturePose> poses = match::matchFeatures(query, *ofMap(), kMostPoses);
  if (!poses.empty() && poses[0].share < kLeastOnMap) poses.clear();
  return poses;
}

Query standingQuery(const Query& given, const Eigen::Vector3d& up, const Options& options) {
  Query query = given;
  query.newest.reset();
  query.gravity.known = true;
  query.gravity.alignment = alignmentFromUp(up);
  query.gravity.sigma_rad = kUpSigma_rad;
  query.gravity.reason = "up is that of the map, by local features";

  Frame frame;
  frame.sensor = Sensor::cloud;
  frame.T_odom_sensor = query.poses.back();
  const Eigen::Isometry3d T_sensor_query = frame.T_odom_sensor.inverse();
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    Point point = query.cloud.points[i];
    point.getVector3fMap() = (T_sensor_query * query.cloud.position(i)).cast<float>();
    frame.cloud.points.push_back(point);
  }
  if (knowsShapesOnly(query.labels)) {
    labelTurned(alignmentFromUp(up) * frame.T_odom_sensor.linear(), query.size, frame.cloud.points);
    for (std::size_t i = 0; i < query.cloud.size(); ++i)
      query.cloud.points[i].label = frame.cloud.points[i].label;
  }
  Options sized = options;
  sized.size = sizeText(query.size);
  sized.odometry.check = false;
  sized.graph_space = "cloud";
  PlaceBuilder builder(query.labels, sized, PlaceUse::query, 1);
  builder.setGravity(query.gravity);
  builder.add(preprocessFrame(std::move(frame), query.labels, sized));
  Query built = builder.finish();
  query.bev = std::move(built.bev);
  query.graph = std::move(built.graph);
  return query;
}

}  // namespace xview
