// SPDX-License-Identifier: BSD-3-Clause
#include "base/stray_points.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

#include "base/median.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr std::size_t kSampled = 2000;  ///< points that tell where most of them lie
constexpr double kOutermost = 0.1;      ///< share of points on either side that may all be strays
constexpr double kApart = 20;           ///< times the reach of the others: no part of their place
constexpr double kNearest_m = 1e3;      ///< what is nearer to the middle is never left out
constexpr double kFarthest_m = 1e6;     ///< and what is farther always, but of larger units,
constexpr double kWhole = 2;            ///< whose clouds are no farther from end to end
constexpr double kWidest_m = 1e7;  ///< the points of a continent in metres, of a town in others
/// No coordinates of the Earth are larger, nor in millimetres; float32 has steps of 8 m there, and
/// double of a tenth of a millimetre.
constexpr double kFarthestFloat_m = 1e8, kFarthestDouble_m = 1e12;
constexpr std::size_t kFewestRepeats = 50;     ///< of one position; fewer may be chance
constexpr double kLeastRepeated = 0.01;        ///< of all points
constexpr std::ptrdiff_t kFewestInSample = 4;  ///< of a position that is worth counting

/// Numbers of points spread over all of them, in no step that rows of an image might have.
std::vector<std::size_t> sampleOf(std::size_t count) {
  const std::size_t step = 1 + count / kSampled;
  std::vector<std::size_t> numbers;
  numbers.reserve(count / step + 1);
  for (std::size_t first = 0; first < count; first += step)
    numbers.push_back(std::min(count - 1, first + first * 2654435761u % step));
  return numbers;
}

/// Where most of the points lie along each axis.
struct Bulk {
  Eigen::Vector3d low, middle, high;
  double reach() const { return (high - low).maxCoeff(); }
};

/// There must be a position.
Bulk bulkOf(const std::vector<Eigen::Vector3d>& sample, double outermost) {
  Bulk bulk;
  std::vector<double> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Eigen::Vector3d& p : sample) values.push_back(p[axis]);
    const auto outside = static_cast<std::size_t>(outermost * static_cast<double>(values.size()));
    bulk.low[axis] = rankedOf(values, outside);
    bulk.middle[axis] = quantileOf(values, 0.5);
    bulk.high[axis] = rankedOf(values, values.size() - 1 - outside);
  }
  return bulk;
}

/// Positions that stand in the sample again and again.
std::vector<Eigen::Vector3d> repeatedIn(std::vector<Eigen::Vector3d> sample) {
  std::sort(sample.begin(), sample.end(), [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
  });
  std::vector<Eigen::Vector3d> repeated;
  for (auto first = sample.begin(); first != sample.end();) {
    const auto end =
        std::find_if(first, sample.end(), [&](const Eigen::Vector3d& p) { return p != *first; });
    if (end - first >= kFewestInSample) repeated.push_back(*first);
    first = end;
  }
  return repeated;
}

/// Which points of a cloud are strays.
class Strays {
 public:
  /// `at(i)` is the position of point i.
  template <class At>
  Strays(const std::string& name, std::size_t count, double farthest_m, const At& at) {
    left_out_.of = count;
    std::vector<Eigen::Vector3d> sample;
    for (const std::size_t i : sampleOf(count)) {
      if (const Eigen::Vector3d p = at(i); p.allFinite()) sample.push_back(p);
    }
    if (sample.empty()) return;
    findRepeated(count, sample, at);
    sample.erase(std::remove_if(sample.begin(), sample.end(),
                                [this](const Eigen::Vector3d& p) { return isRepeat(p); }),
                 sample.end());
    if (sample.empty()) return;
    const Bulk bulk = bulkOf(sample, kOutermost);
    middle_ = bulk.middle;
    limit_m_ =
        std::clamp(kApart * bulk.reach(), kNearest_m, std::max(kFarthest_m, kWhole * bulk.reach()));
    left_out_.farther_than_m = limit_m_;
    for (std::size_t i = 0; i < count; ++i) countIfStray(at(i));
    requirePlace(name, bulk, farthest_m);
  }

