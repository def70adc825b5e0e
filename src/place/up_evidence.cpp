// SPDX-License-Identifier: BSD-3-Clause
#include "place/gravity.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "base/moments.h"
#include "place/point_quality.h"

namespace xview {
namespace {

constexpr double kUnderSensor_m = 25;  ///< ground further away may be another slope
constexpr double kFlatness = 0.25;     ///< thickness over width of what counts as a plane
constexpr double kRoughness_m = 0.05, kBump_m = 0.3;  ///< of ground
constexpr std::size_t kFewestOfPlane = 50, kFewestInCell = 12;
constexpr double kWallCell_m = 3, kWallSigma_m = 0.6;
constexpr std::size_t kMostFrames = 16, kMostPoints = 4000;  ///< looked at, evenly
constexpr double kLeans_rad = 0.35;                          ///< a wall or pole off by more is none

constexpr double kGroundSigma_rad = 0.04;    ///< slope of streets
constexpr double kToldSigma_rad = 0.02;      ///< of Frame::up_sensor
constexpr double kFrameSigma_rad = 0.05;     ///< of the ground of one frame
constexpr double kVerticalSigma_rad = 0.06;  ///< of one piece of wall or one pole
constexpr double kVerticalsAlike = 30;       ///< more pieces than this err together
constexpr double kSensorSigma_rad = 0.2;     ///< how cameras and scanners are mounted

bool standsUp(Kind kind) { return kind != Kind::none && !isGround(kind); }

struct WeightedPoint {
  Eigen::Vector3d p;
  double variance;
};

/// A plane through points of ground.
struct GroundPlane {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  double thickness = 0,
         width = 0;  ///< [m], standard deviations across it, and along its narrower side

