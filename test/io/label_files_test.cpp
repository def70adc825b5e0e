// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/label_files.h"

#include <gtest/gtest.h>

#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

using test::messageOf;

class LabelFiles : public ::testing::Test {
 protected:
  LabelSet read(const std::string& text) const {
    test::writeText(folder_ / "classes.yaml", text);
    return readLabelSet(folder_ / "classes.yaml");
  }
  std::string messageFor(const std::string& text) const {
    return messageOf([&] { read(text); });
  }
  std::string at(int line) const { return (folder_ / "classes.yaml") + ":" + std::to_string(line); }

  test::TemporaryFolder folder_;
};

TEST_F(LabelFiles, AListOrAMapOfClassesIsRead) {
  const std::string list = "- {id: 7, name: pole, color: [1, 2, 3], role: object}\n";
  for (const std::string& text : {list, "classes:\n" + list, "name: town\nclasses:\n" + list}) {
    const LabelSet set = read(text);
    ASSERT_NE(set.find(7), nullptr) << text;
    EXPECT_EQ(set.className(7), "pole");
    EXPECT_EQ(set.color(7), (std::array<std::uint8_t, 3>{1, 2, 3}));
    EXPECT_EQ(set.role(7), Role::object);
    EXPECT_FALSE(set.find(7)->guessed);
  }
  EXPECT_EQ(read("name: town\nclasses:\n" + list).name(), "town");
}

TEST_F(LabelFiles, AMissingRoleIsGuessedAndSaidSo) {
  const LabelSet set = read("- {id: 1, name: traffic sign}\n- {id: 2, name: car}\n");
  EXPECT_EQ(set.role(1), Role::object);
  EXPECT_EQ(set.kind(1), Kind::sign);
  EXPECT_EQ(set.role(2), Role::dynamic);
  EXPECT_TRUE(set.find(1)->guessed);
}

TEST_F(LabelFiles, ANameThatSaysNothingIsUnknownUnlessTheFileSaysMore) {
  const LabelSet set = read(
      "- {id: 1, name: zorb}\n"
      "- {id: 2, name: zorbs, role: surface}\n"
      "- {id: 3, name: blip, kind: road}\n"
      "- {id: 4, name: frab, static: true}\n"
      "- {id: 5, name: street furniture}\n");
  EXPECT_TRUE(set.find(1)->unknown);
  for (const std::uint32_t id : {2, 3, 4, 5}) EXPECT_FALSE(set.find(id)->unknown) << id;
}

TEST_F(LabelFiles, WhatIsNotStaticIsDynamicUnlessItIsNothing) {
  const LabelSet set = read(
      "- {id: 0, name: void, static: false}\n"
      "- {id: 1, name: sky, static: false}\n"
      "- {id: 2, name: bench, static: false}\n"
      "- {id: 3, name: car, static: true}\n"
      "- {id: 4, name: road, static: true}\n");
  EXPECT_EQ(set.role(0), Role::ignored);
  EXPECT_EQ(set.role(1), Role::ignored);
  EXPECT_EQ(set.role(2), Role::dynamic);
  EXPECT_EQ(set.role(3), Role::object);
  EXPECT_EQ(set.role(4), Role::surface);
}

TEST_F(LabelFiles, TheKindFitsTheRole) {
  const LabelSet set = read(
      "- {id: 1, name: sky, role: object}\n"
      "- {id: 2, name: kiosk, role: surface}\n"
      "- {id: 3, name: fence, role: dynamic}\n"
      "- {id: 4, name: pole, role: ignored}\n"
      "- {id: 5, name: thing, role: object, kind: light}\n");
  EXPECT_EQ(set.kind(1), Kind::other_object);
  EXPECT_EQ(set.kind(2), Kind::other_surface);
  EXPECT_EQ(set.kind(3), Kind::none);
  EXPECT_EQ(set.kind(4), Kind::none);
  EXPECT_EQ(set.kind(5), Kind::light);
}

