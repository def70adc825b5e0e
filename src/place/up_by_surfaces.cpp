// SPDX-License-Identifier: BSD-3-Clause
#include "place/up_by_surfaces.h"

#include <pcl/features/normal_3d.h>
#include <pcl/kdtree/kdtree_flann.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "place/gravity.h"
#include "place/lift.h"

namespace xview {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr std::size_t kMostPoses = 200, kFramesSeen = 12;  ///< looked at, evenly
constexpr double kStraightDown = 0.95;  ///< sine of the angle below the horizon; no side of such
                                        ///< an image is up
constexpr double kLooksUp = 0.7;        ///< of that above it: hardly anybody maps a ceiling
constexpr double kRolls_rad = 45 * kDegree;  ///< images of a camera held upright lean less
constexpr double kTopOff_rad = 60 * kDegree, kTopSigma_rad = 25 * kDegree;  ///< top of images to up
constexpr double kSurfaceSigma_rad = 4 * kDegree;  ///< of the normal of a piece of surface
constexpr int kStep_px = 6;                        ///< between the pixels that a normal is made of
constexpr double kSteepest = 0.2;                  ///< step in depth over depth; more is an edge
constexpr double kFewestNormals = 500;             ///< of all frames
constexpr double kIndependent = 30;                ///< pieces of surface; neighbours err together

constexpr double kCloudVoxel_m = 0.3;  ///< in a town
constexpr std::size_t kPointsThinned = 1000000, kMostNormals = 10000, kFewestAround = 8;
constexpr double kNormalReach = 2.5;  ///< voxels around a point that make its normal
constexpr double kCurved = 0.05;      ///< share of the variance across a surface
constexpr double kAxisOff_rad = 45 * kDegree;
constexpr double kNearZ_rad = 8 * kDegree;  ///< z is believed
constexpr float kFieldOfView = 1.2F;        ///< tangent of half of the one of a depth camera
constexpr double kInView = 0.95;            ///< share of the points of a camera that lie in it
constexpr double kClearlyBetter = 1;        ///< log-likelihood ratio per normal

/// Shares of surface that faces up, faces down, stands upright, and does as it likes.
constexpr double kFloors = 0.3, kCeilings = 0.1, kWalls = 0.3, kOthers = 0.3;

/// Whether a camera that is held like this may stand in a frame whose up is this.
bool mayBeHeldSo(const Eigen::Matrix3d& R, const Eigen::Vector3d& up) {
  const double ahead = R.col(2).dot(up), top = -R.col(1).dot(up);
  if (ahead < -kStraightDown) return true;
  return ahead < kLooksUp && top > std::cos(kRolls_rad) * std::sqrt(1 - ahead * ahead);
}

/// Normals of surfaces, in directions of some four degrees.
class Normals {
 public:
  void add(const Eigen::Vector3d& n) {
    Direction& direction = directions_[{static_cast<int>(std::lround(n.x() * kSteps)),
                                        static_cast<int>(std::lround(n.y() * kSteps)),
                                        static_cast<int>(std::lround(n.z() * kSteps))}];
    direction.count += 1;
    direction.sum += n;
    count_ += 1;
  }
  double count() const { return count_; }

  struct Direction {
    double count = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  };
  using Directions = std::map<std::array<int, 3>, Direction>;
  const Directions& directions() const { return directions_; }

 private:
  static constexpr double kSteps = 16;
  Directions directions_;
  double count_ = 0;
};

/// How well a direction fits as up.
class UpScore {
 public:
  explicit UpScore(const Normals& normals) {
    for (const auto& [key, direction] : normals.directions()) {
      directions_.push_back(direction.sum.normalized());
      shares_.push_back(direction.count / normals.count());
    }
  }

  /// Mean log-likelihood ratio of the normals if this is up, against normals of any direction.
  double operator()(const Eigen::Vector3d& up) const {
    double sum = 0;
    for (std::size_t i = 0; i < shares_.size(); ++i)
      sum += shares_[i] * logRatio(directions_[i].dot(up));
    return sum;
  }

 private:
  /// Of a normal at an angle of this cosine. The table has even steps in sqrt(1 - |cosine|), which
  /// are nearly even in the angle: at most 0.2 deg.
  static double logRatio(double cosine) {
    static constexpr std::size_t kEntries = 1024;
    static const auto* const table = [] {
      auto* const made = new std::array<std::array<double, kEntries + 1>, 2>;
      for (std::size_t i = 0; i <= kEntries; ++i) {
        const double root = static_cast<double>(i) / kEntries, of_entry = 1 - root * root;
        (*made)[0][i] = exactLogRatio(std::acos(of_entry));
        (*made)[1][i] = exactLogRatio(std::acos(-of_entry));
      }
      return made;
    }();
    const double root = std::sqrt(std::max(0.0, 1 - std::abs(cosine)));
    return (*table)[cosine < 0 ? 1 : 0][static_cast<std::size_t>(root * kEntries + 0.5)];
  }

