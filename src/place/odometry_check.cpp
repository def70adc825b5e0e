// SPDX-License-Identifier: BSD-3-Clause
#include "place/odometry_check.h"

#include <pcl/common/centroid.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <utility>
#include <vector>

#include "base/cells.h"
#include "base/median.h"
#include "base/pose.h"
#include "place/raw_recording.h"
#include "xview/place_builder.h"

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
/// At which a turn counts as a distance.
constexpr double kArm_m = 8;
/// How far the sensor must have moved on where the odometry stands, if all telling points say so.
constexpr double kLeastOffStuck_m = 1;
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
/// not told apart, unless the step is longer than usual ones or leads to what has been in sight.
constexpr double kTurn_rad = 0.5;
/// Multiple of the usual step that is believed only if the scans support it.
constexpr double kWildSteps = 8;
/// Of a sensor that does not stand.
constexpr double kLeastMove_m = 0.5, kLeastTurn_rad = 0.05;
/// A frame to which later ones are compared is left behind after such a way, but not after fewer
/// steps than these, and at the latest after so many.
constexpr double kAnchorEvery_m = 4;
constexpr int kFewestSince = 4, kMostSince = 40;
constexpr double kMuchLess = 0.5;    ///< share of what usual steps leave in place, or would now
constexpr double kHardlyAny = 0.35;  ///< the same, of what one sees who was carried away
constexpr std::size_t kUsualSteps = 16, kFewestSteps = 3;
/// The odometry rolls if the ground turns by more than this angle within this length of the way,
/// in the medians of this number of frames: hills and ramps turn by up to 13 degrees there.
constexpr double kMostLean_rad = 0.3, kLeanWithin_m = 40;
constexpr std::size_t kLeanFrames = 5;

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
  double stamp_s = 0;
  Points points;
  Sight sight;
  std::optional<Eigen::Vector3d> ground;  ///< its normal, up; none if too little of it is seen
  bool aerial = false;
  double side_m = kLeastSide_m;
};

/// The normal of the ground plane, up; none if few points show it or they lie on a line. Points
/// that are not in the plane (kerbs, wrong labels) are left out of the second and third fit.
std::optional<Eigen::Vector3d> groundNormal(const pcl::PointCloud<Point>& points,
                                            pcl::Indices ground) {
  constexpr std::size_t kFewest = 50;
  constexpr int kFits = 3;
  constexpr double kMostSlope_rad = 0.7;            ///< more is a wall with a wrong label
  constexpr double kLeastWidth_m = 1, kFlat = 0.1;  ///< standard deviations: across, off to across
  constexpr double kOutliers = 2.5;                 ///< medians off the plane
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (int fit = 0; fit < kFits; ++fit) {
    Eigen::Matrix3d covariance;
    Eigen::Vector4d mean;
    if (ground.size() < kFewest ||
        pcl::computeMeanAndCovarianceMatrix(points, ground, covariance, mean) == 0)
      return std::nullopt;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
    const double across_m = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
    if (across_m < kLeastWidth_m || std::sqrt(axes.eigenvalues()[0]) > kFlat * across_m)
      return std::nullopt;
    normal = axes.eigenvectors().col(0);
    const auto offPlane_m = [&](int i) {
      return std::abs(normal.dot(points[i].getVector3fMap().cast<double>() - mean.head<3>()));
    };
    std::vector<double> off_m;
    for (const int i : ground) off_m.push_back(offPlane_m(i));
    const double most_m = kOutliers * medianOf(std::move(off_m));
    ground.erase(
        std::remove_if(ground.begin(), ground.end(), [&](int i) { return offPlane_m(i) > most_m; }),
        ground.end());
  }
  if (normal.z() < 0) normal = -normal;
  if (normal.z() < std::cos(kMostSlope_rad)) return std::nullopt;
  return normal;
}

