// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/recording.h"

#include <gtest/gtest.h>
#include <algorithm>

#include <filesystem>

#include "base/parallel.h"
#include "recording_folder.h"
#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;
using test::messageOf;
using test::pngBytes;
using Recording = test::RecordingFolder;

TEST(ParseFrameRange, ReadsHalfOpenRangesWithSteps) {
  const FrameRange full = parseFrameRange(":");
  EXPECT_EQ(full.begin, 0u);
  EXPECT_FALSE(full.end.has_value());
  EXPECT_EQ(full.step, 1u);
  const FrameRange part = parseFrameRange("10:40:3");
  EXPECT_EQ(part.begin, 10u);
  EXPECT_EQ(*part.end, 40u);
  EXPECT_EQ(part.step, 3u);
  EXPECT_EQ(*parseFrameRange(":5").end, 5u);
  EXPECT_EQ(parseFrameRange("5:").begin, 5u);
  EXPECT_EQ(parseFrameRange("::2").step, 2u);
}

TEST(ParseFrameRange, RefusesEverythingElse) {
  for (const char* text :
       {"", "5", "a:b", "-1:5", "5:5", "7:5", "1:2:0", "1:2:3:4", "1.5:3", "1 :3"}) {
    EXPECT_THROW(parseFrameRange(text), UsageError) << text;
  }
}

/// A sequence of 2 x 2 pixels whose depth is the number of the frame [m] and whose label is number
/// + 1.
class Sequence : public Recording {
 protected:
  explicit Sequence(std::vector<int> numbers = {0, 1, 2}) : numbers_(std::move(numbers)) {
    write("camera.yaml", "width: 2\nheight: 2\nfx: 2\nfy: 2\ncx: 0.5\ncy: 0.5\ndepth_scale: 0.5\n");
    write("classes.yaml", "- {id: 1, name: pole}\n- {id: 2, name: road}\n- {id: 3, name: car}\n");
    std::string poses;
    for (const int number : numbers_) {
      const auto n = static_cast<std::uint16_t>(number);
      const auto wide = static_cast<std::uint16_t>(2 * n);
      const auto label = static_cast<std::uint16_t>(n + 1);
      write("depth/" + nameOf(number), pngBytes(2, 2, 1, 16, {wide, wide, wide, wide}));
      write("label/" + nameOf(number), pngBytes(2, 2, 1, 8, {label, label, label, label}));
      poses += std::to_string(100 + number) + " " + std::to_string(number) + " 0 0 0 0 0 1\n";
    }
    write("poses.txt", poses);
  }
  static std::string nameOf(int number) {
    const std::string digits = std::to_string(number);
    return std::string(6 - digits.size(), '0') + digits + ".png";
  }
  std::string remove(const std::string& name) const {
    fs::remove_all(folder_ / name);
    return folder_ / name;
  }
  std::string message() const { return openMessage(folder_.path()); }

  std::vector<int> numbers_;
};

class SequenceWithGaps : public Sequence {
 protected:
  SequenceWithGaps() : Sequence({0, 2, 5}) {}
};

TEST_F(Sequence, IsRecognisedByItsFiles) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::sequence);
  remove("camera.yaml");
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::sequence);
}

TEST_F(Sequence, GivesFramesWithPosesStampsAndImages) {
  const auto source = openRecording(folder_.path());
  ASSERT_EQ(source->size(), 3u);
  EXPECT_EQ(source->sensor(), Sensor::camera);
  EXPECT_EQ(source->name(), folder_.path());
  EXPECT_EQ(source->labels().kind(1), Kind::pole);
  const Frame frame = source->read(2);
  EXPECT_EQ(frame.number, 2);
  EXPECT_EQ(frame.stamp_s, 102);
  EXPECT_EQ(frame.T_odom_sensor.translation().x(), 2);
  EXPECT_EQ(frame.depth.pixels, std::vector<float>(4, 2.0f));
  EXPECT_EQ(frame.label.pixels, std::vector<std::uint16_t>(4, 3));
  EXPECT_TRUE(frame.instance.empty());
  EXPECT_EQ(frame.camera.width, 2);
  EXPECT_EQ(source->pose(1).translation().x(), 1);
  EXPECT_EQ(source->stamp(1), 101);
  EXPECT_EQ(source->number(1), 1);
}

