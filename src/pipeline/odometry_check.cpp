// SPDX-License-Identifier: BSD-3-Clause
#include "xview/odometry_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
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
/// Share of the points that another motion must explain, by which it must exceed that of the
/// odometry, and how far it must be from it: depth errors that go with the camera look like a
/// sensor that stands.
constexpr double kExplains = 0.5, kClearlyMore = 0.35, kLeastOff_m = 2.5;
/// Share of the points that lie in place for a sensor that stands: an avenue whose trees stand as
/// far apart as the sensor moved has fewer. Where the odometry stands and fewer points lie in
/// place, another motion must exceed it by this share.
constexpr double kStands = 0.8, kMoreThanStanding = 0.2;
/// From this on no other motion can explain clearly more.
constexpr double kInPlace = 0.85;
/// Difference to the step before with which a step is unusual, at least and as a multiple of usual
/// steps: one around a corner differs by 1.4 of them.
constexpr double kUnusual_m = 2, kUnusualSteps = 2;
/// Behind a corner a street looks as it did before it, so motions that differ by such a turn are
/// not told apart, unless the step is longer than usual ones.
constexpr double kTurn_rad = 0.5;
/// Multiple of the usual step that is believed only if the scans support it.
constexpr double kWildSteps = 8;
constexpr double kLeastMove_m = 0.5;  ///< of a sensor that does not stand
/// A frame to which later ones are compared is left behind after such a way, but not after fewer
/// steps than these, and at the latest after so many.
constexpr double kAnchorEvery_m = 4;
constexpr int kFewestSince = 4, kMostSince = 40;
constexpr double kMuchLess = 0.5;  ///< share of what usual steps leave in place
constexpr std::size_t kUsualSteps = 16, kFewestSteps = 3;

using Points = std::vector<std::pair<Eigen::Vector3f, std::uint32_t>>;  ///< and their labels

/// How far a look reaches, by direction.
class Sight {
 public:
  void add(const Eigen::Vector3f& p) {
    float& reach = reach_m_[binOf(p)];
    reach = std::max(reach, p.norm());
  }
  bool reaches(const Eigen::Vector3f& p) const { return p.norm() <= reach_m_[binOf(p)]; }

 private:
  static constexpr int kAround = 36, kUp = 18;
  static std::size_t binOf(const Eigen::Vector3f& p) {
    constexpr auto kPi = static_cast<float>(M_PI);
    const float around = (std::atan2(p.y(), p.x()) + kPi) / (2 * kPi) * kAround,
                up = (std::atan2(p.z(), p.head<2>().norm()) / kPi + 0.5F) * kUp;
    return static_cast<std::size_t>(std::min(static_cast<int>(up), kUp - 1) * kAround +
                                    std::min(static_cast<int>(around), kAround - 1));
  }
  std::array<float, kAround * kUp> reach_m_{};
};

/// What a frame has seen, relative to its sensor, along the axes of the odometry.
struct Look {
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  std::int64_t number = 0;  ///< of the frame
  Points points;
  Sight sight;
  bool aerial = false;
  double side_m = kLeastSide_m;
};

