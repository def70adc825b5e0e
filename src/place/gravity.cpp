// SPDX-License-Identifier: BSD-3-Clause
#include "place/gravity.h"
#include "base/moments.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace xview {
namespace {

constexpr double kDegrees = 180 / M_PI;
constexpr double kClearly_rad = 6 / kDegrees;  ///< z is believed to be up if the measured up is
                                               ///< this near plus 4 sigma: streets climb
constexpr double kLayerSigma_rad = 0.06;       ///< slope of the ground under a graph
constexpr double kLayerFlatness = 0.3;         ///< thickness over width of a layer
constexpr double kLevelledMapSigma_rad = 0.03;
constexpr double kMountingSigma_rad = 0.05;  ///< how far off level scanners stand
constexpr double kFewestVertices = 8;

double angleToZ(const Eigen::Vector3d& up) { return std::acos(std::clamp(up.z(), -1.0, 1.0)); }

bool isClearlyOff(double angle_rad, double sigma_rad) {
  return angle_rad > kClearly_rad + 4 * sigma_rad;
}

Gravity asGiven(const std::string& why) {
  Gravity gravity;
  gravity.reason = "z is up as given: " + why;
  return gravity;
}

Gravity unknown(const std::string& why) {
  Gravity gravity;
  gravity.known = false;
  gravity.reason = why;
  return gravity;
}

Gravity measured(const Eigen::Vector3d& up, double sigma_rad, const std::string& source) {
  Gravity gravity;
  gravity.alignment = alignmentFromUp(up);
  gravity.sigma_rad = sigma_rad;
  gravity.reason = fmt::format("turned upright by {:.1f} +- {:.1f} deg, by {}",
                               angleToZ(up) * kDegrees, sigma_rad * kDegrees, source);
  return gravity;
}

/// If the odometry frame is that of the first scan, z is the scanner's axis and may lean.
bool isFrameOfScanner(const PreprocessedFrame& first) {
  return first.sensor != Sensor::camera &&
         first.T_odom_sensor.linear() == Eigen::Matrix3d::Identity();
}

/// Error of z where it is kept as up: mean and standard deviation of the lean, given the usual
/// mounting of scanners and the measured up.
double errorOfKept(double off_rad, double sigma_rad) {
  const double mounting = kMountingSigma_rad * kMountingSigma_rad, seen = sigma_rad * sigma_rad;
  return std::hypot(off_rad * mounting / (mounting + seen),
                    std::sqrt(mounting * seen / (mounting + seen)));
}

/// Moments of the positions of each class, relative to the first vertex of the graph.
using MomentsOfClasses = std::map<std::uint32_t, Moments3>;

/// One pass over vertices that may be packed.
MomentsOfClasses momentsOf(const AllVertices& vertices) {
  MomentsOfClasses classes;
  std::optional<Eigen::Vector3d> first;
  vertices.forEach([&](std::uint32_t, const Vertex& v) {
    if (!v.position.allFinite()) return;
    if (!first) first = v.position;
    classes[v.label].add(v.position - *first);
  });
  return classes;
}

/// Normal of the layer of vertices, each class about its own mean: classes differ in height.
Eigen::Vector3d layerNormal(const MomentsOfClasses& classes) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double count = 0;
  for (const auto& [label, moments] : classes) {
    if (moments.count < 2) continue;
    scatter += moments.squares - moments.sum * moments.sum.transpose() / moments.count;
    count += moments.count;
  }
  if (count < kFewestVertices) return Eigen::Vector3d::Zero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter / count);
  const Eigen::Vector3d spread = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (!(spread(0) < kLayerFlatness * spread(1))) return Eigen::Vector3d::Zero();
  return axes.eigenvectors().col(0);
}

/// 1 if the ground classes are clearly below the others along the normal, -1 if above, else 0.
int sideOfGround(const MomentsOfClasses& classes, const LabelSet& labels,
                 const Eigen::Vector3d& normal) {
  constexpr double kClear_m = 0.5, kSigmas = 3;
  struct Heights {
    double count = 0, sum = 0, squares = 0;
    double mean() const { return sum / count; }
    double variance() const { return squares / count - mean() * mean(); }
  } ground, others;
  for (const auto& [label, moments] : classes) {
    const Kind kind = labels.kind(label);
    if (!tellsShape(kind)) continue;
    Heights& h = isGround(kind) ? ground : others;
    h.count += moments.count;
    h.sum += normal.dot(moments.sum);
    h.squares += normal.dot(moments.squares * normal);
  }
  if (ground.count < 3 || others.count < 3) return 0;
  const double above = others.mean() - ground.mean();
  const double sigma =
      std::sqrt(std::max(0.0, ground.variance() / ground.count + others.variance() / others.count));
  if (std::abs(above) < std::max(kClear_m, kSigmas * sigma)) return 0;
  return above > 0 ? 1 : -1;
}

}  // namespace

Eigen::Quaterniond alignmentFromUp(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

Gravity gravityOf(const std::vector<PlaceBuilder::SharedFrame>& frames, const LabelSet& labels,
                  const std::string& mode) {
  if (mode == "aligned") return asGiven("gravity = aligned");
  const UpEvidence evidence = findUp(frames, labels);
  if (evidence.up.norm() == 0) {
    const char* nothing = "neither ground nor sensor tells which way is up";
    return mode == "free" ? unknown(nothing) : asGiven(nothing);
  }
  const double off = angleToZ(evidence.up);
  if (mode == "free" || isClearlyOff(off, evidence.sigma_rad))
    return measured(evidence.up, evidence.sigma_rad, evidence.source);
  Gravity gravity = asGiven(fmt::format("{} say {:.1f} +- {:.1f} deg off it", evidence.source,
                                        off * kDegrees, evidence.sigma_rad * kDegrees));
  if (isFrameOfScanner(*frames.front())) gravity.sigma_rad = errorOfKept(off, evidence.sigma_rad);
  return gravity;
}

Eigen::Vector3d layerNormal(const AllVertices& vertices) {
  return layerNormal(momentsOf(vertices));
}

Gravity gravityOf(const AllVertices& vertices, const LabelSet& labels, const std::string& mode) {
  if (mode == "aligned") return asGiven("gravity = aligned");
  const MomentsOfClasses classes = momentsOf(vertices);
  Eigen::Vector3d up = layerNormal(classes);
  if (up.norm() == 0) {
    const char* nothing = "the vertices form no layer that would tell which way is up";
    return mode == "free" ? unknown(nothing) : asGiven(nothing);
  }
  const int side = sideOfGround(classes, labels, up);
  if (side < 0 || (side == 0 && up.z() < 0)) up = -up;
  const double off = angleToZ(up);
  if (mode == "auto" && !isClearlyOff(off, kLayerSigma_rad)) {
    return asGiven(fmt::format("the layer of vertices is {:.1f} deg off it", off * kDegrees));
  }
  if (side == 0) return unknown("the vertices form a layer, but not which side of it is up");
  return measured(up, kLayerSigma_rad, "the layer of vertices and ground below them");
}

Gravity gravityOf(const BevGrid& view) {
  Gravity gravity;
  gravity.alignment = view.alignment;
  if (!gravity.turned()) return gravity;
  gravity.sigma_rad = kLevelledMapSigma_rad;
  gravity.reason = "turned upright when it was made";
  return gravity;
}

Gravity gravityOf(const Place& place, const std::string& mode) {
  return place.bev.known.empty() ? gravityOf(place.graph, place.labels, mode)
                                 : gravityOf(place.bev);
}

}  // namespace xview
