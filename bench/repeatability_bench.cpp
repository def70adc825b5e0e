// SPDX-License-Identifier: BSD-3-Clause
// How many things of one session another session finds again at the same place, by class and view.
//
//   repeatability_bench MAP_SESSION SESSION... [--window 60] [--stride 20] [--key.subkey VALUE]...
//
// A session is a recording with groundtruth.txt or truth.txt (poses in the frame of the map
// session), with @A:B for a part of it. Each window of a session becomes a query, is put at its
// true pose, and asks the map for the nearest landmark of the same label. Counted is what lies
// within 1 m of something that the map session saw. For each session: number per query, share with
// a partner within 0.5 and 1 m, and in brackets the share within 1 m at wrong poses on the road,
// which is what chance gives. First the samples of the plan view, which the place search uses,
// seen from above; then the vertices of the graph, which walks use, in three dimensions.
//
// A last table has the vertices of posts alone that the map session could see: its depth images
// show them free and within 25 m. The rest, behind houses or under crowns, no map of it can have.
//
//   repeatability_bench SESSION --spacing 10 [--key.subkey VALUE]...
//
// shows the distances between vertices of one class in one graph, up to so many metres.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "repeatability.h"
#include "session.h"
#include "xview/localizer.h"
#include "xview/types/error.h"
#include "xview/types/pose.h"
#include "xview/types/random.h"

namespace {

using namespace xview;
using namespace xview::bench;

constexpr double kRim_m = 1;    ///< around what was seen
constexpr double kReach_m = 3;  ///< partners further away are none
constexpr double kBlock_m = 1;  ///< surface samples of the plan view
constexpr double kElsewhere_m = 25;
constexpr int kWrongPoses = 12;  ///< per window

constexpr double kFarthest_m = 25;  ///< as mapping believes in thin things
constexpr double kNearest_m = 0.5;
constexpr double kBehind_m = 0.5, kBehindShare = 0.05;  ///< depths are no better known

bool seesFreely(const Frame& frame, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = frame.T_odom_sensor.inverse() * p;
  if (q.z() < kNearest_m || q.norm() > kFarthest_m) return false;
  const int u = static_cast<int>(std::lround(frame.camera.fx * q.x() / q.z() + frame.camera.cx));
  const int v = static_cast<int>(std::lround(frame.camera.fy * q.y() / q.z() + frame.camera.cy));
  if (u < 0 || v < 0 || u >= frame.depth.width || v >= frame.depth.height) return false;
  const double measured = frame.depth.at(u, v);
  const double expected = frame.camera.depth_is_range ? q.norm() : q.z();
  return measured <= 0 || measured >= expected - std::max(kBehind_m, kBehindShare * expected);
}

/// What a recording of depth images could see of posts: what stands behind a house, too far off or
/// beside every image cannot be asked of its map.
class MapSight {
 public:
  /// Keeps all depth images. Of other sensors nothing is known: they see everything.
  explicit MapSight(const FrameSource& source);

  /// Whether a frame saw two of three places on a post with its foot at `p` free, near enough for
  /// thin things. Up is z of the frame of the poses.
  bool contains(const Eigen::Vector3d& p) const;

 private:
  std::vector<Frame> frames_;
};

MapSight::MapSight(const FrameSource& source) {
  if (source.sensor() != Sensor::camera) return;
  for (std::size_t i = 0; i < source.size(); ++i) frames_.push_back(source.read(i));
}

bool MapSight::contains(const Eigen::Vector3d& p) const {
  const auto sees = [&](const Frame& frame) {
    int free = 0;
    for (const double height_m : {0.7, 1.3, 1.9})
      free += seesFreely(frame, p + Eigen::Vector3d(0, 0, height_m));
    return free >= 2;
  };
  return frames_.empty() || std::any_of(frames_.begin(), frames_.end(), sees);
}

struct Arguments {
  std::vector<std::string> sessions;
  double window_m = 60, stride_m = 20, spacing_m = 0;
  Options options;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  a.sessions = parseArguments(argc, argv,
                              {{"--window", into(a.window_m)},
                               {"--stride", into(a.stride_m)},
                               {"--spacing", into(a.spacing_m)}},
                              a.options, 1, "repeatability_bench MAP_SESSION SESSION... [options]");
  if (a.sessions.size() < 2 && !(a.spacing_m > 0))
    throw UsageError("usage: repeatability_bench MAP_SESSION SESSION... [options]");
  return a;
}

/// The map session in its upright frame.
struct Reference {
  Eigen::Isometry3d T_plan_map;
  std::vector<Landmark> plan, graph;
  KnownArea known;
  std::vector<Eigen::Vector3d> travel;  ///< positions of its keyframes