  bool isFlat() const { return thickness < kFlatness * width; }
};

/// Wrong labels are no ground: what is far from the plane counts less (Geman-McClure).
GroundPlane fitPlane(const std::vector<WeightedPoint>& points, const GroundPlane* start) {
  GroundPlane plane = start ? *start : GroundPlane();
  for (int round = start ? 1 : 0; round < 7; ++round) {
    Moments3 moments;
    for (const WeightedPoint& g : points) {
      const double gate2 = 9 * g.variance + kBump_m * kBump_m;
      const double off2 = round == 0 ? 0 : std::pow(plane.normal.dot(g.p - plane.middle), 2);
      moments.add(g.p, 1 / (g.variance * std::pow(1 + off2 / gate2, 2)));
    }
    const auto axes = moments.axes();
    plane.normal = axes.eigenvectors().col(0);
    plane.middle = moments.mean();
    plane.thickness = std::sqrt(std::max(1e-6, axes.eigenvalues()(0)));
    plane.width = std::sqrt(std::max(1e-6, axes.eigenvalues()(1)));
  }
  return plane;
}

/// What was seen of the ground, all in one frame.
struct GroundSight {
  std::vector<WeightedPoint> points;  ///< of all frames
  std::vector<GroundPlane> planes;    ///< one per frame that shows a plane, normals up
};

void addGround(const PreprocessedFrame& frame, const Eigen::Vector3d& origin,
               const LabelSet& labels, GroundSight& sight) {
  const float reach = frame.aerial ? INFINITY : static_cast<float>(kUnderSensor_m);
  const Eigen::Vector3d shift = frame.cloud.origin - origin;
  std::vector<WeightedPoint> ground;
  Moments3 upright;
  const std::size_t step = 1 + frame.cloud.size() / kMostPoints;
  for (std::size_t i = 0; i < frame.cloud.size(); i += step) {
    if (rangeOf(frame, i) > reach) continue;
    const Kind kind = labels.kind(frame.cloud.points[i].label);
    const Eigen::Vector3d p = shift + frame.cloud.points[i].getVector3fMap().cast<double>();
    if (!p.allFinite()) continue;
    if (isGround(kind))
      ground.push_back(
          {p, std::pow(double{frame.cloud.points[i].sigma}, 2) + kRoughness_m * kRoughness_m});
    else if (standsUp(kind))
      upright.add(p, 1);
  }
  if (ground.size() < kFewestOfPlane) return;
  GroundPlane plane = fitPlane(ground, nullptr);
  if (!plane.isFlat()) return;
  Eigen::Vector3d above = frame.T_odom_sensor.translation() - origin - plane.middle;
  if (frame.sensor == Sensor::cloud) {
    if (upright.count < static_cast<double>(kFewestOfPlane)) return;
    above = upright.mean() - plane.middle;
  }
  if (plane.normal.dot(above) < 0) plane.normal = -plane.normal;
  sight.planes.push_back(plane);
  sight.points.insert(sight.points.end(), ground.begin(), ground.end());
}

/// The direction that most planes agree with; nothing if they contradict one another.
std::optional<GroundPlane> commonPlane(const std::vector<GroundPlane>& planes) {
  GroundPlane common;
  for (int round = 0; round < 8; ++round) {
    Eigen::Vector3d normals = Eigen::Vector3d::Zero(), middles = normals;
    double weights = 0;
    for (const GroundPlane& g : planes) {
      const double off = round == 0 ? 0 : common.normal.cross(g.normal).norm();
      const double weight = 1 / std::pow(1 + std::pow(off / kFrameSigma_rad, 2), 2);
      normals += weight * g.normal;
      middles += weight * g.middle;
      weights += weight;
    }
    if (normals.norm() <= 0.5 * weights) return std::nullopt;
    common.normal = normals.normalized();
    common.middle = middles / weights;
  }
  return common;
}

/// Up by the ground: the plane that all frames see together, started from what they see one by one.
std::optional<Eigen::Vector3d> groundUp(const GroundSight& sight) {
  const auto common = commonPlane(sight.planes);
  if (!common) return std::nullopt;
  const GroundPlane all = fitPlane(sight.points, &*common);
  const Eigen::Vector3d up =
      all.normal.dot(common->normal) < 0 ? Eigen::Vector3d(-all.normal) : all.normal;
  return all.isFlat() && up.dot(common->normal) > std::cos(kLeans_rad) ? up : common->normal;
}

/// Normals of pieces of wall and directions of poles.
struct Verticals {
  std::vector<Eigen::Vector3d> wall_normals, pole_axes;
};

using FramePointers = std::vector<const PreprocessedFrame*>;

void addWalls(const FramePointers& frames, const LabelSet& labels, Verticals& found) {
  std::map<std::tuple<int, int, int, std::uint32_t>, Moments3> cells;
  for (const PreprocessedFrame* f : frames) {
    const PreprocessedFrame& frame = *f;
    const Eigen::Vector3d shift = frame.cloud.origin - frames[0]->cloud.origin;
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      const std::uint32_t label = frame.cloud.points[i].label;
      const Kind kind = labels.kind(label);
      if ((kind != Kind::building && kind != Kind::fence) ||
          double{frame.cloud.points[i].sigma} > kWallSigma_m)
        continue;
      const Eigen::Vector3d p = shift + frame.cloud.points[i].getVector3fMap().cast<double>();
      if (!p.allFinite()) continue;
      const Eigen::Vector3d c = (p / kWallCell_m).array().floor();
      cells[{static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()), label}].add(
          p, 1);
    }
  }
  for (const auto& [cell, moments] : cells) {
    if (moments.count < kFewestInCell) continue;
    const auto axes = moments.axes();
    if (std::sqrt(std::max(0.0, axes.eigenvalues()(0))) >
        kFlatness * std::sqrt(axes.eigenvalues()(1)))
      continue;
    found.wall_normals.push_back(axes.eigenvectors().col(0));
  }
}

void addPoles(const FramePointers& frames, const LabelSet& labels, Verticals& found) {
  constexpr double kLong_m = 0.5, kThin = 0.15;
  for (const PreprocessedFrame* frame : frames) {
    for (const Blob& blob : frame->blobs) {
      const Kind kind = labels.kind(blob.label);
      if (!isPoleLike(kind) && kind != Kind::trunk) continue;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(blob.covariance);
      const double longest = std::sqrt(std::max(0.0, axes.eigenvalues()(2)));
      if (longest < kLong_m || std::sqrt(std::max(0.0, axes.eigenvalues()(1))) > kThin * longest)
        continue;
      found.pole_axes.push_back(axes.eigenvectors().col(2));
    }
  }
}

