// SPDX-License-Identifier: BSD-3-Clause
#include "xview/odometry_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>
#include <vector>

#include "xview/place_builder.h"
#include "xview/raw_recording.h"
#include "xview/types/cells.h"
#include "xview/types/median.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

// All lengths are canonical ones.
constexpr double kReach_m = 30;      ///< from the sensor; what is farther overlaps less
constexpr float kMostSigma_m = 0.6;  ///< of a point near the ground
/// Side of a cell, in standard deviations of the points, and its bounds [m]; from the air, where
/// the layout of the ground is all that is seen, cells are of the plane and of one class.
constexpr double kSidePerSigma = 3, kLeastSide_m = 0.5, kMostSide_m = 1.5, kSideFromTheAir_m = 2;
constexpr std::size_t kAsked = 1000, kFewestAsked = 200;  ///< points of a frame
/// Share of the points that another motion must explain, and by which it must exceed that of the
/// odometry: at once, or summed over steps beyond what honest steps show by chance.
constexpr double kExplains = 0.5, kClearlyMore = 0.35, kByChance = 0.12, kClearlyMoreInAll = 0.6;
/// From this on no other motion can explain clearly more.
constexpr double kInPlace = 0.85;
/// Difference to the step before with which a step is unusual; between two motions below the least
/// one there is nothing to tell.
constexpr double kUnusual_m = 2, kUnusual_rad = 0.5, kLeastDifference_m = 0.5;
constexpr double kMuchLess = 0.5;  ///< share of what usual steps leave in place
constexpr std::size_t kUsualSteps = 16, kFewestSteps = 3;

using Points = std::vector<std::pair<Eigen::Vector3f, std::uint32_t>>;  ///< and their labels

/// What a frame has seen, relative to its sensor, along the axes of the odometry.
struct Look {
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  Points points;
  bool aerial = false;
  double side_m = kLeastSide_m;
};

Look lookOf(const PreprocessedFrame& frame, const LabelSet& labels) {
  Look look;
  look.T_odom_sensor = frame.T_odom_sensor;
  look.aerial = frame.aerial;
  const auto sensor = (frame.T_odom_sensor.translation() - frame.cloud.origin).cast<float>().eval();
  const auto reach = static_cast<float>(frame.aerial ? INFINITY : kReach_m);
  std::vector<float> sigmas;
  for (const Point& p : frame.cloud.points) {
    if (labels.role(p.label) == Role::ignored) continue;
    if (!frame.aerial && (isGround(labels.kind(p.label)) || p.sigma > kMostSigma_m)) continue;
    const Eigen::Vector3f from_sensor = p.getVector3fMap() - sensor;
    if (!(from_sensor.squaredNorm() <= reach * reach)) continue;
    look.points.emplace_back(from_sensor, p.label);
    sigmas.push_back(p.sigma);
  }
  if (frame.aerial)
    look.side_m = kSideFromTheAir_m;
  else if (!sigmas.empty())
    look.side_m =
        std::clamp(kSidePerSigma * medianOf(std::move(sigmas)), kLeastSide_m, kMostSide_m);
  return look;
}

/// Evenly spread ones.
Points someOf(const Points& points) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / kAsked);
  Points some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

/// The cells in which a look has points.
class SeenCells {
 public:
  explicit SeenCells(const Look& look) : side_m_(look.side_m), aerial_(look.aerial) {
    cells_.reserve(look.points.size() / 2);
    for (const auto& [p, label] : look.points) {
      const ClassCell cell = cellAt(p / static_cast<float>(side_m_), label);
      cells_.numberOf(cell, [&] { return Entry{cell}; });
    }
  }
  /// In the cell of p or in one of those that it is nearest to.
  bool holdNear(const Eigen::Vector3f& p, std::uint32_t label) const {
    const Eigen::Vector3f corner =
        p / static_cast<float>(side_m_) - Eigen::Vector3f::Constant(0.5F);
    for (int i = 0; i < (aerial_ ? 4 : 8); ++i) {
      const Eigen::Vector3f shift(i & 1, i >> 1 & 1, i >> 2 & 1);
      if (cells_.find(cellAt(corner + shift, label)) >= 0) return true;
    }
    return false;
  }

 private:
  struct Entry {
    ClassCell key;
  };
  ClassCell cellAt(const Eigen::Vector3f& p, std::uint32_t label) const {
    const ClassCell cell = cellOf(p.cast<double>(), 1, aerial_ ? label : 0);
    return {cell.x, cell.y, aerial_ ? 0 : cell.z, cell.label, 0};
  }

  CellTable<Entry> cells_;
  double side_m_;
  bool aerial_;
};

/// How much of a look lies where the one before has seen something, after a motion.
struct InPlace {
  double of_all = 0;
  double of_overlap = 0;  ///< of the points in the reach of the look before; NaN if they are few
};

