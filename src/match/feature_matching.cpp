// SPDX-License-Identifier: BSD-3-Clause
#include "match/feature_matching.h"

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/median.h"
#include "base/parallel.h"
#include "match/consistency.h"
#include "match/point_features.h"
#include "place/lift.h"
#include "process/module.h"
#include "xview/base/budget.h"

namespace xview::match {
namespace {

using NormalCloud = pcl::PointCloud<pcl::PointNormal>;
using Features = pcl::PointCloud<pcl::FPFHSignature33>;
using PointTree = pcl::KdTreeFLANN<pcl::PointNormal>;
using FeatureTree = pcl::KdTreeFLANN<pcl::FPFHSignature33>;

/// In sides of a voxel: radii of normals and features, how far points may lie from their partners
/// at first and at last, and how well two matches must agree in length.
constexpr double kNormalRadius = 2.5, kFeatureRadius = 5.5;
constexpr double kFirstGate = 3, kLastGate = 1;
constexpr double kLengthTolerance = 1.5;
constexpr std::size_t kProposed = 10, kRefined = 5;  ///< poses, of which the likeliest are refined
constexpr double kSamePose = 3;                      ///< poses that differ by less are one
constexpr std::size_t kIcpPoints = 1500;             ///< of the query
constexpr int kIcpIterations = 15, kIcpNarrowing = 9;  ///< at most, and those of wider gates
constexpr double kIcpStill = 1e-3;   ///< a step that ends it, in sides of a voxel and radians
constexpr double kTurnedAway = 0.7;  ///< least cosine between normals of partners in ICP
/// What lies on a surface of the map: partner and its plane in sides of a voxel, cosine between
/// normals.
constexpr double kPartner = 1.5, kOnPlane = 0.25, kFacesAlike = 0.85;
constexpr Eigen::Index kBins = 33;    ///< of a feature
constexpr double kFewNormals = 0.02;  ///< share of a query that says little about a direction

Eigen::Vector3d pointOf(const pcl::PointNormal& p) { return {p.x, p.y, p.z}; }
Eigen::Vector3d normalOf(const pcl::PointNormal& p) { return {p.normal_x, p.normal_y, p.normal_z}; }

/// One point per voxel, without normals.
NormalCloud thinned(const LabelledCloud& cloud, double voxel) {
  LabelledCloud of_one_class = cloud;
  for (Point& p : of_one_class.points) p.label = 0;
  NormalCloud thin;
  for (const Point& p : thinByVoxel(of_one_class, voxel).points) {
    thin.emplace_back();
    thin.back().x = p.x;
    thin.back().y = p.y;
    thin.back().z = p.z;
  }
  return thin;
}

/// PCL's features bring many libraries along, which most queries do not need.
template <class Function>
Function ofModule(const char* name) {
  return reinterpret_cast<Function>(moduleFunction("xview_features", name, "local features"));
}

Eigen::MatrixXf columnsOf(const Features& features) {
  Eigen::MatrixXf columns(kBins, static_cast<Eigen::Index>(features.size()));
  for (std::size_t i = 0; i < features.size(); ++i)
    columns.col(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::VectorXf>(features[i].histogram, kBins);
  return columns;
}

Features::Ptr cloudOf(const Eigen::MatrixXf& columns) {
  Features::Ptr features(new Features(static_cast<std::uint32_t>(columns.cols()), 1));
  for (std::size_t i = 0; i < features->size(); ++i)
    Eigen::Map<Eigen::VectorXf>((*features)[i].histogram, kBins) =
        columns.col(static_cast<Eigen::Index>(i));
  return features;
}

}  // namespace

struct FeatureCloud::Content {
  /// Makes the trees.
  void index();
  /// Of each feature, a column, the nearest one of this cloud.
  std::vector<int> nearestTo(const Eigen::MatrixXf& others) const;