  static double exactLogRatio(double off_rad) {
    // On the sphere a spot of this sigma has the share sigma^2 / 2, a belt the share
    // sigma sqrt(pi / 2).
    constexpr double kSpot = kSurfaceSigma_rad * kSurfaceSigma_rad / 2;
    const double belt = kSurfaceSigma_rad * std::sqrt(M_PI / 2);
    const auto bell = [](double off) {
      return std::exp(-0.5 * std::pow(off / kSurfaceSigma_rad, 2));
    };
    return std::log(kOthers + kFloors * bell(off_rad) / kSpot +
                    kCeilings * bell(M_PI - off_rad) / kSpot +
                    kWalls * bell(off_rad - M_PI / 2) / belt);
  }

  std::vector<Eigen::Vector3d> directions_;
  std::vector<double> shares_;
};

/// Towards the camera, in the frame of its poses.
void addNormals(const Frame& frame, Normals& normals) {
  const DepthImage& depth = frame.depth;
  for (int v = 0; v + 2 * kStep_px < depth.height; v += kStep_px) {
    for (int u = 0; u + 2 * kStep_px < depth.width; u += kStep_px) {
      const double z = depth.at(u, v), right = depth.at(u + 2 * kStep_px, v),
                   below = depth.at(u, v + 2 * kStep_px);
      if (!isDepth(depth.at(u, v)) || !(std::abs(right - z) < kSteepest * z) ||
          !(std::abs(below - z) < kSteepest * z))
        continue;
      const Eigen::Vector3d p = frame.camera.unproject(u, v, z);
      Eigen::Vector3d n = (frame.camera.unproject(u + 2 * kStep_px, v, right) - p)
                              .cross(frame.camera.unproject(u, v + 2 * kStep_px, below) - p);
      if (n.dot(p) > 0) n = -n;
      if (n.norm() > 0) normals.add(frame.T_odom_sensor.linear() * n.normalized());
    }
  }
}

/// Whether a cloud lies as a depth camera at its origin sees it: z forward, y down.
bool isSeenByCamera(const pcl::PointCloud<Point>& points) {
  std::size_t count = 0, in_view = 0;
  for (const Point& p : points) {
    if (!p.getVector3fMap().allFinite()) continue;
    ++count;
    in_view += p.z > 0 && std::hypot(p.x, p.y) < kFieldOfView * p.z;
  }
  return count > 0 && static_cast<double>(in_view) >= kInView * static_cast<double>(count);
}

/// Of a cloud: towards its origin if that has seen it, else both ways.
void addNormals(const pcl::PointCloud<Point>& points, double size, bool from_origin,
                Normals& normals) {
  LabelledCloud cloud;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / kPointsThinned) {
    const Point& p = points[i];
    if (p.getVector3fMap().allFinite()) cloud.points.emplace_back(p.x, p.y, p.z, 0);
  }
  const double voxel_m = size * kCloudVoxel_m;
  const pcl::PointCloud<pcl::PointXYZ>::Ptr thin(new pcl::PointCloud<pcl::PointXYZ>);
  for (const Point& p : thinByVoxel(cloud, voxel_m).points) thin->emplace_back(p.x, p.y, p.z);
  if (thin->empty()) return;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(thin);
  pcl::Indices near;
  std::vector<float> squared;
  for (std::size_t i = 0; i < thin->size(); i += 1 + thin->size() / kMostNormals) {
    tree.radiusSearch((*thin)[i], kNormalReach * voxel_m, near, squared);
    Eigen::Vector4f plane;
    float curvature = 0;
    if (near.size() < kFewestAround || !pcl::computePointNormal(*thin, near, plane, curvature) ||
        !(curvature < kCurved))
      continue;
    const Eigen::Vector3d n = plane.head<3>().cast<double>().normalized();
    const bool is_away = n.dot((*thin)[i].getVector3fMap().cast<double>()) > 0;
    if (!from_origin || !is_away) normals.add(n);
    if (!from_origin || is_away) normals.add(-n);
  }
}

/// The best of the directions around one, in rings of this step.
template <class Score>
Eigen::Vector3d bestAround(const Eigen::Vector3d& middle, double reach_rad, double step_rad,
                           const Score& score) {
  const Eigen::Matrix3d R = alignmentFromUp(middle).toRotationMatrix().transpose();
  Eigen::Vector3d best = middle;
  double best_score = score(middle);
  for (double off = step_rad; off <= reach_rad; off += step_rad) {
    const int around = static_cast<int>(std::ceil(2 * M_PI * std::sin(off) / step_rad));
    for (int i = 0; i < around; ++i) {
      const double turn = 2 * M_PI * i / around;
      const Eigen::Vector3d up = R * Eigen::Vector3d(std::sin(off) * std::cos(turn),
                                                     std::sin(off) * std::sin(turn), std::cos(off));
      const double here = score(up);
      if (here > best_score) best_score = here, best = up;
    }
  }
  return best;
}