/// Information about the direction of up, in the plane across `up`: each wall forbids leaning along
/// its normal, each pole in both directions.
struct Pull {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  int pieces = 0;
};

Pull pullOf(const Verticals& verticals, const Eigen::Vector3d& up) {
  Pull pull;
  for (const Eigen::Vector3d& n : verticals.wall_normals) {
    const double lean = n.dot(up);
    if (std::abs(lean) > std::sin(kLeans_rad)) continue;
    pull.H += n * n.transpose();
    pull.b -= lean * n;
    ++pull.pieces;
  }
  for (const Eigen::Vector3d& axis : verticals.pole_axes) {
    const Eigen::Vector3d a = axis.dot(up) < 0 ? Eigen::Vector3d(-axis) : axis;
    if (a.dot(up) < std::cos(kLeans_rad)) continue;
    pull.H += Eigen::Matrix3d::Identity() - up * up.transpose();
    pull.b += a - a.dot(up) * up;
    ++pull.pieces;
  }
  const double alike = std::min(1.0, kVerticalsAlike / std::max(1, pull.pieces)) /
                       (kVerticalSigma_rad * kVerticalSigma_rad);
  pull.H *= alike;
  pull.b *= alike;
  return pull;
}

/// The most probable up near a first guess of known error.
void correct(const Verticals& verticals, const Eigen::Vector3d& guess, double guess_sigma_rad,
             UpEvidence& evidence) {
  const double hold = 1 / (guess_sigma_rad * guess_sigma_rad);
  evidence.up = guess;
  for (int i = 0; i < 5; ++i) {
    const Pull pull = pullOf(verticals, evidence.up);
    evidence.verticals = pull.pieces;
    const Eigen::Vector3d off = guess - guess.dot(evidence.up) * evidence.up;
    // Along up itself nothing moves, whatever the pull.
    const Eigen::Matrix3d along = evidence.up * evidence.up.transpose(),
                          across = Eigen::Matrix3d::Identity() - along;
    const Eigen::Matrix3d H = across * pull.H * across + hold * across + along;
    evidence.up = (evidence.up + H.ldlt().solve(across * (pull.b + hold * off))).normalized();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(H - along + 1e12 * along);
    evidence.sigma_rad = 1 / std::sqrt(axes.eigenvalues()(0));
  }
}

}  // namespace

UpEvidence findUp(const std::vector<PlaceBuilder::SharedFrame>& all, const LabelSet& labels) {
  UpEvidence evidence;
  const std::size_t step = (all.size() + kMostFrames - 1) / kMostFrames;
  FramePointers frames;
  for (std::size_t i = 0; i < all.size(); i += step) frames.push_back(all[i].get());
  GroundSight grounds;
  Eigen::Vector3d sensor_up = Eigen::Vector3d::Zero(), told_up = sensor_up;
  std::size_t telling = 0;
  for (const PreprocessedFrame* frame : frames) {
    addGround(*frame, frames[0]->cloud.origin, labels, grounds);
    if (frame->sensor == Sensor::camera && !frame->aerial)
      sensor_up -= frame->T_odom_sensor.linear().col(1);
    told_up += frame->T_odom_sensor.linear() * frame->up_sensor;
    telling += !frame->up_sensor.isZero();
    if (frame->sensor == Sensor::lidar) sensor_up += frame->T_odom_sensor.linear().col(2);
  }
  evidence.grounds = static_cast<int>(grounds.planes.size());
  std::string source = "surfaces seen";
  double sigma_rad = kToldSigma_rad;
  Eigen::Vector3d up = told_up;
  if (up.norm() == 0 || 2 * telling < frames.size()) {
    const auto from_ground = groundUp(grounds);
    source = from_ground ? "ground plane" : "mounting of the sensor";
    sigma_rad = from_ground ? kGroundSigma_rad : kSensorSigma_rad;
    up = from_ground.value_or(sensor_up);
  }
  if (up.norm() == 0) return evidence;
  Verticals verticals;
  addWalls(frames, labels, verticals);
  addPoles(frames, labels, verticals);
  correct(verticals, up.normalized(), sigma_rad, evidence);
  evidence.source = fmt::format("{} and {} verticals", source, evidence.verticals);
  return evidence;
}

}  // namespace xview