  MapSight sight;  ///< in the frame of the map

  Reference(const map::SemanticMap& map, const FrameSource& source)
      : T_plan_map(map.plan.upright),
        plan(flattened(landmarksOf(map.plan, 0))),
        graph(moved(landmarksOf(map.graph), T_plan_map)),
        known(map.plan, kRim_m),
        sight(source) {
    for (const Eigen::Isometry3d& T : map.poses) travel.push_back(T_plan_map * T.translation());
  }
  double headingAt(std::size_t i) const {
    if (travel.size() < 3) return 0;
    const std::size_t at = std::clamp<std::size_t>(i, 1, travel.size() - 2);
    const Eigen::Vector3d d = travel[at + 1] - travel[at - 1];
    return std::atan2(d.y(), d.x());
  }
};

/// Landmarks of one label over all windows of a session.
struct Tally {
  Partners right, wrong;
  void add(Partners& sum, const Partners& more) {
    sum.distances_m.insert(sum.distances_m.end(), more.distances_m.begin(), more.distances_m.end());
    sum.unknown += more.unknown;
  }
};
using Tallies = std::map<std::uint32_t, Tally>;

struct SessionTallies {
  Tallies plan, graph;
  Tallies posts;  ///< of the graph, those in sight of the map session
  int windows = 0;
};

void count(const std::vector<Landmark>& query, const std::vector<Landmark>& reference,
           const KnownArea& known, bool right, Tallies& tallies) {
  for (const auto& [label, partners] : findPartners(query, reference, known, kReach_m)) {
    Tally& t = tallies[label];
    t.add(right ? t.right : t.wrong, partners);
  }
}

/// Those of the posts that the map session could see.
std::vector<Landmark> postsInSight(const std::vector<Landmark>& in_plan, const LabelSet& labels,
                                   const Reference& map) {
  std::vector<Landmark> posts;
  for (const Landmark& l : in_plan) {
    if (isPoleLike(labels.kind(l.label)) &&
        map.sight.contains(map.T_plan_map.inverse() * l.position))
      posts.push_back(l);
  }
  return posts;
}

/// Poses that put the query on another part of the road, along it or against it.
std::vector<Eigen::Isometry3d> wrongPoses(const Reference& map, const Eigen::Isometry3d& T_true,
                                          const Eigen::Vector3d& middle, double heading,
                                          Random& random) {
  std::vector<Eigen::Isometry3d> poses;
  const Eigen::Vector3d there = T_true * middle;
  for (int i = 0; i < kWrongPoses; ++i) {
    const auto at = random.below(static_cast<std::uint32_t>(map.travel.size()));
    if ((map.travel[at] - there).head<2>().norm() < kElsewhere_m) continue;
    const double yaw = map.headingAt(at) - heading + (i % 2 ? M_PI : 0) + random.uniform(-.05, .05);
    Eigen::Isometry3d T = poseFromYaw({0, 0, 0}, yaw) * T_true;
    T.translation() += there - T * middle;
    T.translation().head<2>() += (map.travel[at] - there).head<2>() +
                                 Eigen::Vector2d(random.uniform(-2, 2), random.uniform(-2, 2));
    poses.push_back(T);
  }
  return poses;
}

void addWindow(const Session& s, std::size_t first, std::size_t last, const Reference& map,
               const Options& options, Random& random, SessionTallies& tallies) {
  const Query query = makeQuery(s.frames.data() + first, s.frames.data() + last, s.labels, options);
  const std::size_t middle = std::min((first + last) / 2, s.frames.size() - 1);
  const Eigen::Isometry3d& T_odom_sensor = s.frames[middle].T_odom_sensor;
  const Eigen::Isometry3d T_true =
      map.T_plan_map * s.truth[middle].T_frame_sensor * T_odom_sensor.inverse();
  const Eigen::Isometry3d T_odom_plan(query.plan.upright.conjugate());
  const std::vector<Landmark> samples = moved(landmarksOf(query.plan, kBlock_m), T_odom_plan);
  const std::vector<Landmark> vertices = landmarksOf(query.graph);
  const auto countAt = [&](const Eigen::Isometry3d& T, bool right) {
    count(flattened(moved(samples, T)), map.plan, map.known, right, tallies.plan);
    count(moved(vertices, T), map.graph, map.known, right, tallies.graph);
    count(postsInSight(moved(vertices, T), s.labels, map), map.graph, map.known, right,
          tallies.posts);
  };
  countAt(T_true, true);
  const Eigen::Vector3d travelled =
      T_true.linear() * (s.frames[last - 1].T_odom_sensor.translation() -
                         s.frames[first].T_odom_sensor.translation());
  const double heading = std::atan2(travelled.y(), travelled.x());
  for (const Eigen::Isometry3d& T :
       wrongPoses(map, T_true, T_odom_sensor.translation(), heading, random))
    countAt(T, false);
  ++tallies.windows;
}

SessionTallies runSession(const Session& s, const Reference& map, const Arguments& a) {
  SessionTallies tallies;
  Random random(5);
  for (const auto& [first, last] : windowsOf(s, a.window_m, a.stride_m))
    addWindow(s, first, last, map, a.options, random, tallies);
  return tallies;
}

std::string cell(const Tallies& tallies, std::uint32_t label, int windows) {
  constexpr std::size_t kFew = 3;
  const auto it = tallies.find(label);
  if (it == tallies.end() || it->second.right.distances_m.size() < kFew)
    return fmt::format("{:>23}", "-");
  const Partners &right = it->second.right, &wrong = it->second.wrong;
  const double share = wrong.distances_m.empty() ? 0 : wrong.shareWithin(1);
  return fmt::format("{:6.1f} {:.2f}/{:.2f} ({:.2f})",
                     static_cast<double>(right.distances_m.size()) / windows, right.shareWithin(.5),
                     right.shareWithin(1), share);
}

template <class Name>
void printTable(const std::string& title, const std::vector<std::string>& names,
                const std::vector<SessionTallies>& sessions, Tallies SessionTallies::*part,
                const std::map<std::uint32_t, std::size_t>& in_map, Name&& name) {
  fmt::print("{:<24} {:>6}", title, "map");
  for (const std::string& n : names) fmt::print(" | {:>23}", n);
  fmt::print("\n");
  for (const auto& [label, count] : in_map) {
    fmt::print("{:<24} {:6}", name(label), count);
    for (const SessionTallies& s : sessions) fmt::print(" | {}", cell(s.*part, label, s.windows));
    fmt::print("\n");
  }
}

std::map<std::uint32_t, std::size_t> countLabels(const std::vector<Landmark>& landmarks) {
  std::map<std::uint32_t, std::size_t> counts;
  for (const Landmark& l : landmarks) ++counts[l.label];
  return counts;
}

void printSpacing(const map::SemanticMap& map, double reach_m) {
  fmt::print("{:<24} {:>6} | nearest of its class within 0.5, 1, 2, 4 m\n", "vertex", "count");
  for (const auto& [label, distances] : neighbourDistances(landmarksOf(map.graph), reach_m)) {
    fmt::print("{:<24} {:6} |", map.labels.className(label), distances.size());
    for (const double limit : {.5, 1., 2., 4.}) {
      fmt::print(" {:5}", std::count_if(distances.begin(), distances.end(),
                                        [&](double d) { return d <= limit; }));
    }
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  const auto source = openPart(a.sessions[0]);
  const map::SemanticMap map = buildMap({source.get()}, a.options);
  if (a.spacing_m > 0) {
    printSpacing(map, a.spacing_m);
    return 0;
  }
  const Reference reference(map, *source);
  std::vector<std::string> names;
  std::vector<SessionTallies> tallies;
  for (std::size_t i = 1; i < a.sessions.size(); ++i) {
    const Session s = loadSession(a.sessions[i], a.options);
    names.push_back(s.name);
    tallies.push_back(runSession(s, reference, a));
  }
  printTable("plan sample", names, tallies, &SessionTallies::plan, countLabels(reference.plan),
             [](std::uint32_t c) { return toString(static_cast<Channel>(c)); });
  printTable("graph vertex", names, tallies, &SessionTallies::graph, countLabels(reference.graph),
             [&](std::uint32_t label) { return map.labels.className(label); });
  std::map<std::uint32_t, std::size_t> posts;
  for (const auto& [label, count] : countLabels(reference.graph)) {
    if (isPoleLike(map.labels.kind(label))) posts[label] = count;
  }
  printTable("post in sight of the map", names, tallies, &SessionTallies::posts, posts,
             [&](std::uint32_t label) { return map.labels.className(label); });
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
