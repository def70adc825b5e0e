// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/blobs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace xview::graph {
namespace {

/// Points of one class (and instance) and where they were in the cloud.
struct PointGroup {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> indices;
};

using GroupKey = std::pair<std::uint32_t, std::uint32_t>;  // label, instance

std::map<GroupKey, PointGroup> groupPoints(const LabelledCloud& cloud, const LabelSet& set) {
  std::map<GroupKey, PointGroup> groups;
  GroupKey last_key;
  PointGroup* last = nullptr;  // neighbouring points mostly share their group
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const Point& point = cloud.points[i];
    if (set.role(point.label) == Role::ignored) continue;
    const GroupKey key(point.label, point.instance);
    if (!last || key != last_key) {
      last_key = key;
      last = &groups[key];
    }
    last->points.push_back(point.getVector3fMap());
    last->indices.push_back(i);
  }
  return groups;
}

/// Moments of the points of one blob, relative to the first of them.
struct Moments {
  Eigen::Vector3f first = Eigen::Vector3f::Zero();
  Eigen::Vector3f min = Eigen::Vector3f::Zero(), max = Eigen::Vector3f::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  std::uint32_t points = 0;
  std::uint32_t first_index = 0;  ///< in the cloud

  void add(const Eigen::Vector3f& p, std::uint32_t index) {
    if (points == 0) {
      first = min = max = p;
      first_index = index;
    }
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
    const Eigen::Vector3d d = (p - first).cast<double>();
    sum += d;
    squares += d * d.transpose();
    ++points;
  }

  Blob blob(const GroupKey& key, const Eigen::Vector3d& origin) const {
    Blob result;
    result.label = key.first;
    result.instance = key.second;
    const Eigen::Vector3d mean = sum / points;
    result.position = origin + first.cast<double>() + mean;
    result.covariance = squares / points - mean * mean.transpose();
    result.min = origin + min.cast<double>();
    result.max = origin + max.cast<double>();
    result.points = points;
    return result;
  }
};

/// How many points a cluster of one kind needs.
class Threshold {
 public:
  Threshold(const BlobOptions& options, const ScanView& scan, const Eigen::Vector3d& origin,
            Kind kind)
      : min_points_(options.min_points),
        beams_(isThin(kind) ? scan.beams : BeamSpacing()),
        sensor_((scan.T_cloud_sensor.translation() - origin).cast<float>()) {}

  /// `sum` is that of the distances of its points to the sensor.
  bool isMet(int points, double sum_m) const {
    return points >= min_points_ ||
           (points > 0 && points >= pointsOfThinThing(sum_m / points, beams_, min_points_));
  }
  double distance(const Eigen::Vector3f& p) const { return (p - sensor_).norm(); }

 private:
  static bool isThin(Kind kind) {
    return isPoleLike(kind) || kind == Kind::trunk || kind == Kind::other_object;
  }

  int min_points_;
  BeamSpacing beams_;
  Eigen::Vector3f sensor_;
};

/// Drops clusters with too few points. Numbers are those of order of first points afterwards.
template <class Cluster, class ClusterOf>
void dropSmall(const std::vector<Eigen::Vector3f>& points, const Threshold& threshold,
               ClusterOf&& cluster_of, std::vector<int>& cluster_of_point) {
  struct Size {
    int points = 0;
    double distances_m = 0;
  };
  std::map<Cluster, Size> sizes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cluster_of_point[i] < 0) continue;
    Size& size = sizes[cluster_of(i)];
    ++size.points;
    size.distances_m += threshold.distance(points[i]);
  }
  std::map<Cluster, int> number;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cluster_of_point[i] < 0) continue;
    const Size& size = sizes.at(cluster_of(i));
    const bool is_kept = threshold.isMet(size.points, size.distances_m);
    const auto next = static_cast<int>(number.size());
    cluster_of_point[i] = is_kept ? number.emplace(cluster_of(i), next).first->second : -1;
  }
}

/// Drops clusters of fewer than `whole` points beside a larger one: they are parts of it that
/// leaves or cars in front cut off. Numbers stay in the order of first points.
void dropFragments(const std::vector<Eigen::Vector3f>& points, int whole,
                   std::vector<int>& cluster_of_point) {
  constexpr float kBeside_m = 1.5f;
  struct Extent {
    Eigen::AlignedBox3f box;
    int points = 0;
  };
  std::vector<Extent> extents;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cluster_of_point[i] < 0) continue;
    const auto cluster = static_cast<std::size_t>(cluster_of_point[i]);
    if (cluster == extents.size()) extents.emplace_back();
    extents[cluster].box.extend(points[i]);
    ++extents[cluster].points;
  }
  const auto isFragment = [&](const Extent& e) {
    return e.points < whole &&
           std::any_of(extents.begin(), extents.end(), [&](const Extent& other) {
             return other.points > e.points && other.box.exteriorDistance(e.box) < kBeside_m;
           });
  };
  std::vector<int> number;
  int kept = 0;
  for (const Extent& e : extents) number.push_back(isFragment(e) ? -1 : kept++);
  for (int& cluster : cluster_of_point) {
    if (cluster >= 0) cluster = number[static_cast<std::size_t>(cluster)];
  }
}

