// SPDX-License-Identifier: BSD-3-Clause
#include "compare/changes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "sim/recordings.h"
#include "support/label_sets.h"
#include "xview/base/frame.h"
#include "xview/mapper.h"

namespace xview {
namespace {

/// Two visits of a town in one frame, with or without changes between them.
struct Visits {
  std::vector<ObjectChange> truth;
  std::map<std::string, map::SemanticMap> maps;  ///< by session, all in the frame of `forward`
};

Visits makeVisits(const SimulationOptions& simulation, const Options& options) {
  Visits visits;
  for (const auto& session : makeSessions(simulation, &visits.truth)) {
    std::vector<Eigen::Isometry3d> truth;
    for (std::size_t i = 0; i < session->size(); ++i) truth.push_back(session->truth(i));
    const PosedRecording in_map(*session, 0, truth);
    visits.maps[session->name()] = buildMap({&in_map}, options);
  }
  return visits;
}

SimulationOptions simulationOf(double changed) {
  SimulationOptions simulation;
  simulation.seed = 11;
  simulation.width = 240;
  simulation.height = 180;
  simulation.sim.changed = changed;
  simulation.sessions.aerial = false;
  simulation.sessions.forward2 = true;
  return simulation;
}

Visits visitsOfTown(double changed) {
  SimulationOptions simulation = simulationOf(changed);
  simulation.route_length_m = 240;
  return makeVisits(simulation, {});
}

const Visits& changedTown() {
  static const Visits visits = visitsOfTown(0.3);
  return visits;
}

Visits visitsOfOffice(const std::string& quality, double route_length_m) {
  SimulationOptions simulation = simulationOf(0.3);
  simulation.sim.style = "office";
  simulation.quality = quality;
  simulation.route_length_m = route_length_m;
  simulation.frame_spacing_m = 0.4;
  Options options;
  options.size = "room";
  return makeVisits(simulation, options);
}

Changes between(const Visits& visits, const std::string& earlier, const std::string& later) {
  return findChanges(visits.maps.at(earlier), visits.maps.at(later), Eigen::Isometry3d::Identity(),
                     0.02);
}

bool isAt(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).head<2>().norm() < 0.7;
}

/// Something of that class went from there, or came there.
bool isTrue(const Visits& visits, const std::string& class_name, const Eigen::Vector3d& p,
            bool is_gone) {
  using What = ObjectChange::What;
  return std::any_of(visits.truth.begin(), visits.truth.end(), [&](const ObjectChange& c) {
    const bool fits = c.what == What::moved || c.what == (is_gone ? What::gone : What::added);
    const Eigen::Vector3d& at = c.what == What::moved && !is_gone ? c.later : c.foot;
    return fits && c.class_name == class_name && isAt(p, at);
  });
}

struct Score {
  int reported = 0, right = 0;
};

Score scoreOf(const Visits& visits, const Changes& changes) {
  Score score;
  for (const Change& c : changes.changes) {
    if (c.is_dynamic) continue;
    const std::string name = visits.maps.at("forward").labels.className(c.label);
    const bool came = c.what == Change::What::added;
    ++score.reported;
    score.right += isTrue(visits, name, c.position, !came) &&
                   (!c.moved_to || isTrue(visits, name, *c.moved_to, false));
  }
  return score;
}

/// Vertices of both visits that are among the truth: what could be reported at best.
int couldBeReported(const Visits& visits, const std::string& later) {
  int count = 0;
  for (const std::string& visit : {std::string("forward"), later}) {
    const map::SemanticMap& map = visits.maps.at(visit);
    for (const Vertex& v : map.graph.vertices)
      count += map.labels.role(v.label) == Role::object &&
               isTrue(visits, map.labels.className(v.label), v.position, visit == "forward");
  }
  return count;
}

TEST(Changes, OfThingsThatWentAndCameAreFoundAndNothingElse) {
  const Changes changes = between(changedTown(), "forward", "forward2");
  const Score score = scoreOf(changedTown(), changes);
  EXPECT_GE(score.right, 6);
  EXPECT_GE(score.right, 0.9 * score.reported);
  EXPECT_GE(2 * score.right, couldBeReported(changedTown(), "forward2"));
  EXPECT_GT(changes.compared, 15U);
}

TEST(Changes, AreFoundFromTheOtherSide) {
  const Score score = scoreOf(changedTown(), between(changedTown(), "forward", "rear"));
  EXPECT_GE(score.right, 5);
  EXPECT_GE(score.right + 1, score.reported);  // a sign has its class from the front only
}

TEST(Changes, OfRoomsAreOnWallsAndDesksAsWell) {
  const Visits visits = visitsOfOffice("clean", 40);
  const Changes changes = between(visits, "forward", "forward2");
  const Score score = scoreOf(visits, changes);
  EXPECT_GE(score.right, 8);
  EXPECT_GE(score.right, 0.85 * score.reported);
  std::set<std::string> classes;
  for (const Change& c : changes.changes)
    classes.insert(visits.maps.at("forward").labels.className(c.label));
  EXPECT_TRUE(classes.count("picture") + classes.count("window") + classes.count("whiteboard"))
      << "what is replaced by the wall behind it";
  EXPECT_TRUE(classes.count("monitor")) << "what stands on something";
}

/// In noisy labels a thing has parts of many classes.
TEST(Changes, AreToldOncePerThing) {
  const Visits visits = visitsOfOffice("labels", 25);
  const map::SemanticMap& earlier = visits.maps.at("forward");
  const Changes changes = between(visits, "forward", "forward2");
  const auto gone = std::count(changes.presence.begin(), changes.presence.end(), Presence::gone);
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Change& c : changes.changes) {
    const Kind kind = earlier.labels.kind(c.label);
    if (c.what == Change::What::added || isPoleLike(kind) || kind == Kind::trunk) continue;
    const Eigen::Vector3d half = c.extent / 2;
    boxes.emplace_back(c.position - half, c.position + half);
  }
  ASSERT_GT(boxes.size(), 2u);
  EXPECT_LT(boxes.size(), 0.8 * static_cast<double>(gone));
}

