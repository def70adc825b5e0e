// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/labels.h"

#include <gtest/gtest.h>

namespace xview {
namespace {

struct Guess {
  const char* name;
  Role role;
  Kind kind;
};

class GuessFromName : public ::testing::TestWithParam<Guess> {};

TEST_P(GuessFromName, KnowsTheNamesOfTheUsualDataSets) {
  EXPECT_EQ(toString(ClassNames::shipped().role(GetParam().name)),
            std::string(toString(GetParam().role)));
  EXPECT_EQ(toString(ClassNames::shipped().kind(GetParam().name)),
            std::string(toString(GetParam().kind)));
}

INSTANTIATE_TEST_SUITE_P(
    Names, GuessFromName,
    ::testing::Values(
        Guess{"void", Role::ignored, Kind::none}, Guess{"Sky", Role::ignored, Kind::none},
        Guess{"unlabeled", Role::ignored, Kind::none},
        Guess{"ego vehicle", Role::ignored, Kind::none}, Guess{"none", Role::ignored, Kind::none},
        Guess{"scanning artefacts", Role::ignored, Kind::none},
        Guess{"car", Role::dynamic, Kind::vehicle}, Guess{"cars", Role::dynamic, Kind::vehicle},
        Guess{"vehicle.bus.bendy", Role::dynamic, Kind::vehicle},
        Guess{"Vehicles", Role::dynamic, Kind::vehicle},
        Guess{"moving-car", Role::dynamic, Kind::none},
        Guess{"human.pedestrian.adult", Role::dynamic, Kind::none},
        Guess{"bicyclist", Role::dynamic, Kind::none},
        Guess{"two-wheeler", Role::dynamic, Kind::none}, Guess{"road", Role::surface, Kind::road},
        Guess{"Roads", Role::surface, Kind::road},
        Guess{"flat.driveable_surface", Role::surface, Kind::road},
        Guess{"SideWalks", Role::surface, Kind::sidewalk},
        Guess{"pavement", Role::surface, Kind::sidewalk},
        Guess{"lanemarking", Role::surface, Kind::lane_marking},
        Guess{"RoadLines", Role::surface, Kind::lane_marking},
        Guess{"bike lane", Role::surface, Kind::road},
        Guess{"natural terrain", Role::surface, Kind::terrain},
        Guess{"grass", Role::surface, Kind::terrain},
        Guess{"building", Role::surface, Kind::building},
        Guess{"Buildings", Role::surface, Kind::building},
        Guess{"static.manmade", Role::surface, Kind::building},
        Guess{"wall", Role::surface, Kind::building}, Guess{"fence", Role::surface, Kind::fence},
        Guess{"GuardRail", Role::surface, Kind::fence},
        Guess{"Hedge", Role::surface, Kind::vegetation},
        Guess{"vegetation", Role::surface, Kind::vegetation},
        Guess{"tree", Role::object, Kind::vegetation}, Guess{"trunk", Role::object, Kind::trunk},
        Guess{"pole", Role::object, Kind::pole}, Guess{"power_pole", Role::object, Kind::pole},
        Guess{"Utility Pole", Role::object, Kind::pole},
        Guess{"polegroup", Role::object, Kind::pole}, Guess{"bollard", Role::object, Kind::pole},
        Guess{"traffic sign", Role::object, Kind::sign},
        Guess{"TrafficSign", Role::object, Kind::sign},
        Guess{"stop_sign", Role::object, Kind::sign}, Guess{"give_way", Role::object, Kind::sign},
        Guess{"street_lamp", Role::object, Kind::light},
        Guess{"traffic_signals", Role::object, Kind::light},
        Guess{"traffic light", Role::object, Kind::light},
        Guess{"bicycle_parking", Role::object, Kind::other_object},
        Guess{"post_box", Role::object, Kind::other_object},
        Guess{"static_object.bicycle_rack", Role::object, Kind::other_object},
        Guess{"bus_stop", Role::object, Kind::other_object},
        Guess{"fire_hydrant", Role::object, Kind::other_object},
        Guess{"something never heard of", Role::object, Kind::other_object},
        Guess{"", Role::object, Kind::other_object}, Guess{"s", Role::object, Kind::other_object},
        Guess{"\xC3\xA9glise", Role::object, Kind::other_object}));

ClassInfo classOf(std::uint32_t id, const std::string& name, Role role, Kind kind) {
  ClassInfo info;
  info.id = id;
  info.name = name;
  info.role = role;
  info.kind = kind;
  return info;
}

TEST(LabelSet, GivesUnknownIdsNoRole) {
  LabelSet set("town");
  set.add(classOf(7, "pole", Role::object, Kind::pole));
  EXPECT_EQ(set.role(7), Role::object);
  EXPECT_EQ(set.role(8), Role::ignored);
  EXPECT_EQ(set.kind(8), Kind::none);
  EXPECT_EQ(set.className(8), "class 8");
  EXPECT_EQ(set.find(8), nullptr);
}

TEST(LabelSet, HidesTheKindOfIgnoredClasses) {
  LabelSet set;
  set.add(classOf(1, "old pole", Role::ignored, Kind::pole));
  EXPECT_EQ(set.kind(1), Kind::none);
}

TEST(LabelSet, ReplacesTheClassWithTheSameId) {
  LabelSet set;
  set.add(classOf(1, "pole", Role::object, Kind::pole));
  set.add(classOf(1, "road", Role::surface, Kind::road));
  EXPECT_EQ(set.classes().size(), 1u);
  EXPECT_EQ(set.className(1), "road");
}

TEST(LabelSet, IsEqualIfIdsNamesAndRolesAreWhateverTheColours) {
  LabelSet a("a"), b("b");
  ClassInfo pole = classOf(1, "pole", Role::object, Kind::pole);
  a.add(pole);
  pole.color = {1, 2, 3};
  b.add(pole);
  EXPECT_EQ(a, b);
  pole.role = Role::ignored;
  b.add(pole);
  EXPECT_NE(a, b);
  EXPECT_NE(a, LabelSet());
}

TEST(GenericLabelSet, MakesEveryIdButZeroAnObject) {
  const LabelSet set = genericLabelSet({0, 3, 80});
  EXPECT_EQ(set.classes().size(), 3u);
  EXPECT_EQ(set.role(0), Role::ignored);
  EXPECT_EQ(set.role(80), Role::object);
  EXPECT_EQ(set.className(80), "class 80");
  EXPECT_TRUE(set.find(80)->guessed);
}

TEST(DistinctColor, DiffersBetweenNeighbours) {
  for (std::uint32_t id = 0; id < 100; ++id) {
    const auto a = distinctColor(id), b = distinctColor(id + 1);
    int difference = 0;
    for (int c = 0; c < 3; ++c) difference += std::abs(int{a[c]} - int{b[c]});
    EXPECT_GT(difference, 60) << id;
  }
}

TEST(LabelSets, UnknownClassesTakeTheRolesThatTheirNamesHaveElsewhere) {
  const auto classOf = [](std::uint32_t id, const char* name, Role role, Kind kind, bool unknown) {
    ClassInfo info;
    info.id = id;
    info.name = name;
    info.role = role;
    info.kind = kind;
    info.unknown = unknown;
    return info;
  };
  LabelSet map("map"), own("own");
  map.add(classOf(1, "Zorbs", Role::surface, Kind::road, false));
  map.add(classOf(2, "glim", Role::surface, Kind::building, false));
  own.add(classOf(7, "zorb", Role::object, Kind::other_object, true));
  own.add(classOf(8, "glim", Role::object, Kind::other_object, false));
  own.add(classOf(9, "frab", Role::object, Kind::other_object, true));
  const LabelSet told = withRolesOf(map, own);
  EXPECT_EQ(told.kind(7), Kind::road);
  EXPECT_EQ(told.role(7), Role::surface);
  EXPECT_FALSE(told.find(7)->unknown);
  EXPECT_EQ(told.kind(8), Kind::other_object) << "its role was given";
  EXPECT_TRUE(told.find(9)->unknown);
  EXPECT_TRUE(hasUnknown(told));
  EXPECT_FALSE(hasUnknown(withRolesOf(own, map)));
}

}  // namespace
}  // namespace xview