TEST_F(LabelFiles, WhatIsWrongIsNamedWithItsLine) {
  EXPECT_EQ(messageFor("- {id: 1, name: a}\n- {id: 1, name: b}\n"), at(2) + ": id 1 a second time");
  EXPECT_EQ(messageFor("- {id: 1}\n"), at(1) + ": a class needs id and name");
  EXPECT_EQ(messageFor("- {id: -1, name: a}\n"),
            at(1) + ": id: expected a whole number in [0, 4294967295], found '-1'");
  EXPECT_EQ(messageFor("\n- {id: 1, name: a, colour: [1, 2, 3]}\n"),
            at(2) + ": unknown key 'colour'; the nearest known one is color");
  EXPECT_EQ(messageFor("- {id: 1, name: a, color: [1, 2]}\n"),
            at(1) + ": color: expected [red, green, blue]");
  EXPECT_EQ(messageFor("- {id: 1, name: a, color: [1, 2, 256]}\n"),
            at(1) + ": color: expected a whole number in [0, 255], found '256'");
  EXPECT_EQ(messageFor("- {id: 1, name: a, role: thing}\n"),
            at(1) + ": role: expected one of object, surface, dynamic, ignored, found 'thing'");
  EXPECT_EQ(messageFor("- {id: 1, name: a, static: perhaps}\n"),
            at(1) + ": static: expected true or false, found 'perhaps'");
  EXPECT_EQ(messageFor("- pole\n"), at(1) + ": expected `key: value` lines");
  EXPECT_NE(messageFor("[]\n"), "");
  EXPECT_NE(messageFor(""), "");
  EXPECT_NE(messageFor("classes: 3\n"), "");
  EXPECT_NE(messageFor("7\n"), "");
}

TEST(ShippedLabelSets, AllAreCompleteAndNamedAsTheirFile) {
  const auto names = shippedLabelSets();
  for (const char* name :
       {"synthia", "semantic_kitti", "semantic_kitti_train_1", "semantic_kitti_train_0",
        "cityscapes", "kitti360", "carla", "carla_0_9_14", "nuscenes", "las"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
  for (const std::string& name : names) {
    const LabelSet set = shippedLabelSet(name);
    EXPECT_EQ(set.name(), name);
    EXPECT_GE(set.classes().size(), name == "shapes" ? 9u : 13u) << name;
    for (const auto& [id, info] : set.classes()) {
      EXPECT_FALSE(info.guessed) << name << " " << info.name;
      EXPECT_EQ(
          info.kind == Kind::none,
          info.role == Role::ignored || (info.role == Role::dynamic && info.kind == Kind::none))
          << name << " " << info.name;
    }
  }
}

TEST(ShippedLabelSets, DifferOnlyWhereTheirSourcesDo) {
  const LabelSet raw = shippedLabelSet("semantic_kitti");
  const LabelSet from_1 = shippedLabelSet("semantic_kitti_train_1");
  const LabelSet from_0 = shippedLabelSet("semantic_kitti_train_0");
  EXPECT_EQ(raw.className(80), "pole");
  EXPECT_EQ(raw.className(259), "moving-other-vehicle");
  EXPECT_EQ(from_1.role(0), Role::ignored);
  EXPECT_EQ(from_0.role(255), Role::ignored);
  for (std::uint32_t id = 1; id <= 19; ++id) {
    EXPECT_EQ(from_1.className(id), from_0.className(id - 1));
    EXPECT_EQ(from_1.role(id), from_0.role(id - 1));
  }
}

TEST(ShippedLabelSets, ServeTheClassesThatRepeatBetweenVisits) {
  EXPECT_EQ(shippedLabelSet("semantic_kitti").kind(71), Kind::trunk);
  EXPECT_EQ(shippedLabelSet("synthia").kind(15), Kind::light);
  EXPECT_EQ(shippedLabelSet("cityscapes").kind(17), Kind::pole);
  EXPECT_EQ(shippedLabelSet("kitti360").kind(38), Kind::light);
  EXPECT_EQ(shippedLabelSet("carla").kind(12), Kind::sign);
  EXPECT_EQ(shippedLabelSet("carla_0_9_14").kind(6), Kind::pole);
  EXPECT_EQ(shippedLabelSet("nuscenes").kind(28), Kind::building);
  EXPECT_EQ(shippedLabelSet("nuscenes").role(9), Role::dynamic);
}

TEST(ShippedLabelSets, AnUnknownNameNamesTheNearest) {
  EXPECT_THROW(shippedLabelSet("semantickitti"), UsageError);
  EXPECT_EQ(messageOf([] { shippedLabelSet("semantickitti"); }),
            "unknown label set 'semantickitti'; the nearest known one is semantic_kitti");
}

TEST(ShippedLabelSets, APathIsAFileThatIsMissingNotAMisspeltName) {
  EXPECT_EQ(messageOf([] { shippedLabelSet("data/classes.yaml"); }),
            "label set 'data/classes.yaml': no such file");
}

}  // namespace
}  // namespace xview::io