TEST_F(Sequence, ReadsTheSameFromManyThreads) {
  const auto source = openRecording(folder_.path());
  std::vector<float> depths(300);
  parallelFor(depths.size(), 4,
              [&](std::size_t i) { depths[i] = source->read(i % 3).depth.at(1, 1); });
  for (std::size_t i = 0; i < depths.size(); ++i) EXPECT_EQ(depths[i], static_cast<float>(i % 3));
}

TEST_F(Sequence, IsRestrictedByPosition) {
  InputOptions options;
  options.frames = parseFrameRange("1:100");
  EXPECT_EQ(openRecording(folder_.path(), options)->size(), 2u);
  options.frames = parseFrameRange("::2");
  const auto source = openRecording(folder_.path(), options);
  ASSERT_EQ(source->size(), 2u);
  EXPECT_EQ(source->number(1), 2);
  EXPECT_EQ(source->read(1).depth.at(0, 0), 2.0f);
  options.frames = parseFrameRange("3:4");
  EXPECT_THROW(openRecording(folder_.path(), options), UsageError);
}

TEST_F(SequenceWithGaps, TakesPosesInOrderIfThereIsOnePerFrame) {
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->number(2), 5);
  EXPECT_EQ(source->pose(2).translation().x(), 5);
}

TEST_F(SequenceWithGaps, TakesPosesByNumberIfThereAreMore) {
  std::string poses;
  for (int i = 0; i < 8; ++i)
    poses += std::to_string(i) + " " + std::to_string(10 * i) + " 0 0 0 0 0 1\n";
  write("poses.txt", poses);
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->pose(1).translation().x(), 20);
  EXPECT_EQ(source->pose(2).translation().x(), 50);
}

TEST_F(Sequence, ReadsInstancesIfThereAreAny) {
  for (const int number : numbers_) {
    write("instance/" + nameOf(number), pngBytes(2, 2, 1, 16, {0, 300, 0, 7}));
  }
  EXPECT_EQ(openRecording(folder_.path())->read(0).instance.pixels,
            (std::vector<std::uint16_t>{0, 300, 0, 7}));
  remove("instance/000001.png");
  EXPECT_EQ(message(),
            folder_.path() + ": 3 depth files but 2 instance files; 000001 has no instance file");
}

TEST_F(Sequence, WithoutClassesGetsGenericOnes) {
  remove("classes.yaml");
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->labels().name(), "generic");
  EXPECT_EQ(source->labels().classes().size(), 3u);
  EXPECT_EQ(source->labels().role(3), Role::object);
}

TEST_F(Sequence, WithoutClassesTakesThoseOfferedIfItsIdsAreAmongThem) {
  InputOptions options;
  options.map_labels = LabelSet("of the map");
  for (const std::uint32_t id : {0U, 1U, 2U, 3U, 9U}) {
    ClassInfo info;
    info.id = id;
    info.name = "thing " + std::to_string(id);
    options.map_labels->add(info);
  }
  EXPECT_NE(openRecording(folder_.path(), options)->labels().name(), "of the map");
  remove("classes.yaml");
  EXPECT_EQ(openRecording(folder_.path(), options)->labels().className(3), "thing 3");
  options.map_labels = genericLabelSet({8, 9});
  EXPECT_FALSE(openRecording(folder_.path(), options)->labels().find(9));
}

TEST_F(Sequence, TakesTheLabelSetThatIsAskedFor) {
  InputOptions options;
  options.labels = "synthia";
  EXPECT_EQ(openRecording(folder_.path(), options)->labels().name(), "synthia");
  options.labels = write("mine.yaml", "- {id: 1, name: tower, role: object}\n");
  EXPECT_EQ(openRecording(folder_.path(), options)->labels().className(1), "tower");
  options.labels = "sinthia";
  EXPECT_THROW(openRecording(folder_.path(), options), UsageError);
}