TEST(Changes, TurnRoundWithTheVisits) {
  const auto countOf = [](const Changes& changes, Change::What what) {
    return std::count_if(changes.changes.begin(), changes.changes.end(),
                         [&](const Change& c) { return c.what == what && !c.is_dynamic; });
  };
  const Changes there = between(changedTown(), "forward", "forward2");
  const Changes back = between(changedTown(), "forward2", "forward");
  EXPECT_EQ(countOf(there, Change::What::gone), countOf(back, Change::What::added));
  EXPECT_EQ(countOf(there, Change::What::added), countOf(back, Change::What::gone));
  EXPECT_EQ(countOf(there, Change::What::moved), countOf(back, Change::What::moved));
}

TEST(Changes, AreNoneWhereNothingChangedButTraffic) {
  const Visits visits = visitsOfTown(0);
  for (const std::string later : {"forward2", "rear"}) {
    const Changes changes = between(visits, "forward", later);
    EXPECT_GT(changes.compared, 15U);
    EXPECT_LE(std::count_if(changes.changes.begin(), changes.changes.end(),
                            [](const Change& c) { return !c.is_dynamic; }),
              later == "rear" ? 2 : 0);
    EXPECT_GT(std::count_if(changes.changes.begin(), changes.changes.end(),
                            [](const Change& c) { return c.is_dynamic; }),
              5);
  }
}

/// Poles that stand alone, every second one of them.
std::vector<Eigen::Vector3d> someLonelyPoles(const map::SemanticMap& map) {
  std::vector<Eigen::Vector3d> poles, some;
  for (const Vertex& v : map.graph.vertices)
    if (map.labels.kind(v.label) == Kind::pole) poles.push_back(v.position);
  for (const Eigen::Vector3d& p : poles) {
    const auto near = std::count_if(poles.begin(), poles.end(), [&](const Eigen::Vector3d& other) {
      return (other - p).head<2>().norm() < 8;
    });
    if (near == 1) some.push_back(p);
  }
  for (std::size_t i = 0; 2 * i < some.size(); ++i) some[i] = some[2 * i];
  some.resize((some.size() + 1) / 2);
  return some;
}