Look lookOf(const PreprocessedFrame& frame, const LabelSet& labels) {
  Look look;
  look.T_odom_sensor = frame.T_odom_sensor;
  look.number = frame.number;
  look.stamp_s = frame.stamp_s;
  look.aerial = frame.aerial;
  const auto sensor = (frame.T_odom_sensor.translation() - frame.cloud.origin).cast<float>().eval();
  const auto reach = static_cast<float>(frame.aerial ? INFINITY : kReach_m);
  std::vector<float> sigmas;
  pcl::Indices ground;
  for (const Point& p : frame.cloud.points) {
    if (labels.role(p.label) == Role::ignored) continue;
    if (!frame.aerial && p.sigma > kMostSigma_m) continue;
    const Eigen::Vector3f from_sensor = p.getVector3fMap() - sensor;
    if (!(from_sensor.squaredNorm() <= reach * reach)) continue;
    look.sight.add(from_sensor);
    if (!frame.aerial && isGround(labels.kind(p.label))) {
      ground.push_back(static_cast<int>(&p - frame.cloud.points.data()));
      continue;
    }
    look.points.emplace_back(from_sensor, p.label);
    sigmas.push_back(p.sigma);
  }
  if (frame.aerial)
    look.side_m = kSideFromTheAir_m;
  else if (!sigmas.empty())
    look.side_m =
        std::clamp(kSidePerSigma * medianOf(std::move(sigmas)), kLeastSide_m, kMostSide_m);
  look.ground = groundNormal(frame.cloud.points, std::move(ground));
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
  enum class Of : std::uint8_t { unseen, empty, found };  ///< a point, in the look before
  std::vector<Of> points;
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
  InPlace result;
  result.points.reserve(asked.size());
  std::size_t overlap = 0, found = 0;
  for (const auto& [p, label] : asked) {
    const Eigen::Vector3f moved = T_float * p;
    InPlace::Of of = InPlace::Of::unseen;
    if (look_before.sight.reaches(moved)) {
      ++overlap;
      of = before.holdNear(moved, label) ? InPlace::Of::found : InPlace::Of::empty;
      found += of == InPlace::Of::found;
    }
    result.points.push_back(of);
  }
  const auto share = [&](std::size_t of) {
    return static_cast<double>(found) / static_cast<double>(of);
  };
  result.of_all = share(asked.size());
  result.of_overlap = overlap >= kFewestAsked ? share(overlap) : NAN;
  return result;
}

/// Points that lie in place after one motion and not after another one, in sight after both.
std::size_t telling(const InPlace& one, const InPlace& other) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < one.points.size(); ++i)
    count += one.points[i] == InPlace::Of::found && other.points[i] == InPlace::Of::empty;
  return count;
}

/// Walls along the way lie in place after any motion along them. Of the points that tell two
/// motions apart nearly all speak for the other one.
bool allTellingPointsAreFor(const InPlace& other, const InPlace& odometry) {
  constexpr std::size_t kFewestTelling = 20;
  constexpr std::size_t kTimesMore = 4, kByChance = 2;
  const std::size_t in_favour = telling(other, odometry);
  return in_favour >= kFewestTelling &&
         in_favour >= kTimesMore * (telling(odometry, other) + kByChance);
}

double distanceBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

/// How far apart two motions put what the sensor sees. That it stands is told from a step by the
/// way or by the turn, not by a little of both: depth errors go with a camera that begins to turn.
double apartBetween(const Eigen::Isometry3d& other, const Eigen::Isometry3d& step, bool moves) {
  const double way_m = distanceBetween(other, step), turn_m = kArm_m * rotationBetween(other, step);
  return moves ? way_m + turn_m : std::max(way_m, turn_m);
}

bool looksAround(const Points& points) {
  constexpr std::size_t kSectors = 12, kMost = 10;
  std::array<bool, kSectors> seen{};
  for (const auto& [p, label] : points) {
    const double turns = std::atan2(p.y(), p.x()) / (2 * M_PI) + 0.5;
    seen[std::min(kSectors - 1, static_cast<std::size_t>(turns * kSectors))] = true;
  }
  return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), true)) >= kMost;
}