TEST_F(Sequence, MayHaveUnknownClasses) {
  write("label/000001.png", pngBytes(2, 2, 1, 8, {99, 99, 99, 99}));
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->labels().role(source->read(1).label.at(0, 0)), Role::ignored);
}

TEST_F(Sequence, ThatIsDamagedSaysWhatAndWhere) {
  const std::string root = folder_.path();
  write("depth/notes.txt", "other files do not matter");
  EXPECT_EQ(message(), "");
  remove("label/000001.png");
  EXPECT_EQ(message(), root + ": 3 depth files but 2 label files; 000001 has no label file");
  remove("depth/000000.png");
  EXPECT_EQ(message(), root + ": 2 depth files but 2 label files; 000001 has no label file");
  remove("label");
  EXPECT_EQ(message(), "") << "without labels it is raw";
  fs::create_directory(root + "/label");
  EXPECT_EQ(message(), root + "/label: no .png, .tif, .tiff files");
  remove("camera.yaml");
  EXPECT_EQ(message().find(root + "/camera.yaml: cannot open"), 0u) << message();
}

TEST_F(Sequence, WithWrongPosesSaysWhatAndWhere) {
  const std::string path = write("poses.txt", "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n");
  EXPECT_EQ(message(), path + ": 2 poses for 3 frames");
  write("poses.txt", "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 3\n");
  EXPECT_EQ(message(), path + ":3: expected a unit quaternion, found length 3");
  remove("poses.txt");
  EXPECT_EQ(message().find(path + ": cannot open"), 0u) << message();
}

TEST_F(Sequence, WithTwoFilesForOneFrameAsksWhich) {
  write("depth/000001.pfm", test::pfmBytes(2, 2, {1, 2, 3, 4}, true));
  EXPECT_NE(message().find("000001.pfm: there is also "), std::string::npos) << message();
}

TEST_F(Sequence, WithABadFrameFailsAtThatFrameOnly) {
  const std::string path = write("label/000001.png", pngBytes(1, 2, 1, 8, {1, 1}));
  const auto source = openRecording(folder_.path());
  EXPECT_NO_THROW(source->read(0));
  EXPECT_NO_THROW(source->read(2));
  EXPECT_EQ(messageOf([&] { source->read(1); }),
            path + ": 1 x 2 pixels, but " + (folder_ / "depth/000001.png") + " has 2 x 2");
  write("label/000002.png", "no image");
  EXPECT_EQ(messageOf([&] { source->read(2); }).find(folder_ / "label/000002.png: "), 0u);
}

std::string plyOf(const std::string& properties, const std::vector<std::string>& rows,
                  const std::string& more = "") {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(rows.size()) + "\n" +
                     properties + more + "end_header\n";
  for (const std::string& row : rows) text += row + "\n";
  return text;
}

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";