TEST(Changes, OfAThingThatStandsAFewMetresAsideAreOneMove) {
  const map::SemanticMap& earlier = changedTown().maps.at("forward");
  map::SemanticMap later = earlier;
  const std::vector<Eigen::Vector3d> poles = someLonelyPoles(earlier);
  const Eigen::Vector3d way(1.2, -0.9, 0);
  const auto isMoved = [&](std::uint32_t label, const Eigen::Vector3d& p) {
    return isPoleLike(earlier.labels.kind(label)) &&
           std::any_of(poles.begin(), poles.end(), [&](const Eigen::Vector3d& pole) {
             return (p - pole).head<2>().norm() < 3;
           });
  };
  for (Vertex& v : later.graph.vertices)
    if (isMoved(v.label, v.position)) v.position += way;
  for (std::size_t i = 0; i < later.cloud.size(); ++i) {
    if (isMoved(later.cloud.points[i].label, later.cloud.position(i)))
      later.cloud.points[i].getVector3fMap() += way.cast<float>();
  }
  const Changes changes = findChanges(earlier, later, Eigen::Isometry3d::Identity(), 0.02);
  std::size_t moves = 0;
  for (const Change& c : changes.changes) {
    EXPECT_GT(c.probability, 0.5);
    if (c.what != Change::What::moved) continue;  // one of its places was not looked at
    ++moves;
    ASSERT_TRUE(c.moved_to);
    EXPECT_LT((*c.moved_to - c.position - way).norm(), 0.01);
  }
  EXPECT_GE(moves, 2u);
  EXPECT_GE(2 * moves, changes.changes.size());
}

TEST(Changes, WhatIsGoneCanBeTakenOutOfTheEarlierVisit) {
  const auto areGone = [](const map::SemanticMap& map) {
    const Changes changes =
        findChanges(map, changedTown().maps.at("forward2"), Eigen::Isometry3d::Identity(), 0.02);
    std::vector<std::size_t> gone;
    for (std::size_t i = 0; i < map.graph.size(); ++i)
      if (changes.presence.at(i) == Presence::gone) gone.push_back(i);
    EXPECT_GE(gone.size(),  // parts of a thing are one change
              std::count_if(changes.changes.begin(), changes.changes.end(),
                            [](const Change& c) { return c.what != Change::What::added; }));
    return gone;
  };
  map::SemanticMap map = changedTown().maps.at("forward");
  const map::SemanticMap before = map;
  const std::vector<std::size_t> gone = areGone(map);
  ASSERT_GT(gone.size(), 5u);
  removeObjects(map, gone);
  EXPECT_TRUE(isConsistent(map.graph));
  EXPECT_EQ(map.graph.size(), before.graph.size() - gone.size());
  EXPECT_LT(map.cloud.size(), before.cloud.size());
  EXPECT_GT(map.cloud.size(), before.cloud.size() * 9 / 10);
  EXPECT_LE(map.bev.sampleCount() + gone.size(), before.bev.sampleCount());
  EXPECT_EQ(map.bev[BevChannel::road].size(), before.bev[BevChannel::road].size());
  EXPECT_LT(areGone(map).size(), 2u);
  const map::SemanticMap once = map;
  removeObjects(map, {});
  EXPECT_EQ(map.cloud.size(), once.cloud.size());
  EXPECT_EQ(map.bev.sampleCount(), once.bev.sampleCount());
}

Place movedBy(const Eigen::Vector3d& way, Place place) {
  place.cloud.origin += way;
  place.bev.origin_x += way.x();
  place.bev.origin_y += way.y();
  place.bev.origin_z += way.z();
  for (Vertex& v : place.graph.vertices) v.position += way;
  for (Eigen::Isometry3d& pose : place.poses) pose.pretranslate(way);
  return place;
}

TEST(Changes, AreTheSameInWhateverFrameTheLaterVisitIs) {
  const map::SemanticMap& earlier = changedTown().maps.at("forward");
  const Place& later = changedTown().maps.at("forward2");
  const Eigen::Isometry3d T_new_old(Eigen::Translation3d(300, -70, 4));
  const Place moved = movedBy(T_new_old.translation(), later);
  const Changes here = findChanges(earlier, later, Eigen::Isometry3d::Identity(), 0.02);
  const Changes there = findChanges(earlier, moved, T_new_old.inverse(), 0.02);
  ASSERT_EQ(here.changes.size(), there.changes.size());
  EXPECT_EQ(here.compared, there.compared);
  for (std::size_t i = 0; i < here.changes.size(); ++i)
    EXPECT_LT((here.changes[i].position - there.changes[i].position).norm(), 1e-6);
}

enum Class : std::uint32_t { kFloor = 1, kWall, kCabinet, kBoard };

