// SPDX-License-Identifier: BSD-3-Clause
#include "match/sample_consensus.h"

#include <pcl/console/print.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
// Its code instead of the library, whose thousands of symbols took a third of the program's start.
#include <pcl/sample_consensus/impl/ransac.hpp>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace xview::match {
namespace {

constexpr int kMaxRefits = 5;

using Points = std::vector<Eigen::Vector3d>;

std::vector<Correspondence> finiteOnes(const Points& query, const Points& map,
                                       const std::vector<Correspondence>& correspondences) {
  std::vector<Correspondence> finite;
  for (const Correspondence& c : correspondences) {
    if (query[c.query].allFinite() && map[c.map].allFinite()) finite.push_back(c);
  }
  return finite;
}

/// Keeps PCL from writing to stderr that it found no model: to the caller that is a result. The
/// level is a global of PCL, so the first of several threads lowers it and the last one restores
/// it.
class QuietPcl {
 public:
  QuietPcl() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (users_++ > 0) return;
    level_ = pcl::console::getVerbosityLevel();
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  ~QuietPcl() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--users_ == 0) pcl::console::setVerbosityLevel(level_);
  }
  QuietPcl(const QuietPcl&) = delete;
  QuietPcl& operator=(const QuietPcl&) = delete;

 private:
  static inline std::mutex mutex_;
  static inline int users_ = 0;
  static inline pcl::console::VERBOSITY_LEVEL level_ = pcl::console::L_INFO;
};

bool hasThreePlaces(const Points& points) {
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3d& p : points) {
    const auto same = [&](const Eigen::Vector3d& q) { return (p - q).squaredNorm() < 1e-12; };
    if (std::none_of(places.begin(), places.end(), same)) places.push_back(p);
    if (places.size() == 3) return true;
  }
  return false;
}

Eigen::Vector3d meanOf(const Points& points) {
  const Eigen::Vector3d sum =
      std::accumulate(points.begin(), points.end(), Eigen::Vector3d::Zero().eval());
  return sum / static_cast<double>(points.size());
}

pcl::PointCloud<pcl::PointXYZ>::Ptr centredCloud(const Points& points,
                                                 const Eigen::Vector3d& mean) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3f q = (p - mean).cast<float>();
    cloud->push_back(pcl::PointXYZ(q.x(), q.y(), q.z()));
  }
  return cloud;
}

/// Source i belongs to target i. Nothing if PCL finds no pose.
std::optional<Eigen::Isometry3d> pclPose(const Points& source, const Points& target,
                                         const ConsensusOptions& options) {
  const Eigen::Vector3d source_mean = meanOf(source), target_mean = meanOf(target);
  pcl::Correspondences all, remaining;
  for (int i = 0; i < static_cast<int>(source.size()); ++i) all.emplace_back(i, i, 0.f);

  pcl::registration::CorrespondenceRejectorSampleConsensus<pcl::PointXYZ> rejector;
  rejector.setInputSource(centredCloud(source, source_mean));
  rejector.setInputTarget(centredCloud(target, target_mean));
  rejector.setInlierThreshold(options.inlier_m);
  rejector.setMaximumIterations(options.iterations);
  const QuietPcl quiet;
  rejector.getRemainingCorrespondences(all, remaining);
  const Eigen::Matrix4d T = rejector.getBestTransformation().cast<double>();
  if (!T.allFinite() || remaining.size() < 3) return std::nullopt;

  Eigen::Isometry3d centred = Eigen::Isometry3d::Identity();
  centred.linear() = Eigen::Quaterniond(T.topLeftCorner<3, 3>()).normalized().toRotationMatrix();
  centred.translation() = T.topRightCorner<3, 1>();
  return Eigen::Translation3d(target_mean) * centred * Eigen::Translation3d(-source_mean);
}

/// Least-squares pose of the correspondences.
Eigen::Isometry3d fit(const Points& query, const Points& map,
                      const std::vector<Correspondence>& correspondences) {
  Eigen::Matrix3Xd source(3, correspondences.size()), target(3, correspondences.size());
  for (Eigen::Index i = 0; i < source.cols(); ++i) {
    source.col(i) = query[correspondences[static_cast<std::size_t>(i)].query];
    target.col(i) = map[correspondences[static_cast<std::size_t>(i)].map];
  }
  return Eigen::Isometry3d(Eigen::umeyama(source, target, false));
}

}  // namespace

Consensus rejectBySampleConsensus(const Points& query, const Points& map,
                                  const std::vector<Correspondence>& correspondences,
                                  const ConsensusOptions& options) {
  const auto finite = finiteOnes(query, map, correspondences);
  Points source, target;
  for (const Correspondence& c : finite) {
    source.push_back(query[c.query]);
    target.push_back(map[c.map]);
  }
  Consensus result;
  if (!hasThreePlaces(source) || !hasThreePlaces(target)) return result;
  const auto pose = pclPose(source, target, options);
  if (!pose) return result;

  result.T_map_query = *pose;
  result.inliers = supporters(query, map, finite, *pose, options.inlier_m);
  for (int i = 0; i < kMaxRefits && result.inliers.size() >= 3; ++i) {
    const Eigen::Isometry3d refitted = fit(query, map, result.inliers);
    auto inliers = supporters(query, map, finite, refitted, options.inlier_m);
    if (inliers.size() < result.inliers.size()) break;
    const bool grown = inliers.size() > result.inliers.size();
    result.T_map_query = refitted;
    result.inliers = std::move(inliers);
    if (!grown) break;
  }
  result.found = result.inliers.size() >= static_cast<std::size_t>(options.min_inliers);
  return result.found ? result : Consensus();
}

std::vector<Correspondence> supporters(const Points& query, const Points& map,
                                       const std::vector<Correspondence>& correspondences,
                                       const Eigen::Isometry3d& T_map_query, double inlier_m) {
  std::vector<std::pair<double, Correspondence>> near;  // by squared distance
  for (const Correspondence& c : correspondences) {
    const double distance2 = (map[c.map] - T_map_query * query[c.query]).squaredNorm();
    if (distance2 <= inlier_m * inlier_m) near.emplace_back(distance2, c);
  }
  std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.query, a.second.map) <
           std::tie(b.first, b.second.query, b.second.map);
  });
  std::vector<bool> query_used(query.size(), false), map_used(map.size(), false);
  std::vector<Correspondence> kept;
  for (const auto& [distance2, c] : near) {
    if (query_used[c.query] || map_used[c.map]) continue;
    query_used[c.query] = map_used[c.map] = true;
    kept.push_back(c);
  }
  std::sort(kept.begin(), kept.end(),
            [](const Correspondence& a, const Correspondence& b) { return a.query < b.query; });
  return kept;
}

}  // namespace xview::match
