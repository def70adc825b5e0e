// SPDX-License-Identifier: BSD-3-Clause
#include "base/label_match.h"

#include <gtest/gtest.h>

#include "support/label_sets.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {
namespace {

using test::labelSetOf;

const LabelSet kTown = labelSetOf("town", {{0, "unlabelled", Role::ignored, Kind::none},
                                           {1, "road", Role::surface, Kind::road},
                                           {2, "building", Role::surface, Kind::building},
                                           {3, "Vegetation", Role::surface, Kind::vegetation},
                                           {4, "hedge", Role::surface, Kind::vegetation},
                                           {5, "pole", Role::object, Kind::pole},
                                           {6, "trunk", Role::object, Kind::trunk},
                                           {7, "vehicle.car", Role::dynamic, Kind::vehicle},
                                           {8, "traffic-sign", Role::object, Kind::sign},
                                           {9, "chair", Role::object, Kind::other_object},
                                           {10, "static.manmade", Role::surface, Kind::building}});

/// What the only class of a set is in the town; "" = nothing.
std::string partnerOf(const char* name, Role role, Kind kind, MatchedBy* by = nullptr) {
  const LabelMatch match(labelSetOf("other", {{77, name, role, kind}}), kTown);
  const auto partner = match.partners().find(77);
  if (partner == match.partners().end()) return "";
  if (by) *by = partner->second.by;
  EXPECT_EQ(match(77), partner->second.id);
  return kTown.className(partner->second.id);
}

TEST(LabelMatch, FoldsCaseBlanksSignsAndPlurals) {
  MatchedBy by = MatchedBy::kind;
  for (const char* spelling : {"Traffic Sign", "TrafficSigns", "traffic_sign", "TRAFFIC.SIGN"}) {
    EXPECT_EQ(partnerOf(spelling, Role::object, Kind::sign, &by), "traffic-sign") << spelling;
    EXPECT_EQ(by, MatchedBy::name) << spelling;
  }
}

TEST(LabelMatch, TakesDottedNamesByTheirParts) {
  EXPECT_EQ(partnerOf("car", Role::dynamic, Kind::vehicle), "vehicle.car");
  EXPECT_EQ(partnerOf("static.vegetation", Role::surface, Kind::vegetation), "Vegetation");
  EXPECT_EQ(partnerOf("static.other", Role::object, Kind::other_object), "")
      << "what is only 'static' is nothing in common";
}

TEST(LabelMatch, KnowsOtherWordsForTheSame) {
  MatchedBy by = MatchedBy::kind;
  EXPECT_EQ(partnerOf("automobile", Role::dynamic, Kind::vehicle, &by), "vehicle.car");
  EXPECT_EQ(by, MatchedBy::meaning);
  EXPECT_EQ(partnerOf("armchairs", Role::object, Kind::other_object), "chair");
  EXPECT_EQ(partnerOf("street", Role::surface, Kind::road), "road");
}

TEST(LabelMatch, FallsBackToTheKindAndPrefersTheClassCalledAfterIt) {
  MatchedBy by = MatchedBy::name;
  EXPECT_EQ(partnerOf("shrubbery", Role::surface, Kind::vegetation, &by), "Vegetation");
  EXPECT_EQ(by, MatchedBy::kind);
  EXPECT_EQ(partnerOf("mur", Role::surface, Kind::building), "building");
  EXPECT_EQ(partnerOf("parking", Role::surface, Kind::road), "road");
  EXPECT_EQ(partnerOf("zebra", Role::surface, Kind::lane_marking), "road");
}

TEST(LabelMatch, DoesNotTakePolesForTrunksNorTablesForChairs) {
  const LabelSet no_pole = labelSetOf("a", {{1, "trunk", Role::object, Kind::trunk},
                                            {2, "chair", Role::object, Kind::other_object}});
  const LabelMatch match(labelSetOf("b", {{1, "pole", Role::object, Kind::pole},
                                          {2, "table", Role::object, Kind::other_object}}),
                         no_pole);
  EXPECT_TRUE(match.partners().empty());
  EXPECT_EQ(match.alone(), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_TRUE(match.isHopeless());
  EXPECT_EQ(no_pole.role(match(1)), Role::ignored);
  EXPECT_NE(match(1), match(2)) << "what is left out can be told apart";
  EXPECT_EQ(match.nameOfAlone(match(2)), "table");
}

TEST(LabelMatch, GivesIdsNoMeaningBetweenTwoSets) {
  const LabelMatch match(labelSetOf("other", {{1, "building", Role::surface, Kind::building},
                                              {2, "road", Role::surface, Kind::road}}),
                         kTown);
  EXPECT_EQ(match(1), 2u);
  EXPECT_EQ(match(2), 1u);
  EXPECT_FALSE(match.changesNothing());
  EXPECT_EQ(kTown.role(match(5)), Role::ignored) << "an id that the other set does not know";
}

TEST(LabelMatch, LeavesEqualSetsAlone) {
  const LabelMatch match(kTown, kTown);
  EXPECT_TRUE(match.changesNothing());
  EXPECT_FALSE(match.isHopeless());
  for (std::uint32_t id = 0; id < 20; ++id) EXPECT_EQ(match(id), id);
}

TEST(LabelMatch, DoesNotMindHowNothingIsSpelt) {
  LabelSet other = labelSetOf("other", {{0, "unlabeled", Role::ignored, Kind::none},
                                        {1, "road", Role::surface, Kind::road}});
  EXPECT_TRUE(LabelMatch(other, kTown).changesNothing());
  EXPECT_TRUE(LabelMatch(labelSetOf("other", {{3, "void", Role::ignored, Kind::none}}), kTown)
                  .alone()
                  .empty());
}

TEST(LabelMatch, MatchesNamelessSetsByIdAndWithNamedOnesByKind) {
  LabelSet nameless = genericLabelSet({0, 1, 4});
  EXPECT_TRUE(LabelMatch(nameless, genericLabelSet({0, 1, 2, 3, 4})).changesNothing());
  EXPECT_TRUE(LabelMatch(nameless, kTown).isHopeless());
  ClassInfo wall = *nameless.find(1);
  wall.role = Role::surface;
  wall.kind = Kind::building;
  nameless.add(wall);
  const LabelMatch match(nameless, kTown);
  EXPECT_EQ(match(1), 2u);
  EXPECT_FALSE(match.isHopeless());
}

TEST(LabelMatch, AsksTheLinesOfAUserFirst) {
  const LabelSet own = labelSetOf("own", {{1, "Laterne", Role::object, Kind::other_object}});
  EXPECT_TRUE(LabelMatch(own, kTown).isHopeless());
  const ClassNames names = ClassNames::shipped().extendedBy(
      ClassNames::parse("# mine\nobject pole: laterne, pole\n", "mine.txt"));
  EXPECT_EQ(LabelMatch(own, kTown, names)(1), 5u);
  EXPECT_EQ(names.kind("Laternen"), Kind::other_object) << "a plural in another language";
  EXPECT_EQ(names.kind("laterne"), Kind::pole);
}

TEST(ClassNames, RefusesALineThatIsNone) {
  for (const char* line : {"object: pole", "object pole pole", "thing pole: pole",
                           "object pole:", "object pole: a,,b"}) {
    const std::string said =
        test::messageOf<Error>([&] { ClassNames::parse(std::string("\n") + line, "mine.txt"); });
    EXPECT_EQ(said.find("mine.txt:2: expected"), 0u) << line << ": " << said;
  }
}

TEST(TranslatedPlace, KeepsAllVerticesAndPoints) {
  const LabelSet other = labelSetOf("other", {{1, "building", Role::surface, Kind::building},
                                              {2, "table", Role::object, Kind::other_object}});
  Place place;
  place.labels = other;
  place.graph.vertices.resize(2);
  place.graph.vertices[0].label = 1;
  place.graph.vertices[1].label = 2;
  place.graph.setEdges({{0, 1}});
  place.cloud.points.push_back(Point(0, 0, 0, 1));
  const Place same = translated(place, LabelMatch(other, kTown));
  EXPECT_EQ(same.graph.vertices[0].label, 2u);
  EXPECT_EQ(kTown.find(same.graph.vertices[1].label), nullptr);
  EXPECT_EQ(same.graph.edgeCount(), 1u);
  EXPECT_EQ(same.cloud.points[0].label, 2u);
  EXPECT_EQ(same.labels, kTown);
}

}  // namespace
}  // namespace xview