  Eigen::Vector3d origin;
  NormalCloud::Ptr points{new NormalCloud};
  PointTree tree;            ///< of the points
  Eigen::MatrixXf features;  ///< a column for each point
  Eigen::MatrixXf axes;      ///< principal ones of the features
  FeatureTree feature_tree;  ///< along these: a tree asks fewer of them than along the bins
  int threads = 1;
};

void FeatureCloud::Content::index() {
  if (points->empty()) return;
  tree.setInputCloud(points);
  const Eigen::VectorXf mean = features.rowwise().mean();
  const Eigen::MatrixXf off = features.colwise() - mean;
  const Eigen::MatrixXf scatter = off * off.transpose();
  axes = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf>(scatter).eigenvectors();
  feature_tree.setInputCloud(cloudOf(axes.transpose() * features));
}

std::vector<int> FeatureCloud::Content::nearestTo(const Eigen::MatrixXf& others) const {
  const Features::ConstPtr along_axes = cloudOf(axes.transpose() * others);
  std::vector<int> nearest(along_axes->size());
  parallelFor(nearest.size(), threads, [&](std::size_t i) {
    pcl::Indices index(1);
    std::vector<float> squared(1);
    feature_tree.nearestKSearch((*along_axes)[i], 1, index, squared);
    nearest[i] = index[0];
  });
  return nearest;
}

FeatureCloud::FeatureCloud(const LabelledCloud& cloud,
                           const std::vector<Eigen::Vector3d>& view_points, double voxel,
                           int threads)
    : voxel_(voxel) {
  auto content = std::make_unique<Content>();
  content->origin = cloud.origin;
  content->threads = threads;
  askBudget("local features");
  static const auto find_normals = ofModule<decltype(&xviewNormals)>("xviewNormals");
  static const auto describe = ofModule<decltype(&xviewPointFeatures)>("xviewPointFeatures");
  NormalCloud thin = thinned(cloud, voxel);
  if (!thin.empty()) find_normals(kNormalRadius * voxel, thin);
  for (pcl::PointNormal& p : thin) {
    if (!std::isfinite(p.normal_x)) continue;
    Eigen::Vector3d towards = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& eye : view_points) {
      const Eigen::Vector3d ray = eye - cloud.origin - pointOf(p);
      if (towards.isZero() || ray.squaredNorm() < towards.squaredNorm()) towards = ray;
    }
    if (towards.dot(normalOf(p)) < 0) {
      p.normal_x *= -1;
      p.normal_y *= -1;
      p.normal_z *= -1;
    }
    content->points->push_back(p);
  }
  if (!content->points->empty()) {
    Features features;
    describe(*content->points, kFeatureRadius * voxel, features);
    content->features = columnsOf(features);
  }
  content->index();
  content_ = std::move(content);
}

FeatureCloud::FeatureCloud(double voxel, std::unique_ptr<const Content> content)
    : voxel_(voxel), content_(std::move(content)) {}
FeatureCloud::FeatureCloud(FeatureCloud&&) noexcept = default;

FeatureCloud FeatureCloud::mirrored() const {
  auto content = std::make_unique<Content>();
  content->origin = content_->origin;
  content->origin.y() *= -1;
  *content->points = *content_->points;
  for (pcl::PointNormal& p : *content->points) {
    p.y *= -1;
    p.normal_y *= -1;
  }
  // Of the three angles between two points that a histogram counts, only the second, alpha, changes
  // its sign with the handedness.
  content->features = content_->features;
  content->features.middleRows(kBins / 3, kBins / 3) =
      content_->features.middleRows(kBins / 3, kBins / 3).colwise().reverse();
  content->threads = content_->threads;
  content->index();
  return FeatureCloud(voxel_, std::move(content));
}

std::size_t voxelCount(const LabelledCloud& cloud, double voxel) {
  return thinned(cloud, voxel).size();
}

FeatureCloud::~FeatureCloud() = default;

namespace {

/// A point of a query beside the surface of the map that is nearest to it.
struct Partner {
  Eigen::Vector3d point, normal;  ///< of the query, where the pose puts it; of the map
  double off_plane = 0;           ///< from its plane, along the normal
  double cosine = 0;              ///< between the normals, whichever side they show
};

template <class Visit>
void forPartners(const NormalCloud& query, const NormalCloud& map, const PointTree& tree,
                 const Eigen::Isometry3d& T_map_query, double reach, Visit&& visit) {
  pcl::Indices index(1);
  std::vector<float> squared(1);
  for (const pcl::PointNormal& q : query) {
    Partner partner;
    partner.point = T_map_query * pointOf(q);
    pcl::PointNormal at;
    at.x = static_cast<float>(partner.point.x());
    at.y = static_cast<float>(partner.point.y());
    at.z = static_cast<float>(partner.point.z());
    if (tree.nearestKSearch(at, 1, index, squared) == 0 || squared[0] > reach * reach) continue;
    const pcl::PointNormal& m = map[static_cast<std::size_t>(index[0])];
    partner.normal = normalOf(m);
    partner.off_plane = partner.normal.dot(partner.point - pointOf(m));
    partner.cosine = std::abs(partner.normal.dot(T_map_query.linear() * normalOf(q)));
    visit(partner);
  }
}

/// Point-to-plane ICP with a gate that narrows, robust by Cauchy weights.
Eigen::Isometry3d refined(const NormalCloud& query, const NormalCloud& map, const PointTree& tree,
                          double voxel, Eigen::Isometry3d T) {
  for (int round = 0; round < kIcpIterations; ++round) {
    const double narrowed = std::min(1.0, static_cast<double>(round) / kIcpNarrowing);
    const double gate = voxel * kFirstGate * std::pow(kLastGate / kFirstGate, narrowed);
    Eigen::Matrix<double, 6, 6> H = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    forPartners(query, map, tree, T, gate, [&](const Partner& partner) {
      if (partner.cosine < kTurnedAway) return;
      Eigen::Matrix<double, 6, 1> J;
      J << partner.normal, partner.point.cross(partner.normal);
      const double off = 2 * partner.off_plane / gate, weight = 1 / (1 + off * off);
      H += weight * J * J.transpose();
      b -= weight * partner.off_plane * J;
    });
    const Eigen::Matrix<double, 6, 1> step = H.ldlt().solve(b);
    const double angle = step.tail<3>().norm();
    Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
    if (angle > 0) move.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle).matrix();
    move.translation() = step.head<3>();
    T = move * T;
    if (round >= kIcpNarrowing && step.head<3>().norm() < kIcpStill * voxel && angle < kIcpStill)
      break;
  }
  return T;
}

/// See FeaturePose::share.
double shareOnMap(const Eigen::Isometry3d& T, const NormalCloud& query, const NormalCloud& map,
                  const PointTree& tree, double voxel) {
  Eigen::Matrix3d on_map = Eigen::Matrix3d::Zero(), all = Eigen::Matrix3d::Zero();
  forPartners(query, map, tree, T, kPartner * voxel, [&](const Partner& partner) {
    if (std::abs(partner.off_plane) <= kOnPlane * voxel && partner.cosine >= kFacesAlike)
      on_map += partner.normal * partner.normal.transpose();
  });
  for (const pcl::PointNormal& q : query) {
    const Eigen::Vector3d n = T.linear() * normalOf(q);
    all += n * n.transpose();
  }
  const double few = kFewNormals * static_cast<double>(query.size());
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d>(
             on_map, all + few * Eigen::Matrix3d::Identity())
      .eigenvalues()(0);
}

}  // namespace