TEST_F(Recording, OneCloudIsAFrameWithoutAViewPoint) {
  write("classes.yaml", "- {id: 7, name: pole}\n");
  const auto path = write("a.ply", plyOf(kXyz + "property int label\n", {"1 2 3 7", "1.1 2 3 7"}));
  const auto source = openRecording(path);
  ASSERT_EQ(source->size(), 1u);
  EXPECT_EQ(source->sensor(), Sensor::cloud);
  EXPECT_EQ(source->labels().kind(7), Kind::pole);
  EXPECT_TRUE(source->pose(0).isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_EQ(source->read(0).cloud.size(), 2u);
}

TEST_F(Recording, ACloudFolderNeedsPoses) {
  for (const char* name : {"1.ply", "2.ply", "10.ply"}) {
    write(name, plyOf(kXyz + "property int label\n",
                      {"1 2 3 7", std::string(1, name[1]) == "0" ? "9 9 9 9" : "1 2 3 8"}));
  }
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::cloud_folder);
  const std::string said = openMessage(folder_.path());
  EXPECT_NE(said.find("3 clouds, but no poses.txt"), std::string::npos) << said;
  EXPECT_NE(said.find("one by one: " + (folder_ / "*.ply")), std::string::npos) << said;
  write("poses.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  const auto source = openRecording(folder_.path());
  ASSERT_EQ(source->size(), 3u);
  EXPECT_EQ(source->sensor(), Sensor::lidar);
  EXPECT_EQ(source->number(2), 10);
  EXPECT_EQ(source->read(2).cloud.points[1].label, 9u);
  EXPECT_EQ(source->labels().classes().size(), 3u);
}

/// 20 x 20 m of ground of the first class, and walls of the others on it.
std::vector<std::string> streetOf(const std::vector<int>& ids) {
  std::vector<std::string> rows;
  const auto add = [&](double x, double y, double z, int id) {
    rows.push_back(std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + " " +
                   std::to_string(id));
  };
  for (int i = 0; i < 400; ++i) {
    add(i % 20, i / 20, 0.01 * (i % 3), ids[0]);
    add(i % 20, 5, 0.25 * (i / 20), ids[1 + static_cast<std::size_t>(i) % (ids.size() - 1)]);
  }
  return rows;
}

TEST_F(Recording, AScanSavedAsACloudIsKnownByTheIdsOfSemanticKitti) {
  const auto source = [&](const std::vector<int>& ids) {
    return openRecording(write("a.ply", plyOf(kXyz + "property int label\n", streetOf(ids))));
  };
  const auto scan = source({40, 0, 10, 48, 50, 70, 71, 252});
  EXPECT_EQ(scan->labels().name(), "semantic_kitti");
  ASSERT_FALSE(scan->notes().empty()) << "it is a guess";
  const std::vector<std::string> notes = scan->notes();
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("--labels") != std::string::npos;
  }));
  EXPECT_EQ(source({40, 0, 10, 48, 50, 70, 71, 77})->labels().name(), "generic");
  EXPECT_EQ(source({40, 0, 10, 11, 13, 30, 48})->labels().name(), "generic");
}

TEST_F(Recording, ARoomIsKnownByTheIdsOfNyu40) {
  const auto source = [&](const std::vector<int>& ids) {
    return openRecording(write("a.ply", plyOf(kXyz + "property ushort label\n", streetOf(ids))));
  };
  const auto room = source({2, 1, 3, 5, 22, 39, 40});
  EXPECT_EQ(room->labels().name(), "nyu40");
  EXPECT_FALSE(room->notes().empty()) << "it is a guess";
  EXPECT_EQ(source({1, 2, 3, 5, 22, 39, 40})->labels().name(), "generic") << "walls lie";
  EXPECT_EQ(source({2, 3, 5, 22, 38, 39, 40})->labels().name(), "generic") << "no walls";
  EXPECT_EQ(source({2, 1, 3, 5, 22, 39, 41})->labels().name(), "generic") << "no such id";
}

TEST_F(Recording, SemanticScansOfCarlaHaveItsTags) {
  const auto scan = openRecording(write(
      "a.ply", plyOf(kXyz + "property float CosAngle\nproperty uint ObjIdx\nproperty uint ObjTag\n",
                     {"1 2 3 0.5 7 1", "1 2 4 0.5 9 24"})));
  EXPECT_EQ(scan->labels().name(), "carla_0_9_14");
  EXPECT_EQ(scan->read(0).cloud.points[1].label, 24u);
  EXPECT_EQ(scan->read(0).cloud.points[1].instance, 9u);
}

TEST_F(Recording, ACommentOfACloudMayNameItsLabelSet) {
  const auto nameIn = [&](const std::string& comment) {
    std::string text = plyOf(kXyz + "property int label\n", {"1 2 3 1", "1 2 4 2"});
    text.insert(text.find("element"), "comment " + comment + "\n");
    return openRecording(write("a.ply", text))->labels().name();
  };
  EXPECT_EQ(nameIn("label = NYU40 id"), "nyu40");
  EXPECT_EQ(nameIn("classes: SemanticKITTI"), "semantic_kitti");
  EXPECT_EQ(nameIn("shapes of an artist"), "generic") << "an ordinary word";
}