/// A wall 10 m ahead of the only pose, and what stands before it, seen from there. All on a floor.
Place wallWith(bool cabinet, bool screen, std::uint32_t cabinet_label = kCabinet) {
  Place place;
  place.labels = test::labelSetOf("rooms", {{kFloor, "floor", Role::surface, Kind::road},
                                            {kWall, "wall", Role::surface, Kind::building},
                                            {kCabinet, "cabinet", Role::object, Kind::other_object},
                                            {kBoard, "board", Role::object, Kind::other_object}});
  place.poses.emplace_back(Eigen::Translation3d(0, 0, 1));
  place.bev.known.push_back({0, 0, 0, false});
  const auto add = [&](float x, float y, float z, std::uint32_t label) {
    const bool is_hidden = screen && x > 5 && std::abs(y / x) < 0.07f;
    if (!is_hidden) place.cloud.points.emplace_back(x, y, z, label);
  };
  for (float y = -5; y <= 5; y += 0.1f) {
    for (float z = 0.05f; z <= 3; z += 0.1f) add(10, y, z, kWall);
    for (float x = 2; x < 10; x += 0.1f) add(x, y, 0, kFloor);
  }
  if (screen) {
    for (float y = -0.35f; y <= 0.35f; y += 0.05f)
      for (float z = 0.4f; z <= 1.6f; z += 0.05f) add(5, y, z, kWall);
  }
  if (!cabinet) return place;
  for (float y = -0.5f; y <= 0.5f; y += 0.1f)
    for (float z = 0.4f; z <= 1.1f; z += 0.1f) add(8.5f, y, z, cabinet_label);
  if (cabinet_label != kCabinet) return place;
  Vertex v;
  v.label = kCabinet;
  v.position = {8.5, 0, 0.75};
  v.extent = {0.1, 1, 0.7};
  place.graph.vertices.push_back(v);
  return place;
}

Presence presenceOfCabinet(const Place& later) {
  const Changes changes =
      findChanges(wallWith(true, false), later, Eigen::Isometry3d::Identity(), 0.02);
  return changes.presence.at(0);
}

TEST(Changes, AreSeenThroughOrOfAnotherClass) {
  EXPECT_EQ(presenceOfCabinet(wallWith(true, false)), Presence::stands);
  EXPECT_EQ(presenceOfCabinet(wallWith(false, false)), Presence::gone);
  EXPECT_EQ(presenceOfCabinet(wallWith(true, false, kWall)), Presence::gone);
}

/// Check fix for: classes without a kind were one thing, so that no window could follow a picture.
TEST(Changes, AreOfAnotherClassAlsoWhereNeitherHasAKind) {
  EXPECT_EQ(presenceOfCabinet(wallWith(true, false, kBoard)), Presence::gone);
}

Place ofShapes(Place place) {
  LabelSet shapes(kShapes);
  for (const auto& [id, info] : place.labels.classes()) shapes.add(info);
  place.labels = shapes;
  return place;
}

/// Check fix for: what another side shows as another shape was told as gone.
TEST(Changes, AreNoneWhereShapesDiffer) {
  const auto presence = [](const Place& later) {
    return findChanges(ofShapes(wallWith(true, false)), ofShapes(later),
                       Eigen::Isometry3d::Identity(), 0.02)
        .presence.at(0);
  };
  EXPECT_EQ(presence(wallWith(true, false, kBoard)), Presence::stands);
  EXPECT_EQ(presence(wallWith(false, false)), Presence::gone);
}

/// Check fix for: shapes call a box a wall, and surfaces are not compared.
TEST(Changes, OfShapesAreAlsoOfWhatNoVertexStandsFor) {
  const Place empty = wallWith(false, false), boxed = wallWith(true, false, kWall);
  const auto changes = [](const Place& earlier, const Place& later) {
    return findChanges(earlier, later, Eigen::Isometry3d::Identity(), 0.02);
  };
  EXPECT_TRUE(changes(empty, boxed).changes.empty()) << "a wall with a label is one";
  for (const bool is_new : {true, false}) {
    const Changes found = is_new ? changes(ofShapes(empty), ofShapes(boxed))
                                 : changes(ofShapes(boxed), ofShapes(empty));
    ASSERT_EQ(found.changes.size(), 1u);
    EXPECT_EQ(found.changes[0].what, is_new ? Change::What::added : Change::What::gone);
    EXPECT_EQ(found.changes[0].label, kWall);
    EXPECT_LT((found.changes[0].position - Eigen::Vector3d(8.5, 0, 0.75)).norm(), 0.1);
    EXPECT_LT((found.changes[0].extent - Eigen::Vector3d(0, 1, 0.7)).norm(), 0.25);
    EXPECT_EQ(found.presence.size(), (is_new ? empty : boxed).graph.size());
  }
  const Changes hidden = changes(ofShapes(wallWith(false, true)), ofShapes(boxed));
  ASSERT_EQ(hidden.changes.size(), 1u) << "nobody looked behind the screen";
  EXPECT_EQ(hidden.changes[0].what, Change::What::gone);
  EXPECT_LT(hidden.changes[0].position.x(), 6);
}

