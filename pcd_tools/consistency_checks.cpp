// SPDX-License-Identifier: BSD-3-Clause
#include "consistency_checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "base/pose.h"
#include "map/contents.h"
#include "place/storeys.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"
#include "xview/mapper.h"

namespace xview::tools {
namespace {

using Poses = std::vector<Eigen::Isometry3d>;

/// Class and place to the millimetre.
using Spot = std::tuple<std::uint32_t, long long, long long, long long>;
std::set<Spot> spotsOf(const map::SemanticMap& map) {
  std::set<Spot> spots;
  map::allVertices(map).forEach([&](std::uint32_t, const Vertex& v) {
    const auto mm = [&](int axis) { return std::llround(1e3 * v.position[axis]); };
    spots.emplace(v.label, mm(0), mm(1), mm(2));
  });
  return spots;
}

/// So much of the things stands in the other map, to the millimetre.
bool areSameObjects(const map::SemanticMap& addition, const map::SemanticMap& map, double share) {
  const std::set<Spot> added = spotsOf(addition), there = spotsOf(map);
  const auto common = std::count_if(added.begin(), added.end(),
                                    [&](const Spot& spot) { return there.count(spot) > 0; });
  return added.size() >= 3 &&
         static_cast<double>(common) >= share * static_cast<double>(added.size());
}

bool isInAlready(const map::SemanticMap& map, const map::SemanticMap& addition) {
  constexpr double kExact_m = 1e-3;
  if (addition.poses.empty()) return areSameObjects(addition, map, 0.9);
  if (holdsSameDrive(map, addition)) return true;
  return areSamePoses(addition.poses, map.poses, kExact_m) && areSameObjects(addition, map, 0.5);
}

/// How far two recordings lie from one another, less first: how many poses of the second are as
/// near as sensors see, with a minus, and how far the nearest one is [m].
std::pair<double, double> distanceOf(const Poses& first, const Poses& second) {
  constexpr double kSeen_m = 40;
  std::pair<double, double> distance(0, std::numeric_limits<double>::infinity());
  for (const Eigen::Isometry3d& a : second) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Isometry3d& b : first)
      nearest_m = std::min(nearest_m, (a.translation() - b.translation()).norm());
    distance.first -= nearest_m < kSeen_m;
    distance.second = std::min(distance.second, nearest_m);
  }
  return distance;
}

/// Between what the vertices of two maps fill [m]; 0 if one has none.
double gapBetween(const map::SemanticMap& first, const map::SemanticMap& second) {
  const Eigen::AlignedBox3d a = map::allVertices(first).bounds(),
                            b = map::allVertices(second).bounds();
  return a.isEmpty() || b.isEmpty() ? 0 : a.exteriorDistance(b);
}

std::string percentText(double share) {
  return fmt::format("{:.0f} %", 100 * std::clamp(share, 0.0, 1.0));
}

std::string nameOf(const map::SemanticMap& addition) {
  return addition.sources.empty() ? "the addition" : addition.sources.front();
}

/// "is 518 m away from town.xvm; are they in one frame?"
std::optional<std::string> apartness(const map::SemanticMap& map, const std::string& map_name,
                                     const map::SemanticMap& addition) {
  constexpr double kApart_m = 100;  // parts of one map touch, or nearly so
  const double apart_m = gapBetween(map, addition);
  if (apart_m <= kApart_m) return std::nullopt;
  return fmt::format("is {:.0f} m away from {}; are they in one frame?", apart_m, map_name);
}

/// Whether what two walks through rooms saw lies on several floors, mostly on others than those of
/// the other one: bird's-eye views cannot be compared then.
bool areOfSeveralFloors(const map::SemanticMap& map, const map::SemanticMap& addition) {
  constexpr double kBeside_m = 4;
  if (map.size >= kTownScale) return false;
  const Eigen::Quaterniond& upright = map.gravity.alignment;
  std::size_t above = 0, beside = 0;
  for (const Eigen::Isometry3d& T : addition.poses) {
    bool is_near = false, is_beside = false;
    for (const Eigen::Isometry3d& there : map.poses) {
      const Eigen::Vector3d way = upright * (T.translation() - there.translation());
      if (way.head<2>().norm() > kBeside_m) continue;
      is_near = true;
      is_beside = is_beside || std::abs(way.z()) < kLowestStorey_m;
    }
    above += is_near && !is_beside;
    beside += is_beside;
  }
  return above > beside || standOnSeveralFloors(map.poses, upright) ||
         standOnSeveralFloors(addition.poses, upright);
}

std::string whyInAnotherFrame(const FrameEvidence& evidence) {
  constexpr double kFits = 0.4;
  const std::string seen = evidence.area_m2 > 0
                               ? fmt::format("the {:.0f} m² that both have seen", evidence.area_m2)
                               : "what both have seen";
  const double moved = evidence.nearby / evidence.expected;
  return fmt::format(
      "of {}, {} agrees as it does between visits of one place{}", seen,
      percentText(evidence.agreement()),
      moved > kFits ? fmt::format(" (moved by {:.1f} m: {})", evidence.shift_m, percentText(moved))
                    : "");
}

}  // namespace

bool areSamePoses(const Poses& poses, const Poses& others, double tolerance_m) {
  const auto has_partner = [&](const Eigen::Isometry3d& a) {
    return std::any_of(others.begin(), others.end(), [&](const Eigen::Isometry3d& b) {
      return (a.translation() - b.translation()).norm() <= tolerance_m;
    });
  };
  const auto common = std::count_if(poses.begin(), poses.end(), has_partner);
  return !poses.empty() && 2 * static_cast<std::size_t>(common) > poses.size();
}