double medianRange(const Points& points) {
  std::vector<double> ranges;
  for (const auto& [p, label] : points) ranges.push_back(p.norm());
  return medianOf(std::move(ranges));
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
    if (!off_m) off_m = offByLean(now);
    if (off_m) {
      grounds.clear();
      is_told = true;
    }
    if (added == 0 || off_m || !anchor) beginAt(now);
    before = std::move(now);
    ++added;
    if (!off_m) return std::nullopt;
    return OdometryJump{added - 1, frame.number, *off_m * frame.size};
  }

  /// How far the last step is from a motion that explains the scans clearly better, or from the
  /// usual one, if it is unusual and leaves much less in place; where hardly anything is in place,
  /// about as far as one sees.
  std::optional<double> offSinceLast(const Look& now, const Points& asked) {
    const Eigen::Isometry3d step = stepBetween(before, now);
    // Where frames between are missing, a step may be longer than others.
    constexpr double kPause = 1.5;
    const double gap_s = now.stamp_s - before.stamp_s;
    is_told = false;
    const bool is_whole = !last_count || (now.number - before.number <= *last_count &&
                                          gap_s <= kPause * std::max(last_gap_s, 0.0));
    double of_overlap = NAN;
    if (tell(before, now, asked)) {
      const SeenCells cells(before);
      const Comparison compared = compare(before, cells, now, asked, othersThan(step), false);
      const InPlace& in_place = compared.by_odometry;
      of_overlap = in_place.of_overlap;
      tallyStep(step, cells, in_place, now, asked);
      if (compared.off_m) return compared.off_m;
      if (is_whole && isUnusual(step) && usual_in_place.size() >= kFewestSteps &&
          (of_overlap < kMuchLess * usual(usual_in_place) ||
           (compared.most_by_others >= kExplains &&
            in_place.of_all < kMuchLess * compared.most_by_others)))
        return distanceBetween(step, *last_step);
      // Whoever looks around loses little out of sight behind corners, as a camera does that turns.
      if (is_whole && usual_in_place.size() >= kFewestSteps && usual(usual_in_place) >= kMuchLess &&
          looksAround(asked) && of_overlap < kHardlyAny * usual(usual_in_place))
        return medianRange(asked);
      is_told = std::isfinite(of_overlap) && (usual_in_place.size() < kFewestSteps ||
                                              of_overlap >= kMuchLess * usual(usual_in_place));
      if (std::isfinite(of_overlap)) usual_in_place.push_back(of_overlap);
      if (usual_in_place.size() > kUsualSteps) usual_in_place.pop_front();
    }
    if (is_whole && !std::isfinite(of_overlap) && isWild(step))
      return distanceBetween(step, *last_step);
    last_step = step;
    last_count = now.number - before.number;
    last_gap_s = gap_s;
    steps_m.push_back(step.translation().norm());
    if (steps_m.size() > kUsualSteps) steps_m.pop_front();
    if (step.translation().norm() >= kLeastMove_m) last_move = step;
    return std::nullopt;
  }

  /// Motions that the sensor may have made instead of a step.
  std::vector<Eigen::Isometry3d> othersThan(const Eigen::Isometry3d& step) const {
    std::vector<Eigen::Isometry3d> others{Eigen::Isometry3d::Identity()};
    if (last_step && last_step->translation().norm() < kLeastMove_m) others.push_back(*last_step);
    if (!last_move) return others;
    others.push_back(*last_move);
    // An odometry that slips around a corner knows how far it turned.
    others.push_back(*last_move);
    others.back().linear() = step.linear();
    return others;
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
    std::vector<Eigen::Isometry3d> others{moved_on};
    if (!movesStepByStep()) others.push_back(Eigen::Isometry3d::Identity());
    std::optional<double> off_m;
    if (tell(*anchor, now, asked))
      off_m = compare(*anchor, SeenCells(*anchor), now, asked, others, true).off_m;
    anchor.reset();
    return off_m;
  }

  /// How far the odometry is bent off since some way ago, if the ground leans since then.
  std::optional<double> offByLean(const Look& now) {
    if (added > 0) travelled_m += stepBetween(before, now).translation().norm();
    if (!now.ground) return std::nullopt;
    grounds.push_back({travelled_m, *now.ground});
    while (travelled_m - grounds.front().at_m > kLeanWithin_m) grounds.pop_front();
    if (grounds.size() < 2 * kLeanFrames) return std::nullopt;
    const double lean_rad = std::acos(
        std::clamp(medianNormal(0).dot(medianNormal(grounds.size() - kLeanFrames)), -1.0, 1.0));
    if (lean_rad < kMostLean_rad) return std::nullopt;
    return lean_rad * (travelled_m - grounds.front().at_m) / 2;
  }
  /// Median of each coordinate over some frames.
  Eigen::Vector3d medianNormal(std::size_t first) const {
    Eigen::Vector3d normal;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (std::size_t i = first; i < first + kLeanFrames; ++i)
        values.push_back(grounds[i].normal[axis]);
      normal[axis] = medianOf(std::move(values));
    }
    return normal.normalized();
  }

  /// Over several steps posts of a road may take one another's place, as if the sensor stood. From
  /// step to step they do not.
  bool movesStepByStep() const {
    constexpr std::size_t kFewest = 40;
    return for_steps >= kFewest && 2 * for_steps >= for_standing;
  }
  void tallyStep(const Eigen::Isometry3d& step, const SeenCells& cells, const InPlace& in_place,
                 const Look& now, const Points& asked) {
    if (step.translation().norm() < kLeastMove_m) return;
    const InPlace standing = inPlaceAfter(Eigen::Isometry3d::Identity(), cells, before, now, asked);
    for_steps += telling(in_place, standing);
    for_standing += telling(standing, in_place);
  }

  void beginAt(const Look& look) {
    anchor = look;
    move_at_anchor = last_move;
    moved_on = Eigen::Isometry3d::Identity();
    since_anchor = 0;
    for_steps = for_standing = 0;
  }

  static Eigen::Isometry3d stepBetween(const Look& a, const Look& b) {
    return a.T_odom_sensor.inverse() * b.T_odom_sensor;
  }
  static bool tell(const Look& a, const Look& b, const Points& asked) {
    return asked.size() >= kFewestAsked && a.points.size() >= kFewestAsked && a.aerial == b.aerial;
  }

  /// The odometry beside other motions, between two looks.
  struct Comparison {
    InPlace by_odometry;
    double most_by_others = 0;    ///< share of all points, by another motion than standing
    std::optional<double> off_m;  ///< from the best of them, if that explains clearly more
  };
  Comparison compare(const Look& from, const SeenCells& cells, const Look& now, const Points& asked,
                     const std::vector<Eigen::Isometry3d>& others, bool may_leave) const {
    const Eigen::Isometry3d step = stepBetween(from, now);
    Comparison result{inPlaceAfter(step, cells, from, now, asked), 0, {}};
    const InPlace& in_place = result.by_odometry;
    if (may_leave && in_place.of_all >= kInPlace) return result;
    // A step that leaves the sight of the look before is a jump if another one does not; a way may
    // leave it.
    const bool overlaps = std::isfinite(in_place.of_overlap);
    if (!overlaps && may_leave) return result;
    const bool is_on_the_spot = step.translation().norm() < kLeastMove_m;
    const bool may_be_stuck =
        is_on_the_spot && rotationBetween(step, Eigen::Isometry3d::Identity()) < kLeastTurn_rad;
    const bool only_odometry_stands = overlaps && in_place.of_overlap < kStands && may_be_stuck;
    double most = std::max(kExplains, (only_odometry_stands ? kMoreThanStanding : kClearlyMore) +
                                          (overlaps ? in_place.of_overlap : in_place.of_all));
    for (const Eigen::Isometry3d& other : others) {
      const bool moves = other.translation().norm() >= kLeastMove_m;
      const double apart_m = apartBetween(other, step, moves);
      const bool is_clear = apart_m >= kLeastOff_m;
      if (!is_clear && !(may_be_stuck && moves && apart_m >= kLeastOffStuck_m)) continue;
      if (rotationBetween(other, step) > kTurn_rad && (may_leave || !(overlaps || isLong(step))))
        continue;
      const InPlace by_other = inPlaceAfter(other, cells, from, now, asked);
      const double explained = by_other.of_overlap;
      if (moves && !now.aerial)
        result.most_by_others = std::max(result.most_by_others, by_other.of_all);
      if (!moves) {
        if (!(explained >= std::max(most, kStands))) continue;
      } else if (!(explained >= most && is_clear)) {
        // Over more than a step houses of a street may take one another's place, from the air what
        // is parked, and where the sensor turns on the spot what stands around it.
        const bool may_turn_only =
            !may_be_stuck && (is_on_the_spot || in_place.of_overlap >= kStands);
        const bool is_turned_only =
            distanceBetween(other, step) < (may_turn_only ? kLeastOff_m : kLeastOffStuck_m);
        if (result.off_m || may_leave || now.aerial || is_turned_only || !(explained >= kExplains))
          continue;
        if (!allTellingPointsAreFor(by_other, in_place)) continue;
      }
      most = explained;
      result.off_m = apart_m;
    }
    return result;
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
  bool is_told = true;                                    ///< the last step, by the scans
  std::optional<Eigen::Isometry3d> last_step, last_move;  ///< that the scans did not contradict
  std::optional<std::int64_t> last_count;  ///< frame numbers from one to the next there
  double last_gap_s = 0;
  std::deque<double> steps_m;         ///< their lengths
  std::deque<double> usual_in_place;  ///< of the overlap
  struct Ground {
    double at_m;  ///< of the way
    Eigen::Vector3d normal;
  };
  std::deque<Ground> grounds;  ///< since the last jump
  double travelled_m = 0;
  std::optional<Look> anchor;
  std::optional<Eigen::Isometry3d> move_at_anchor;
  Eigen::Isometry3d moved_on = Eigen::Isometry3d::Identity();  ///< since then, at that pace
  std::size_t for_steps = 0, for_standing = 0;                 ///< telling points since then
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

bool OdometryCheck::tellsLastStep() const { return state_->is_told; }

std::optional<double> OdometryCheck::hardlyInPlace() const {
  constexpr std::size_t kFewest = 8;
  const std::deque<double>& shares = state_->usual_in_place;
  if (shares.size() < kFewest) return std::nullopt;
  const double share = State::usual(shares);
  return share < kHardlyAny ? std::optional(share) : std::nullopt;
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