template <class Score>
Eigen::Vector3d mostLikelyNear(const Eigen::Vector3d& middle, double reach_rad,
                               const Score& score) {
  constexpr double kRough_rad = 3 * kDegree, kFine_rad = 0.5 * kDegree;
  return bestAround(bestAround(middle, reach_rad, kRough_rad, score), kRough_rad, kFine_rad, score);
}

/// Up where the top of images lies there, within a reach of it: a wall before a camera that looks
/// down might be a floor.
Eigen::Vector3d upOfImages(const Eigen::Vector3d& top, double reach_rad, const UpScore& score) {
  return mostLikelyNear(top, reach_rad, [&](const Eigen::Vector3d& up) {
    const double off = std::acos(std::clamp(up.dot(top), -1.0, 1.0));
    return score(up) - 0.5 * std::pow(off / kTopSigma_rad, 2) / kIndependent;
  });
}

}  // namespace

Eigen::Vector3d upOfCamera(const FrameSource& recording) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ(), nothing = Eigen::Vector3d::Zero();
  if (recording.sensor() != Sensor::camera || recording.size() == 0) return nothing;
  const std::size_t poses = std::min(kMostPoses, recording.size());
  Eigen::Vector3d top = nothing;
  std::size_t upright = 0, looking_up = 0;
  for (std::size_t i = 0; i < poses; ++i) {
    const Eigen::Matrix3d R = recording.pose(i * recording.size() / poses).linear();
    top -= R.col(1);
    upright += mayBeHeldSo(R, z);
    looking_up += R(2, 2) > kLooksUp;
  }
  if (2 * upright >= poses || top.norm() < 0.5 * static_cast<double>(poses)) return nothing;
  top.normalize();
  Normals normals;
  const std::size_t frames = std::min(kFramesSeen, recording.size());
  for (std::size_t i = 0; i < frames; ++i)
    addNormals(recording.read(i * recording.size() / frames), normals);
  if (normals.count() < kFewestNormals) return nothing;
  const UpScore score(normals);
  const Eigen::Vector3d up = upOfImages(top, kTopOff_rad, score);
  // A camera that was turned or hung upside down sees surfaces that z lines up with.
  return 2 * looking_up < poses && score(z) >= score(up) ? nothing : up;
}

VerticalOfRoom verticalOfRoom(const pcl::PointCloud<Point>& points, double size) {
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const bool by_camera = isSeenByCamera(points);
  Normals normals;
  addNormals(points, size, by_camera, normals);
  if (normals.count() < (by_camera ? kFewestNormals / 2 : kFewestNormals)) return {};
  const UpScore score(normals);
  if (by_camera) return {upOfImages(-y, kAxisOff_rad, score), true};
  const Eigen::Vector3d near_z = mostLikelyNear(z, kAxisOff_rad, score),
                        near_y = mostLikelyNear(y, kAxisOff_rad, score);
  const bool z_fits = near_z.z() > std::cos(kNearZ_rad);
  if (score(near_y) > score(near_z) + (z_fits ? kClearlyBetter : 0)) return {near_y, false};
  return {z_fits ? z : near_z, false};
}

OtherVertical otherVertical(const Eigen::Vector3d& up, double size,
                            const pcl::PointCloud<Point>& points) {
  // The walls of a street would be as flat a floor and ceiling, and of the ground a scanner of few
  // beams sees nothing but lines. So a cloud that `up` fits somehow is turned by more than a lean
  // only where its ground says so (is_clear), and a lean of one that it does not fit is believed
  // where it shows more than walls.
  constexpr double kFits = 0, kMoreThanWalls = 1.8;
  Normals normals;
  addNormals(points, size, false, normals);
  if (normals.count() < 2 * kFewestNormals) return {};  // each counts twice
  const UpScore score(normals);
  const double as_given = score(up);
  if (as_given > kMoreThanWalls) return {up, false};
  const auto isOther = [&](const Eigen::Vector3d& axis) {
    return axis.dot(up) < std::cos(kNearZ_rad) && score(axis) > as_given + kClearlyBetter;
  };
  const Eigen::Vector3d near = mostLikelyNear(up, kAxisOff_rad, score);
  if (isOther(near) && (as_given >= kFits || score(near) > kMoreThanWalls))
    return {near, true, true};
  const Eigen::Vector3d best = mostLikelyNear(up, M_PI / 2, score);
  return isOther(best) ? OtherVertical{best, as_given < kFits} : OtherVertical{up, false};
}

}  // namespace xview
