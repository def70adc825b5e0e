// SPDX-License-Identifier: BSD-3-Clause
#include "place/blobs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace xview {
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

/// Cuts clusters that spread too far into squares and drops those with too few points. Numbers stay
/// in the order of first points.
void cutIntoSquares(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3d& origin,
                    const BlobOptions& options, std::vector<int>& cluster_of_point) {
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
  std::map<Piece, int> sizes, number;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cluster_of_point[i] >= 0) ++sizes[piece_of_point[i]];
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cluster_of_point[i] < 0) continue;
    const bool is_kept = sizes.at(piece_of_point[i]) >= options.min_points;
    const auto next = static_cast<int>(number.size());
    cluster_of_point[i] = is_kept ? number.emplace(piece_of_point[i], next).first->second : -1;
  }
}

struct FoundBlob {
  Blob blob;
  std::uint32_t first_point;
  int number;  ///< in order of discovery
};

}  // namespace

std::vector<Blob> extractBlobs(const LabelledCloud& cloud, const LabelSet& set,
                               const BlobOptions& options, std::vector<int>* blob_of_point) {
  std::vector<int> found_of_point(cloud.size(), -1);
  std::vector<FoundBlob> found;
  for (const auto& [key, group] : groupPoints(cloud, set)) {
    std::vector<int> cluster_of_point = euclideanClusters(
        group.points, static_cast<float>(options.tolerance_m), options.min_points);
    if (options.max_surface_m > 0 && set.role(key.first) == Role::surface)
      cutIntoSquares(group.points, cloud.origin, options, cluster_of_point);
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

}  // namespace xview