/// Check fix for: labels that a few frames gave to a part of something were told as gone.
TEST(Changes, AreNotToldOfWhatItsOwnVisitSawRarely) {
  Place earlier = wallWith(true, false);
  Vertex wall;
  wall.label = kWall;
  wall.position = {10, 0, 1.5};
  wall.observations = 20;
  earlier.graph.vertices.push_back(wall);
  const auto toldIfSeen = [&](std::uint32_t times) {
    earlier.graph.vertices.front().observations = times;
    const Changes changes =
        findChanges(earlier, wallWith(false, false), Eigen::Isometry3d::Identity(), 0.02);
    EXPECT_EQ(changes.presence.front(), Presence::gone);
    return changes.changes.size();
  };
  EXPECT_EQ(toldIfSeen(5), 0U);
  EXPECT_EQ(toldIfSeen(7), 1U);
}

/// Part of the cabinet was measured half a metre before it, and a few times as a board.
TEST(Changes, AreNoneOfAPartThatIsWhatItsLabelsSayByNoise) {
  Place earlier = wallWith(true, false);
  for (float y = -0.2f; y <= 0.2f; y += 0.1f) {
    earlier.cloud.points.emplace_back(8.4f, y, 0.7f, kBoard);
    for (float z = 0.6f; z <= 0.9f; z += 0.1f)
      earlier.cloud.points.emplace_back(7.95f, y, z, kBoard);
  }
  Vertex board = earlier.graph.vertices.front();
  board.label = kBoard;
  board.position.x() = 8.2;
  board.extent = {0.6, 0.4, 0.3};
  earlier.graph.vertices.push_back(board);
  const auto changesIfMeasured = [&](std::uint32_t times) {
    earlier.graph.vertices.front().points = 500;
    earlier.graph.vertices.back().points = times;
    return findChanges(earlier, wallWith(true, false), Eigen::Isometry3d::Identity(), 0.02).changes;
  };
  EXPECT_TRUE(changesIfMeasured(5).empty());
  EXPECT_EQ(changesIfMeasured(500).size(), 1U);

  earlier.graph.vertices.back().points = 5;
  const Eigen::Isometry3d T(Eigen::Translation3d(300, -70, 4));
  const Place later = movedBy(T.translation(), earlier);
  EXPECT_TRUE(findChanges(wallWith(true, false), later, T.inverse(), 0.02).changes.empty());
}

TEST(Changes, AreNotSpokenOfWhatIsHidden) {
  EXPECT_EQ(presenceOfCabinet(wallWith(false, true)), Presence::unknown);
}

/// All of the later visit lies as far below as its trajectory is wrong.
TEST(Changes, AreNotSpokenOfWhereNothingAroundIsMet) {
  Place aside = wallWith(false, false);
  for (Point& p : aside.cloud.points) p.z -= 1;
  EXPECT_EQ(presenceOfCabinet(aside), Presence::unknown);
}

/// Its floor, but for that on one side of the cabinet, lies as far below as that.
TEST(Changes, AreNotSpokenOfWhereHalfOfWhatIsAroundIsNotMet) {
  Place sunken = wallWith(false, false);
  for (Point& p : sunken.cloud.points) {
    if (p.label == kFloor && p.y > -0.3f) p.z -= 1;
  }
  EXPECT_EQ(presenceOfCabinet(sunken), Presence::unknown);
}

/// What is left of it, without a vertex, lies within reach of all but its top rows.
TEST(Changes, AreNoneOfAThingOfWhichMostIsMet) {
  Place lower = wallWith(true, false);
  lower.graph = {};
  auto& points = lower.cloud.points;
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const Point& p) { return p.label == kCabinet && p.z > 0.55f; }),
               points.end());
  EXPECT_EQ(presenceOfCabinet(lower), Presence::stands);
}

TEST(Changes, AreNotSpokenOfWhereAVisitDoesNotTellWhereItLooked) {
  map::SemanticMap bare = changedTown().maps.at("forward2");
  bare.cloud = {};
  const Changes changes =
      findChanges(changedTown().maps.at("forward"), bare, Eigen::Isometry3d::Identity(), 0.02);
  EXPECT_FALSE(changes.has_looked);
  EXPECT_TRUE(std::none_of(changes.changes.begin(), changes.changes.end(),
                           [](const Change& c) { return c.what == Change::What::added; }));
}

}  // namespace
}  // namespace xview