TEST_F(Recording, WhatOnlyHasTheIdsOfSemanticKittiIsNotTakenForIt) {
  // A kitchen whose numbers happen to be those: road, sidewalk and terrain are upright.
  const auto path = write(
      "a.ply", plyOf(kXyz + "property int label\n", streetOf({50, 40, 48, 70, 71, 72, 10, 81})));
  EXPECT_EQ(openRecording(path)->labels().name(), "generic");
}

TEST_F(Recording, OfferedClassesAreTakenOnlyIfTheirGroundLiesAsGroundDoes) {
  InputOptions options;
  options.map_labels = LabelSet("town");
  for (const auto& [id, kind] : {std::pair(1U, Kind::road), std::pair(2U, Kind::building)}) {
    ClassInfo info;
    info.id = id;
    info.name = toString(kind);
    info.role = Role::surface;
    info.kind = kind;
    options.map_labels->add(info);
  }
  const auto setOf = [&](const std::vector<int>& ids) {
    const auto path = write("a.ply", plyOf(kXyz + "property int label\n", streetOf(ids)));
    return openRecording(path, options)->labels().name();
  };
  EXPECT_EQ(setOf({1, 2}), "town");
  EXPECT_EQ(setOf({2, 1}), "generic");
}

TEST_F(Recording, APlyWithEdgesOrGraphPropertiesIsAGraph) {
  const auto edges =
      write("a.ply", plyOf(kXyz + "property int label\n", {"0 0 0 1"},
                           "element edge 0\nproperty int vertex1\nproperty int vertex2\n"));
  EXPECT_EQ(recogniseInput(edges), InputKind::graph);
  EXPECT_NE(openMessage(edges).find("is a graph"), std::string::npos);
  const auto sigma =
      write("b.ply", plyOf(kXyz + "property int label\nproperty float sigma\n", {"0 0 0 1 1"}));
  EXPECT_EQ(recogniseInput(sigma), InputKind::graph);
  const auto samples = write("c.ply", plyOf(kXyz + "property int label\nproperty float sigma\n",
                                            {"0 0 0 1 0.2", "0.05 0 0 1 0.2", "0.1 0 0 1 0.2"}));
  EXPECT_EQ(recogniseInput(samples), InputKind::cloud) << "clouds have errors, too";
}

TEST_F(Recording, APlyOfPositionsAndLabelsIsJudgedByItsContent) {
  const std::string label = kXyz + "property int label\n";
  EXPECT_EQ(recogniseInput(write("sparse.ply", plyOf(label, {"0 0 0 1", "5 0 0 1", "9 9 0 1"}))),
            InputKind::graph);
  EXPECT_EQ(recogniseInput(write("dense.ply", plyOf(label, {"0 0 0 1", "0.1 0 0 1", "0.2 0 0 1"}))),
            InputKind::cloud);
  EXPECT_EQ(recogniseInput(write("objects.ply", plyOf(label + "property uint instance\n",
                                                      {"0 0 0 1 7", "0.1 0 0 1 8"}))),
            InputKind::graph);
}

TEST_F(Recording, APlyBetweenGraphAndCloudIsJudgedByItsNeighboursAndSaysSo) {
  const std::string label = kXyz + "property int label\n";
  const auto among_its_like =
      write("like.ply", plyOf(label, {"0 0 0 1", "0.6 0 0 1", "1.2 0 0 1"}));
  EXPECT_EQ(recogniseInput(among_its_like), InputKind::cloud);
  const auto notes = openRecording(among_its_like)->notes();
  ASSERT_FALSE(notes.empty());
  EXPECT_NE(notes.back().find("--input-kind graph"), std::string::npos) << notes.back();
  EXPECT_EQ(recogniseInput(write("desk.ply", plyOf(label, {"0 0 0 1", "0.6 0 0 2", "1.2 0 0 3"}))),
            InputKind::graph);
  InputOptions options;
  options.kind = "graph";
  EXPECT_EQ(recogniseInput(among_its_like, options), InputKind::graph);
}