std::vector<FeaturePose> matchFeatures(const FeatureCloud& query, const FeatureCloud& map,
                                       std::size_t most) {
  const FeatureCloud::Content &q = *query.content_, &m = *map.content_;
  if (q.points->empty() || m.points->empty()) return {};
  const std::vector<int> in_map = m.nearestTo(q.features);
  std::vector<int> hit = in_map;  // of the map
  std::sort(hit.begin(), hit.end());
  hit.erase(std::unique(hit.begin(), hit.end()), hit.end());
  const std::vector<int> in_query = q.nearestTo(m.features(Eigen::all, hit));
  std::vector<PointMatch> matches;
  for (std::size_t i = 0; i < in_map.size(); ++i) {
    const auto at = std::lower_bound(hit.begin(), hit.end(), in_map[i]) - hit.begin();
    if (in_query[static_cast<std::size_t>(at)] != static_cast<int>(i)) continue;
    const pcl::PointNormal &a = (*q.points)[i],
                           &b = (*m.points)[static_cast<std::size_t>(in_map[i])];
    matches.push_back({pointOf(a), pointOf(b), normalOf(a), normalOf(b)});
  }
  askBudget("local features");
  const double voxel = map.voxel();
  const NormalCloud share = evenlySpread(*q.points, kIcpPoints);
  std::vector<FeaturePose> poses;
  for (const ConsistentPose& p : consistentPoses(matches, kLengthTolerance * voxel, kProposed))
    poses.push_back({p.T_map_query, 0});
  const auto sortByShareOf = [&](const NormalCloud& points) {
    parallelFor(poses.size(), q.threads, [&](std::size_t i) {
      poses[i].share = shareOnMap(poses[i].T_map_query, points, *m.points, m.tree, voxel);
    });
    std::stable_sort(poses.begin(), poses.end(),
                     [](const FeaturePose& a, const FeaturePose& b) { return a.share > b.share; });
  };
  sortByShareOf(share);
  poses.resize(std::min(poses.size(), kRefined));
  parallelFor(poses.size(), q.threads, [&](std::size_t i) {
    poses[i].T_map_query = refined(share, *m.points, m.tree, voxel, poses[i].T_map_query);
  });
  sortByShareOf(*q.points);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const pcl::PointNormal& p : *q.points) middle += pointOf(p);
  middle /= static_cast<double>(q.points->size());
  std::vector<FeaturePose> distinct = distinctPoses(poses, middle, kSamePose * voxel, most);
  const Eigen::Translation3d from_origin(m.origin), to_origin(-q.origin);
  for (FeaturePose& pose : distinct) pose.T_map_query = from_origin * pose.T_map_query * to_origin;
  return distinct;
}

}  // namespace xview::match