Look lookOf(const PreprocessedFrame& frame, const LabelSet& labels) {
  Look look;
  look.T_odom_sensor = frame.T_odom_sensor;
  look.number = frame.number;
  look.aerial = frame.aerial;
  const auto sensor = (frame.T_odom_sensor.translation() - frame.cloud.origin).cast<float>().eval();
  const auto reach = static_cast<float>(frame.aerial ? INFINITY : kReach_m);
  std::vector<float> sigmas;
  for (const Point& p : frame.cloud.points) {
    if (labels.role(p.label) == Role::ignored) continue;
    if (!frame.aerial && p.sigma > kMostSigma_m) continue;
    const Eigen::Vector3f from_sensor = p.getVector3fMap() - sensor;
    if (!(from_sensor.squaredNorm() <= reach * reach)) continue;
    look.sight.add(from_sensor);
    if (!frame.aerial && isGround(labels.kind(p.label))) continue;
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
  double of_overlap = 0;  ///< of the points in sight of the look before; NaN if they are few
};

InPlace inPlaceAfter(const Eigen::Isometry3d& T_before_now, const SeenCells& before,
                     const Look& look_before, const Look& now, const Points& asked) {
  // Both looks keep the axes of the odometry.
  const Eigen::Matrix3d R_odom_before = look_before.T_odom_sensor.linear();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R_odom_before * T_before_now.linear() * now.T_odom_sensor.linear().transpose();
  T.translation() = R_odom_before * T_before_now.translation();
  const Eigen::Isometry3f T_float = T.cast<float>();
  std::size_t overlap = 0, found = 0;
  for (const auto& [p, label] : asked) {
    const Eigen::Vector3f moved = T_float * p;
    if (!look_before.sight.reaches(moved)) continue;
    ++overlap;
    found += before.holdNear(moved, label);
  }
  const auto share = [&](std::size_t of) {
    return static_cast<double>(found) / static_cast<double>(of);
  };
  return {share(asked.size()), overlap >= kFewestAsked ? share(overlap) : NAN};
}

double distanceBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace

struct OdometryCheck::State {
  explicit State(LabelSet known) : labels(std::move(known)) {}

  std::optional<OdometryJump> add(const PreprocessedFrame& frame) {
    Look now = lookOf(frame, labels);
    const Points asked = someOf(now.points);
    std::optional<double> off_m;
    if (added > 0) off_m = offSinceLast(now, asked);
    if (!off_m && added > 0) off_m = offSinceAnchor(now, asked);
    if (added == 0 || off_m || !anchor) beginAt(now);
    before = std::move(now);
    ++added;
    if (!off_m) return std::nullopt;
    return OdometryJump{added - 1, frame.number, *off_m * frame.size};
  }

  /// How far the last step is from a motion that explains the scans clearly better, or from the
  /// usual one, if it is unusual and leaves much less in place.
  std::optional<double> offSinceLast(const Look& now, const Points& asked) {
    const Eigen::Isometry3d step = stepBetween(before, now);
    // Where frames between are missing, a step may be longer than others.
    const bool is_whole = !last_count || now.number - before.number <= *last_count;
    InPlace in_place{0, NAN};
    if (tell(before, now, asked)) {
      std::vector<Eigen::Isometry3d> others{Eigen::Isometry3d::Identity()};
      if (last_step) others.push_back(*last_step);
      if (last_move) others.push_back(*last_move);
      if (const auto off_m = offBy(before, now, asked, others, false, in_place)) return off_m;
      if (is_whole && isUnusual(step) && usual_in_place.size() >= kFewestSteps &&
          in_place.of_overlap < kMuchLess * usual(usual_in_place))
        return distanceBetween(step, *last_step);
      if (std::isfinite(in_place.of_overlap)) usual_in_place.push_back(in_place.of_overlap);
      if (usual_in_place.size() > kUsualSteps) usual_in_place.pop_front();
    }
    if (is_whole && !std::isfinite(in_place.of_overlap) && isWild(step))
      return distanceBetween(step, *last_step);
    last_step = step;
    last_count = now.number - before.number;
    steps_m.push_back(step.translation().norm());
    if (steps_m.size() > kUsualSteps) steps_m.pop_front();
    if (step.translation().norm() >= kLeastMove_m) last_move = step;
    return std::nullopt;
  }

  /// The same over some steps: an odometry that is stuck, or moves while the sensor stands, is off
  /// by no more than a step from one frame to the next.
  std::optional<double> offSinceAnchor(const Look& now, const Points& asked) {
    if (!anchor) return std::nullopt;
    ++since_anchor;
    if (move_at_anchor) moved_on = moved_on * *move_at_anchor;
    const double way_m =
        std::max(stepBetween(*anchor, now).translation().norm(), moved_on.translation().norm());
    if (since_anchor < kFewestSince || (way_m < kAnchorEvery_m && since_anchor < kMostSince))
      return std::nullopt;
    std::optional<double> off_m;
    InPlace in_place;
    if (tell(*anchor, now, asked))
      off_m = offBy(*anchor, now, asked, {Eigen::Isometry3d::Identity(), moved_on}, true, in_place);
    anchor.reset();
    return off_m;
  }

  void beginAt(const Look& look) {
    anchor = look;
    move_at_anchor = last_move;
    moved_on = Eigen::Isometry3d::Identity();
    since_anchor = 0;
  }

  static Eigen::Isometry3d stepBetween(const Look& a, const Look& b) {
    return a.T_odom_sensor.inverse() * b.T_odom_sensor;
  }
  static bool tell(const Look& a, const Look& b, const Points& asked) {
    return asked.size() >= kFewestAsked && a.points.size() >= kFewestAsked && a.aerial == b.aerial;
  }

  /// How far the odometry is from the best of other motions, if that explains clearly more.
  std::optional<double> offBy(const Look& from, const Look& now, const Points& asked,
                              const std::vector<Eigen::Isometry3d>& others, bool may_leave,
                              InPlace& in_place) const {
    const Eigen::Isometry3d step = stepBetween(from, now);
    const SeenCells cells(from);
    in_place = inPlaceAfter(step, cells, from, now, asked);
    if (in_place.of_all >= kInPlace) return std::nullopt;
    // A step that leaves the sight of the look before is a jump if another one does not; a way may
    // leave it.
    const bool overlaps = std::isfinite(in_place.of_overlap);
    if (!overlaps && may_leave) return std::nullopt;
    const bool only_odometry_stands =
        overlaps && in_place.of_overlap < kStands && step.translation().norm() < kLeastMove_m;
    double most = std::max(kExplains, (only_odometry_stands ? kMoreThanStanding : kClearlyMore) +
                                          (overlaps ? in_place.of_overlap : in_place.of_all));
    std::optional<double> off_m;
    for (const Eigen::Isometry3d& other : others) {
      const double apart_m = distanceBetween(other, step);
      if (apart_m < kLeastOff_m) continue;
      if (rotationBetween(other, step) > kTurn_rad && (may_leave || !isLong(step))) continue;
      const double explained = inPlaceAfter(other, cells, from, now, asked).of_overlap;
      if (!(explained >= most)) continue;
      if (other.translation().norm() < kLeastMove_m && explained < kStands) continue;
      most = explained;
      off_m = apart_m;
    }
    return off_m;
  }

  bool isUnusual(const Eigen::Isometry3d& step) const {
    return last_step && distanceBetween(step, *last_step) > leastUnusual_m();
  }
  bool isLong(const Eigen::Isometry3d& step) const {
    return step.translation().norm() > leastUnusual_m();
  }
  double leastUnusual_m() const {
    return std::max(kUnusual_m, steps_m.empty() ? 0 : kUnusualSteps * usual(steps_m));
  }
  /// No scan supports such a step.
  bool isWild(const Eigen::Isometry3d& step) const {
    return isUnusual(step) && steps_m.size() >= kFewestSteps &&
           step.translation().norm() > kWildSteps * usual(steps_m);
  }
  static double usual(const std::deque<double>& values) {
    return medianOf(std::vector<double>(values.begin(), values.end()));
  }

  const LabelSet labels;
  Look before;
  std::size_t added = 0;
  std::optional<Eigen::Isometry3d> last_step, last_move;  ///< that the scans did not contradict
  std::optional<std::int64_t> last_count;  ///< frame numbers from one to the next there
  std::deque<double> steps_m;              ///< their lengths
  std::deque<double> usual_in_place;       ///< of the overlap
  std::optional<Look> anchor;
  std::optional<Eigen::Isometry3d> move_at_anchor;
  Eigen::Isometry3d moved_on = Eigen::Isometry3d::Identity();  ///< since then, at that pace
  int since_anchor = 0;                                        ///< steps
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