TEST_F(Recording, OtherPropertiesDoNotMakeAGraphACloudNorFacesACloudAGraph) {
  const std::string more = kXyz + "property int label\nproperty float height\nproperty uchar red\n";
  EXPECT_EQ(recogniseInput(write("a.ply", plyOf(more, {"0 0 0 1 3 1", "9 9 9 1 2 1"}))),
            InputKind::graph);
  const auto mesh =
      write("b.ply", plyOf(more, {"0 0 0 1 3 1", "9 9 9 1 2 1", "3 0 0"},
                           "element face 1\nproperty list uchar int vertex_indices\n"));
  EXPECT_EQ(recogniseInput(mesh), InputKind::cloud);
}

TEST_F(Recording, AGraphIsAGraphWhateverItsSize) {
  // Trees 7 m apart with some of them much closer, in two neighbouring rows of a file.
  constexpr std::size_t kTrees = 150000;
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(2 * kTrees) + "\n" +
                     kXyz + "property int label\nend_header\n";
  for (std::size_t i = 0; i < kTrees; ++i) {
    const std::string x = std::to_string(7 * (i % 400)), y = std::to_string(7 * (i / 400));
    text += x + " " + y + " 0 1\n" + x + ".8 " + y + ".9 0 1\n";
  }
  EXPECT_EQ(recogniseInput(write("trees.ply", text)), InputKind::graph);
}

TEST_F(Recording, OfADenseCloudNoMoreIsReadThanItTakes) {
  // What follows the first vertices is nonsense, which reading all of it would find.
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 100000\n" + kXyz + "property int label\nend_header\n";
  for (int i = 0; i < 6000; ++i)
    text += std::to_string(0.05 * (i % 80)) + " " + std::to_string(0.05 * (i / 80)) + " 0 1\n";
  for (int i = 6000; i < 100000; ++i) text += "here be dragons\n";
  EXPECT_EQ(recogniseInput(write("dense.ply", text)), InputKind::cloud);
}

TEST_F(Recording, APlyThatMayBeEitherOpensAsACloudForWhoeverWantsPoints) {
  const auto path = write("a.ply", plyOf(kXyz + "property int label\n", {"0 0 0 1", "5 0 0 1"}));
  EXPECT_EQ(recogniseInput(path), InputKind::graph);
  EXPECT_EQ(openRecording(path)->read(0).cloud.size(), 2u);
}

TEST_F(Recording, WhatFitsNothingIsRefused) {
  EXPECT_EQ(openMessage(folder_ / "absent"), (folder_ / "absent") + ": no such file or folder");
  EXPECT_NE(openMessage(folder_.path()).find("not a recording"), std::string::npos);
  EXPECT_NE(openMessage(write("a.unknown", "")).find("not a known kind of file"),
            std::string::npos);
  EXPECT_NE(openMessage(write("a.xvm", "")).find("is a map"), std::string::npos);
  InputOptions options;
  options.kind = "clowd";
  EXPECT_THROW(recogniseInput(folder_.path(), options), UsageError);
}

TEST_F(Sequence, ThatIsAlsoAKittiFolderAsksWhich) {
  fs::create_directory(folder_ / "velodyne");
  const std::string message = messageOf([&] { recogniseInput(folder_.path()); });
  EXPECT_NE(message.find("may be a sequence or a semantic_kitti"), std::string::npos) << message;
  InputOptions options;
  options.kind = "sequence";
  EXPECT_EQ(openRecording(folder_.path(), options)->size(), 3u);
  EXPECT_EQ(recogniseInput("town.xvm", options), InputKind::map) << "it is sought in a map";
}

TEST(ToString, NamesEveryKindOnceAndReadsItBack) {
  for (int i = 0; i <= static_cast<int>(InputKind::carla); ++i) {
    InputOptions options;
    options.kind = toString(static_cast<InputKind>(i));
    EXPECT_EQ(recogniseInput("anything", options), static_cast<InputKind>(i));
  }
}

}  // namespace
}  // namespace xview::io