InPlace inPlaceAfter(const Eigen::Isometry3d& T_before_now, const SeenCells& before,
                     const Look& look_before, const Look& now, const Points& asked) {
  // Both looks keep the axes of the odometry.
  const Eigen::Matrix3d R_odom_before = look_before.T_odom_sensor.linear();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R_odom_before * T_before_now.linear() * now.T_odom_sensor.linear().transpose();
  T.translation() = R_odom_before * T_before_now.translation();
  const Eigen::Isometry3f T_float = T.cast<float>();
  const auto reach = static_cast<float>(now.aerial ? INFINITY : kReach_m);
  std::size_t overlap = 0, found = 0;
  for (const auto& [p, label] : asked) {
    const Eigen::Vector3f moved = T_float * p;
    if (moved.squaredNorm() > reach * reach) continue;
    ++overlap;
    found += before.holdNear(moved, label);
  }
  const auto share = [&](std::size_t of) {
    return static_cast<double>(found) / static_cast<double>(of);
  };
  return {share(asked.size()), overlap >= kFewestAsked / 2 ? share(overlap) : NAN};
}

double distanceBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace

struct OdometryCheck::State {
  explicit State(LabelSet known) : labels(std::move(known)) {}

  std::optional<OdometryJump> add(const PreprocessedFrame& frame) {
    Look now = lookOf(frame, labels);
    std::optional<double> off_m;
    if (added > 0) off_m = offBy(now);
    before = std::move(now);
    ++added;
    if (!off_m) return std::nullopt;
    forget();
    return OdometryJump{added - 1, frame.number, *off_m * frame.size};
  }

  /// How far the step to this look is from a motion that explains it better, if it is a jump.
  std::optional<double> offBy(const Look& now) {
    const Eigen::Isometry3d step = before.T_odom_sensor.inverse() * now.T_odom_sensor;
    const Points asked = someOf(now.points);
    const bool tells = asked.size() >= kFewestAsked && before.points.size() >= kFewestAsked &&
                       before.aerial == now.aerial;
    std::optional<double> off_m;
    if (tells) off_m = offByScans(step, now, asked);
    if (off_m) return off_m;
    takeStep(step);
    return std::nullopt;
  }

  std::optional<double> offByScans(const Eigen::Isometry3d& step, const Look& now,
                                   const Points& asked) {
    const SeenCells cells(before);
    const auto after = [&](const Eigen::Isometry3d& T) {
      return inPlaceAfter(T, cells, before, now, asked);
    };
    const InPlace in_place = after(step);
    double most = 0, off_m = 0;
    for (const Eigen::Isometry3d& other : otherMotions()) {
      if (in_place.of_all >= kInPlace) break;
      const double apart_m = distanceBetween(other, step);
      if (apart_m < kLeastDifference_m) continue;
      const double more = after(other).of_all;
      if (more <= most || more < kExplains) continue;
      most = more;
      off_m = apart_m;
    }
    const double excess = most - in_place.of_all;
    excess_sum = std::max(0.0, excess_sum + (most > 0 ? excess : 0) - kByChance);
    off_sum_m = excess_sum > 0 ? off_sum_m + off_m : 0;
    if (most > 0 && excess >= kClearlyMore) return off_m;
    if (excess_sum >= kClearlyMoreInAll) return off_sum_m;
    if (isUnusual(step) && usual_in_place.size() >= kFewestSteps &&
        in_place.of_overlap <
            kMuchLess * medianOf(std::vector<double>(usual_in_place.begin(), usual_in_place.end())))
      return distanceBetween(step, *last_step);
    if (std::isfinite(in_place.of_overlap)) usual_in_place.push_back(in_place.of_overlap);
    if (usual_in_place.size() > kUsualSteps) usual_in_place.pop_front();
    return std::nullopt;
  }

  /// As it moved before, as it did when it moved last, and not at all.
  std::vector<Eigen::Isometry3d> otherMotions() const {
    std::vector<Eigen::Isometry3d> motions{Eigen::Isometry3d::Identity()};
    if (last_step) motions.push_back(*last_step);
    if (last_move) motions.push_back(*last_move);
    return motions;
  }

  bool isUnusual(const Eigen::Isometry3d& step) const {
    return last_step && (distanceBetween(step, *last_step) > kUnusual_m ||
                         rotationBetween(step, *last_step) > kUnusual_rad);
  }

  void takeStep(const Eigen::Isometry3d& step) {
    last_step = step;
    if (step.translation().norm() >= kLeastDifference_m) last_move = step;
  }

  /// What was learned of the motion holds behind a jump as well; the sum begins again.
  void forget() { excess_sum = off_sum_m = 0; }

  const LabelSet labels;
  Look before;
  std::size_t added = 0;
  std::optional<Eigen::Isometry3d> last_step, last_move;  ///< that the scans did not contradict
  std::deque<double> usual_in_place;                      ///< of the overlap
  double excess_sum = 0, off_sum_m = 0;                   ///< of other motions over the odometry
};

OdometryCheck::OdometryCheck(LabelSet labels)
    : state_(std::make_unique<State>(std::move(labels))) {}
OdometryCheck::OdometryCheck(OdometryCheck&&) noexcept = default;
OdometryCheck& OdometryCheck::operator=(OdometryCheck&&) noexcept = default;
OdometryCheck::~OdometryCheck() = default;

std::optional<OdometryJump> OdometryCheck::add(const PreprocessedFrame& frame) {
  return state_->add(frame);
}

std::vector<OdometryJump> findJumps(const FrameSource& recording, const Options& options) {
  std::vector<OdometryJump> jumps;
  const auto classified = withClasses(recording, options);
  OdometryCheck odometry(classified->labels());
  preprocessRecording(*classified, options, [&](const PreprocessedFrame& frame) {
    if (const auto jump = odometry.add(frame)) jumps.push_back(*jump);
  });
  return jumps;
}

}  // namespace xview