  bool isStray(const Eigen::Vector3d& p) const { return isRepeat(p) || isFar(p); }
  /// What is not finite was no point, and is not worth a word.
  bool any() const { return left_out_.any() || not_finite_ > 0; }
  const LeftOut& leftOut() const { return left_out_; }

 private:
  bool isRepeat(const Eigen::Vector3d& p) const {
    return !repeated_.empty() &&
           std::find(repeated_.begin(), repeated_.end(), p) != repeated_.end();
  }
  bool isFar(const Eigen::Vector3d& p) const {
    return !((p - middle_).cwiseAbs().maxCoeff() <= limit_m_);
  }
  void countIfStray(const Eigen::Vector3d& p) {
    if (isRepeat(p))
      ++left_out_.repeated;
    else if (!p.allFinite())
      ++not_finite_;
    else if (isFar(p))
      ++left_out_.far;
  }

  template <class At>
  void findRepeated(std::size_t count, const std::vector<Eigen::Vector3d>& sample, const At& at) {
    const auto fewest =
        std::max(static_cast<double>(kFewestRepeats), kLeastRepeated * static_cast<double>(count));
    for (const Eigen::Vector3d& candidate : repeatedIn(sample)) {
      std::size_t repeats = 0;
      for (std::size_t i = 0; i < count; ++i) repeats += at(i) == candidate;
      // A cloud of one point only is what it is.
      if (static_cast<double>(repeats) > fewest && repeats < count) repeated_.push_back(candidate);
    }
  }

  void requirePlace(const std::string& name, const Bulk& bulk, double farthest_m) const {
    constexpr const char* kAsk = "are their numbers of another type, byte order or unit?";
    std::ostringstream problem;
    problem.precision(3);
    const std::size_t points = left_out_.of - not_finite_ - left_out_.repeated;
    const double away_m = middle_.cwiseAbs().maxCoeff();
    if (2 * left_out_.far > points || bulk.reach() > kWidest_m) {
      const Eigen::Vector3d size = bulk.high - bulk.low;
      problem << "its points fill " << size.x() << " x " << size.y() << " x " << size.z()
              << " m, and " << left_out_.far << " of " << points << " lie more than "
              << limit_m_ / 1000 << " km from their middle, so that they are of no place; " << kAsk;
    } else if (away_m > farthest_m) {
      problem << "its points lie " << away_m << " m from zero, expected " << farthest_m
              << " m at most; " << kAsk;
    }
    if (!problem.str().empty()) throw Error(name, problem.str());
  }

  std::vector<Eigen::Vector3d> repeated_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double limit_m_ = std::numeric_limits<double>::infinity();
  std::size_t not_finite_ = 0;
  LeftOut left_out_;
};

}  // namespace

std::string LeftOut::text() const {
  std::ostringstream text;
  if (far > 0)
    text << far << " of " << of << " points lie more than " << std::round(farther_than_m / 100) / 10
         << " km from the middle of the others";
  if (repeated > 0)
    text << (far > 0 ? "; " : "") << repeated << " of " << of << " points repeat one position";
  if (far + repeated > 0) text << ", and are left out";
  if (no_class > 0)
    text << (far + repeated > 0 ? "; " : "") << no_class << " of " << of
         << " points have NaN for a class and are unlabelled";
  return text.str();
}

LeftOut& LeftOut::operator+=(const LeftOut& other) {
  of += other.of;
  far += other.far;
  repeated += other.repeated;
  no_class += other.no_class;
  farther_than_m = std::max(farther_than_m, other.farther_than_m);
  return *this;
}

void LeftOutOfFrames::set(std::size_t frame, const LeftOut& left_out) {
  if (!left_out.any()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  of_frames_[frame] = left_out;
}

LeftOut LeftOutOfFrames::sum() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  LeftOut sum;
  for (const auto& [frame, left_out] : of_frames_) sum += left_out;
  return sum;
}