void logOwnDrive(const map::SemanticMap& map, const std::string& query, const Poses& T_odom_sensor,
                 const Narrative& narrate) {
  constexpr double kExact_m = 1e-3, kExact_rad = 1e-3;
  constexpr std::ptrdiff_t kFewest = 3;  // any two recordings may begin at the identity
  const auto isInMap = [&](const Eigen::Isometry3d& T) {
    return std::any_of(map.poses.begin(), map.poses.end(), [&](const Eigen::Isometry3d& other) {
      return (T.translation() - other.translation()).norm() < kExact_m &&
             rotationBetween(T, other) < kExact_rad;
    });
  };
  const bool same_name =
      std::find(map.sources.begin(), map.sources.end(), query) != map.sources.end();
  const bool has_others = T_odom_sensor.size() > 1;  // frames that the map was not made of
  const std::ptrdiff_t fewest = same_name ? has_others : kFewest;
  if (std::count_if(T_odom_sensor.begin(), T_odom_sensor.end(), isInMap) >= fewest)
    narrate.note(query +
                 " is a recording that the map was made of; that it is found there says "
                 "nothing about other visits");
}

namespace {

/// Why both cannot be in one frame.
std::optional<std::string> contradictionOf(const map::SemanticMap& addition,
                                           const map::SemanticMap& map, const std::string& map_name,
                                           const Options& options) {
  if (areOfSeveralFloors(map, addition)) return std::nullopt;
  const auto evidence = evidenceOfOneFrame(map, addition, options);
  if (!evidence || !evidence->contradicts()) return std::nullopt;
  const std::string name = nameOf(addition);
  std::string advice =
      fmt::format("`xview localize {0} {1} --matrix T.txt` finds the transform", name, map_name);
  if (!addition.cloud.empty())
    advice += fmt::format(", `xview lift {} --transform T.txt -o moved.pcd` applies it", name);
  return fmt::format("does not fit {}: {}; are they in one frame? {}", map_name,
                     whyInAnotherFrame(*evidence), advice);
}

/// Why it should not be added, though it may be in one frame.
std::optional<std::string> repetitionOf(const map::SemanticMap& addition,
                                        const map::SemanticMap& map, const std::string& map_name) {
  if (isInAlready(map, addition)) {
    return fmt::format(
        "is in {} already; adding it once more counts the same things twice and shows nothing new",
        map_name);
  }
  return apartness(map, map_name, addition);
}

}  // namespace

std::optional<std::string> objectionTo(const map::SemanticMap& addition,
                                       const map::SemanticMap& map, const std::string& map_name,
                                       const Options& options) {
  if (auto repetition = repetitionOf(addition, map, map_name)) return repetition;
  return contradictionOf(addition, map, map_name, options);
}

void logConsistencyChecks(const map::SemanticMap& map, const std::string& map_name,
                          const map::SemanticMap& addition, const Options& options,
                          const Narrative& narrate) {
  if (const auto objection = objectionTo(addition, map, map_name, options))
    narrate.note(nameOf(addition) + " " + *objection);
}

void requireFits(const map::SemanticMap& map, const std::string& map_name,
                 const map::SemanticMap& addition, const Job& job) {
  if (const auto objection = objectionTo(addition, map, map_name, job.options))
    throw Error(nameOf(addition), *objection + (objection->back() == '?' ? " " : "; ") +
                                      "--force adds it all the same");
}

void SketchedRecordings::add(const FrameSource& source, const PreprocessedFrame& frame) {
  constexpr std::size_t kFrames = 60;  // enough of any recording to know it again
  if (last_ && sources_[sketches_.size()] != &source) finishLast();
  if (!last_) {
    Options options = options_;
    options.size = sizeText(frame.size);
    last_ = std::make_unique<PlaceBuilder>(sources_.front()->labels(), options, PlaceUse::map);
  }
  if (frames_++ % (1 + source.size() / kFrames) == 0) last_->add(frame);
}

void SketchedRecordings::finishLast() {
  map::SemanticMap sketch;
  static_cast<Place&>(sketch) = last_->finish();
  sketch.sources = {sources_[sketches_.size()]->name()};
  sketch.source_of_pose.assign(sketch.poses.size(), 0);
  sketches_.push_back(std::move(sketch));
  last_.reset();
  frames_ = 0;
}

void SketchedRecordings::check(bool accept_all, const Narrative& narrate) {
  if (last_) finishLast();
  const auto distance = [&](std::size_t i, std::size_t j) {
    return distanceOf(sketches_[j].poses, sketches_[i].poses);
  };
  std::size_t contradicted = 0;
  for (std::size_t i = 1; i < sketches_.size(); ++i) {
    std::size_t nearest = 0;
    for (std::size_t j = 1; j < i; ++j) {
      if (distance(i, j) < distance(i, nearest)) nearest = j;
    }
    const map::SemanticMap &addition = sketches_[i], &map = sketches_[nearest];
    auto objection = repetitionOf(addition, map, map.sources[0]);
    if (!objection) {
      objection = contradictionOf(addition, map, map.sources[0], options_);
      contradicted += objection.has_value();
    }
    if (objection) narrate.note(nameOf(addition) + " " + *objection);
  }
  if (accept_all || contradicted == 0 || 2 * contradicted < sketches_.size() - 1) return;
  throw Error(sources_[0]->name(),
              fmt::format("{} of the {} recordings after it do not fit those before them, so they "
                          "have no common frame; `xview map --join` finds where each is, --force "
                          "takes them as they are",
                          contradicted, sketches_.size() - 1));
}

}  // namespace xview::tools