/// Clusters of the points of one scan.
std::vector<int> scanClusters(const std::vector<Eigen::Vector3f>& points,
                              const Eigen::Vector3d& origin, const BlobOptions& options,
                              const ScanView& scan, const Threshold& threshold) {
  const auto tolerance_m = static_cast<float>(options.tolerance_m);
  std::vector<int> cluster_of_point = euclideanClusters(points, tolerance_m, 1);
  const Eigen::Isometry3f T_sensor_points =
      (scan.T_cloud_sensor.inverse() * Eigen::Translation3d(origin)).cast<float>();
  std::vector<Eigen::Vector3f> in_sensor;
  in_sensor.reserve(points.size());
  for (const Eigen::Vector3f& p : points) in_sensor.push_back(T_sensor_points * p);
  joinAlongBeams(in_sensor, scan.beams, tolerance_m, cluster_of_point);
  dropSmall<int>(
      points, threshold, [&](std::size_t i) { return cluster_of_point[i]; }, cluster_of_point);
  dropFragments(points, options.min_points, cluster_of_point);
  return cluster_of_point;
}

/// Cuts clusters that spread too far into squares. Numbers stay in the order of first points.
void cutIntoSquares(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3d& origin,
                    const BlobOptions& options, const Threshold& threshold,
                    std::vector<int>& cluster_of_point) {
  std::map<int, Eigen::AlignedBox2f> bounds;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cluster_of_point[i] >= 0) bounds[cluster_of_point[i]].extend(points[i].head<2>());
  }
  const auto square = [&](float p, double shift) {
    return static_cast<std::int64_t>(std::floor((p + shift) / options.max_surface_m));
  };
  using Piece = std::tuple<int, std::int64_t, std::int64_t>;  // cluster, square
  std::vector<Piece> piece_of_point(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int cluster = cluster_of_point[i];
    if (cluster < 0) continue;
    const bool is_cut = bounds.at(cluster).sizes().maxCoeff() > options.max_surface_m;
    piece_of_point[i] = is_cut ? Piece{cluster, square(points[i].x(), origin.x()),
                                       square(points[i].y(), origin.y())}
                               : Piece{cluster, 0, 0};
  }
  dropSmall<Piece>(
      points, threshold, [&](std::size_t i) { return piece_of_point[i]; }, cluster_of_point);
}

struct FoundBlob {
  Blob blob;
  std::uint32_t first_point;
  int number;  ///< in order of discovery
};

}  // namespace

std::vector<Blob> extractBlobs(const LabelledCloud& cloud, const LabelSet& set,
                               const BlobOptions& options, std::vector<int>* blob_of_point,
                               const ScanView& scan) {
  std::vector<int> found_of_point(cloud.size(), -1);
  std::vector<FoundBlob> found;
  for (const auto& [key, group] : groupPoints(cloud, set)) {
    const Threshold threshold(options, scan, cloud.origin, set.kind(key.first));
    std::vector<int> cluster_of_point =
        scan.beams.isKnown()
            ? scanClusters(group.points, cloud.origin, options, scan, threshold)
            : euclideanClusters(group.points, static_cast<float>(options.tolerance_m),
                                options.min_points);
    if (options.max_surface_m > 0 && set.role(key.first) == Role::surface)
      cutIntoSquares(group.points, cloud.origin, options, threshold, cluster_of_point);
    std::vector<Moments> moments;
    const int first_number = static_cast<int>(found.size());
    for (std::size_t i = 0; i < group.points.size(); ++i) {
      const int cluster = cluster_of_point[i];
      if (cluster < 0) continue;
      if (static_cast<std::size_t>(cluster) == moments.size()) moments.emplace_back();
      moments[static_cast<std::size_t>(cluster)].add(group.points[i], group.indices[i]);
      found_of_point[group.indices[i]] = first_number + cluster;
    }
    for (const Moments& m : moments) {
      found.push_back({m.blob(key, cloud.origin), m.first_index, static_cast<int>(found.size())});
    }
  }
  std::sort(found.begin(), found.end(), [](const FoundBlob& a, const FoundBlob& b) {
    return std::make_pair(a.blob.label, a.first_point) <
           std::make_pair(b.blob.label, b.first_point);
  });

  std::vector<Blob> blobs;
  blobs.reserve(found.size());
  std::vector<int> rank(found.size());
  for (const FoundBlob& f : found) {
    rank[static_cast<std::size_t>(f.number)] = static_cast<int>(blobs.size());
    blobs.push_back(f.blob);
  }
  if (blob_of_point) {
    for (int& b : found_of_point) b = b < 0 ? -1 : rank[static_cast<std::size_t>(b)];
    *blob_of_point = std::move(found_of_point);
  }
  return blobs;
}

}  // namespace xview::graph