Eigen::AlignedBox3d boxWithoutStrays(std::size_t count, const PositionAt& position) {
  constexpr double kOutside = 0.05, kTimesReach = 3;
  Eigen::AlignedBox3d box;
  std::vector<Eigen::Vector3d> sample;
  for (const std::size_t i : sampleOf(count)) {
    if (const Eigen::Vector3d p = position(i); p.allFinite()) sample.push_back(p);
  }
  if (sample.empty()) return box;
  const Bulk bulk = bulkOf(sample, kOutside);
  const auto margin = Eigen::Vector3d::Constant(kTimesReach * bulk.reach());
  const Eigen::AlignedBox3d near(bulk.low - margin, bulk.high + margin);
  for (std::size_t i = 0; i < count; ++i) {
    if (const Eigen::Vector3d p = position(i); near.contains(p)) box.extend(p);
  }
  return box;
}

Eigen::AlignedBox3d boxWithoutStrays(const LabelledCloud& cloud) {
  return boxWithoutStrays(cloud.size(), [&](std::size_t i) { return cloud.position(i); });
}

void leaveOutStrays(const std::string& name, LabelledCloud& cloud) {
  const auto at = [&](std::size_t i) -> Eigen::Vector3d {
    return cloud.points[i].getVector3fMap().cast<double>();
  };
  const Strays strays(name, cloud.size(), kFarthestFloat_m, at);
  cloud.left_out = strays.leftOut();
  if (!strays.any()) return;
  pcl::PointCloud<Point> kept;
  kept.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (const Eigen::Vector3d p = at(i); p.allFinite() && !strays.isStray(p))
      kept.push_back(cloud.points[i]);
  }
  cloud.points = std::move(kept);
}

void CloudBuilder::add(const Eigen::Vector3d& position, Point point) {
  if (!has_origin_ && position.cwiseAbs().maxCoeff() > far_m_) setOrigin(position);
  keepIfFar(cloud_.size(), position);
  point.getVector3fMap() = (position - cloud_.origin).cast<float>();
  cloud_.points.push_back(point);
}

void CloudBuilder::keepIfFar(std::size_t number, const Eigen::Vector3d& position) {
  constexpr double kExact_m = 16384;  // float32 has steps of 1 mm there
  if (std::isfinite(far_m_) && !((position - cloud_.origin).cwiseAbs().maxCoeff() < kExact_m))
    far_points_.push_back({number, position});
}

void CloudBuilder::setOrigin(const Eigen::Vector3d& position) {
  has_origin_ = true;
  cloud_.origin = position.array().floor();
  for (std::size_t i = 0; i < cloud_.size(); ++i) {
    const Eigen::Vector3d old = cloud_.points[i].getVector3fMap().cast<double>();
    keepIfFar(i, old);
    cloud_.points[i].getVector3fMap() = (old - cloud_.origin).cast<float>();
  }
}

Eigen::Vector3d CloudBuilder::position(std::size_t i) const {
  const auto found = std::lower_bound(
      far_points_.begin(), far_points_.end(), i,
      [](const FarPoint& point, std::size_t number) { return point.number < number; });
  if (found != far_points_.end() && found->number == i) return found->position;
  return cloud_.position(i);
}

LabelledCloud CloudBuilder::finish(const std::string& name) {
  const auto at = [this](std::size_t i) { return position(i); };
  const Strays strays(name, cloud_.size(),
                      std::isfinite(far_m_) ? kFarthestDouble_m : kFarthestFloat_m, at);
  cloud_.left_out = strays.leftOut();
  if (!strays.any()) return std::move(cloud_);
  CloudBuilder kept(far_m_);
  kept.reserve(cloud_.size());
  if (has_origin_ && !strays.isStray(cloud_.origin)) {
    kept.has_origin_ = true;
    kept.cloud_.origin = cloud_.origin;
  }
  for (std::size_t i = 0; i < cloud_.size(); ++i) {
    if (const Eigen::Vector3d p = at(i); !strays.isStray(p)) kept.add(p, cloud_.points[i]);
  }
  kept.cloud_.left_out = cloud_.left_out;
  return std::move(kept.cloud_);
}

}  // namespace xview
