// SPDX-License-Identifier: BSD-3-Clause
// What is drawn and told of maps and answers.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>

#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

TEST_F(TinyTown, AnswersAreDrawnWithTheWayOfTheQueryWhileItIsThere) {
  const std::string answers = file("drawn.jsonl"), page = file("drawn.html");
  fs::copy(town("rear"), file("moving"), fs::copy_options::recursive);
  writeText(answers, succeed({"localize", "-q", "--json", file("moving"), map()}).out);
  succeed({"view", "-q", map(), answers, "-o", page});
  const auto with_way = fs::file_size(page);
  fs::rename(file("moving"), file("moved"));
  succeed({"view", "-q", map(), answers, "-o", page});
  EXPECT_GT(with_way, fs::file_size(page) + 100);
}

TEST_F(TinyTown, MatchesAreDrawnAlsoIfTheQueryIsNotAccepted) {
  const Outcome refused =
      runXview({"match", "-q", town("elsewhere"), map(), file("refused.ply")}, {120, 0, ""});
  EXPECT_EQ(refused.code, 3) << refused.err;
  EXPECT_EQ(readText(file("refused.ply")).rfind("ply\n", 0), 0u);
}

TEST_F(TinyTown, PicturesAreWrittenByTheEndingOfTheirName) {
  succeed({"match", "-q", town("rear"), map(), file("match.ply")});
  EXPECT_EQ(readText(file("match.ply")).rfind("ply\n", 0), 0u);
  succeed({"match", "-q", town("rear"), map(), file("match.png")});
  EXPECT_EQ(readText(file("match.png")).substr(1, 3), "PNG");
  succeed({"view", "-q", map(), file("town.html")});
  EXPECT_NE(readText(file("town.html")).find("<html"), std::string::npos);
  succeed({"view", "-q", town("rear"), file("seen.pcd"), "--voxel", "0.5"});
  EXPECT_EQ(readText(file("seen.pcd")).rfind("# .PCD", 0), 0u);
}

std::size_t pointsOfClass(const std::string& pcd, const std::string& name) {
  const io::CloudHeader header = io::readCloudHeader(pcd);
  const LabelledCloud cloud = io::readCloud(pcd);
  std::size_t count = 0;
  for (const Point& p : cloud.points) count += header.labels->className(p.label) == name;
  return count;
}

TEST_F(TinyTown, CloudsOfMatchAndViewHoldMapQueryAndCorrespondences) {
  succeed({"lift", "-q", town("rear"), file("scan.pcd"), "--voxel", "0.3"});
  writeText(file("scan.jsonl"), succeed({"localize", "-q", "--json", file("scan.pcd"), map()}).out);
  succeed({"match", "-q", file("scan.pcd"), map(), file("match.pcd")});
  for (const char* name : {"road", "query, accepted", "kept correspondence", "pose, accepted"})
    EXPECT_GT(pointsOfClass(file("match.pcd"), name), 20u) << name;
  const auto viewed = [&](std::vector<std::string> files) {
    files.insert(files.begin(), {"view", "-q", "-o", file("view.pcd")});
    succeed(files);
    return readText(file("view.pcd"));
  };
  const std::string alone = viewed({map(), file("scan.jsonl")});
  EXPECT_GT(pointsOfClass(file("view.pcd"), "query, accepted"), 1000u);
  EXPECT_EQ(viewed({map(), file("scan.jsonl"), file("scan.pcd")}), alone)
      << "a scan beside its answer is drawn at its answer's pose, and once";
}

TEST_F(TinyTown, QueriesAreFoundFromTheFolderOfTheirAnswers) {
  const std::string relative = "rear";
  std::string answers = succeed({"localize", "-q", "--json", town("rear"), map()}).out;
  answers.replace(answers.find(town("rear")), town("rear").size(), relative);
  writeText(town("rear") + "/../beside.jsonl", answers);
  const Outcome drawn =
      runXview({"view", map(), town("rear") + "/../beside.jsonl", "-o", file("beside.pcd")});
  EXPECT_EQ(drawn.err.find("is not found"), std::string::npos) << drawn.err;
  EXPECT_GT(pointsOfClass(file("beside.pcd"), "query, accepted"), 1000u);
}

/// A row of the table of `xview lookalikes`.
struct LookalikePlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::optional<double> sure_from_m;
};

std::vector<LookalikePlace> lookalikePlacesIn(const std::string& csv) {
  std::vector<LookalikePlace> places;
  std::istringstream lines(readText(csv));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "x,y,z,sure_from_m,like_x,like_y,like_z");
  while (std::getline(lines, line)) {
    std::vector<std::string> cells{""};
    for (const char c : line) {
      if (c == ',')
        cells.emplace_back();
      else
        cells.back() += c;
    }
    if (cells.size() != 7u) {
      ADD_FAILURE() << line;
      continue;
    }
    LookalikePlace place;
    for (Eigen::Index k = 0; k < 3; ++k)
      place.position[k] = std::stod(cells[static_cast<std::size_t>(k)]);
    if (!cells[3].empty()) place.sure_from_m = std::stod(cells[3]);
    const bool has_like = !cells[4].empty();
    EXPECT_TRUE(place.sure_from_m || has_like) << line << ": nothing says why it is not sure";
    places.push_back(place);
  }
  return places;
}

TEST_F(TinyTown, LookalikesAreATableAPictureAndACloud) {
  const std::string table = file("alike.csv"), picture = file("alike.png"),
                    cloud = file("alike.pcd");
  const std::string said = succeed({"lookalikes", "-q", map(), "-o", table}).out;
  const std::vector<LookalikePlace> places = lookalikePlacesIn(table);
  ASSERT_GT(places.size(), 10u);
  EXPECT_NE(said.find("% of " + std::to_string(places.size()) + " places"), std::string::npos)
      << said;
  EXPECT_NE(said.find("% of the score of the right one"), std::string::npos) << said;

  std::size_t sure = 0;
  const std::vector<io::StampedPose> way = io::readPoses(town("forward") + "/groundtruth.txt");
  for (const LookalikePlace& place : places) {
    double nearest_m = INFINITY;
    for (const io::StampedPose& pose : way)
      nearest_m = std::min(nearest_m, (pose.T_frame_sensor.translation() - place.position).norm());
    EXPECT_LT(nearest_m, 1) << "not on the way of the map: " << place.position.transpose();
    sure += place.sure_from_m.has_value();
  }
  EXPECT_GT(sure, 0u);
  EXPECT_LT(sure, places.size()) << "8 m of a street tell some of its places, and not all";

  succeed({"lookalikes", "-q", map(), "-o", picture});
  const std::string png = readText(picture);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_GT(png.size(), 10000u);

  succeed({"lookalikes", "-q", map(), "-o", cloud});
  const io::CloudHeader header = io::readCloudHeader(cloud);
  const LabelledCloud coloured = io::readCloud(cloud);
  EXPECT_GT(coloured.size(), 10000u);
  for (std::size_t i = 0; i < coloured.size(); i += 97) {
    const Eigen::Vector3d p = coloured.position(i);
    const auto& nearest =
        *std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
          return (a.position - p).norm() < (b.position - p).norm();
        });
    double second_m = INFINITY;  // the table has centimetres, so ties are left out
    for (const LookalikePlace& other : places) {
      if (&other != &nearest) second_m = std::min(second_m, (other.position - p).norm());
    }
    if (second_m < (nearest.position - p).norm() + 0.05) continue;
    std::ostringstream expected;
    if (nearest.sure_from_m)
      expected << "sure from " << *nearest.sure_from_m << " m on";
    else
      expected << "not sure at all";
    EXPECT_EQ(header.labels->className(coloured.points[i].label), expected.str()) << p.transpose();
  }
}

TEST_F(TinyTown, LookalikesOfNothingToCompareAreRefused) {
  EXPECT_EQ(runXview({"lookalikes", map(), "-o", file("alike.txt")}).code, 2);
  succeed({"map", "-q", town("forward"), "--frames", "0:3", file("one.xvm")});
  const Outcome alone = runXview({"lookalikes", "-q", file("one.xvm"), "-o", file("one.csv")});
  EXPECT_EQ(alone.code, 1);
  EXPECT_NE(alone.err.find("map a longer drive"), std::string::npos) << alone.err;
  EXPECT_FALSE(fs::exists(file("one.csv")));
}

/// Check fix for: a cloud in national coordinates was drawn as far from the map as its origin is.
TEST_F(TinyTown, ACloudFarFromItsOriginIsDrawnWhereItWasFound) {
  succeed({"lift", "-q", town("rear"), file("near.pcd"), "--voxel", "0.3"});
  writeText(file("shift.txt"), "1 0 0 500000\n0 1 0 5400000\n0 0 1 0\n0 0 0 1\n");
  writeText(file("beside.txt"), "1 0 0 900\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  for (const std::string name : {"shift", "beside"}) {
    const std::string cloud = file(name + ".pcd"), answers = file(name + ".jsonl");
    succeed({"lift", "-q", file("near.pcd"), "--transform", file(name + ".txt"), cloud});
    const Outcome found = succeed({"localize", cloud, map(), "-o", answers});
    EXPECT_EQ(found.err.find("away from its origin") != std::string::npos, name == "beside");
    succeed({"view", "-q", map(), answers, "-o", file("drawn.pcd")});
    const LabelledCloud drawn = io::readCloud(file("drawn.pcd"));
    for (std::size_t i = 0; i < drawn.size(); ++i)
      ASSERT_LT(drawn.position(i).norm(), 3000) << name;
  }
}

/// Check fix for: answers beside their query were drawn without any map.
TEST_F(TinyTown, AnswersAreDrawnInTheMapThatTheyName) {
  const std::string answers = file("alone.jsonl");
  succeed({"localize", "-q", town("rear"), map(), "-o", answers});
  const Outcome drawn = runXview({"view", town("rear"), answers, "-o", file("alone.pcd")});
  EXPECT_EQ(drawn.code, 0);
  EXPECT_NE(drawn.err.find(map() + " is drawn"), std::string::npos) << drawn.err;
  EXPECT_GT(pointsOfClass(file("alone.pcd"), "road"), 1000u);
  std::string text = readText(answers);
  text.replace(text.find(map()), map().size(), "gone.xvm");
  writeText(answers, text);
  const Outcome bare = runXview({"view", answers, "-o", file("bare.pcd")});
  EXPECT_EQ(bare.code, 0);
  EXPECT_NE(bare.err.find("no map is drawn: gone.xvm is not found"), std::string::npos) << bare.err;
}

TEST_F(TinyTown, ACloudWithoutLabelsIsDrawnByItsShapesOrGrey) {
  writeText(file("bare.pcd"),
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 0\n1 0 0\n1 2 0\n");
  succeed({"view", "-q", file("bare.pcd"), "-o", file("grey.pcd")});
  EXPECT_EQ(pointsOfClass(file("grey.pcd"), "without label"), 3u);
  LabelledCloud large;
  for (int i = 0; i < 10000; ++i) {
    const auto x = static_cast<float>(i % 100) / 5, y = static_cast<float>(i / 100) / 5;
    large.points.emplace_back(x, i % 4 > 0 ? y : 0, i % 4 > 0 ? 0 : y / 5, 0);
  }
  io::writePly(file("large.ply"), large, nullptr);
  for (Point& p : large.points) p.getVector3fMap() *= 1e4F;
  io::writePly(file("mm.ply"), large, nullptr);
  for (const char* name : {"large.ply", "mm.ply"}) {
    std::string bare = readText(file(name));
    bare.replace(bare.find("uint label"), 10, "uint beams");
    writeText(file(name), bare);
  }
  succeed({"view", "-q", file("large.ply"), "-o", file("shapes.pcd")});
  EXPECT_GT(pointsOfClass(file("shapes.pcd"), "ground"), 1000u);
  succeed({"view", "-q", file("mm.ply"), "-o", file("mm.pcd")});
  EXPECT_GT(pointsOfClass(file("mm.pcd"), "without label"), 1000u);
}

TEST_F(TinyTown, TrajectoriesAreDrawnAndUnknownEndingsRefused) {
  const std::string way = file("drawn.tum");
  writeText(way, readText(town("rear") + "/groundtruth.txt"));
  succeed({"view", "-q", map(), way, "-o", file("drawn.html")});
  EXPECT_NE(readText(file("drawn.html")).find("\"name\":\"drawn.tum\""), std::string::npos);
  const Outcome refused = runXview({"view", map(), file("drawn.jpg")});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("a drawing ends with .png"), std::string::npos) << refused.err;
}

TEST_F(TinyTown, TheTableOfAMatchHasALinePerPair) {
  const Outcome matched = succeed({"match", "-q", town("rear"), map(), file("pairs.csv")});
  std::istringstream lines(readText(file("pairs.csv")));
  std::size_t pairs = 0, kept = 0;
  std::string line;
  for (std::getline(lines, line); std::getline(lines, line); ++pairs) kept += line[0] == '1';
  EXPECT_NE(matched.out.find(std::to_string(pairs) + " putative correspondences, " +
                             std::to_string(kept) + " kept"),
            std::string::npos)
      << matched.out;
}

/// Check fix for: match took --class-names for what it read, but not for what it matched.
TEST_F(TinyTown, AMatchTakesTheGivenNamesOfClasses) {
  const std::string own = file("own_names");
  fs::copy(town("rear"), own, fs::copy_options::recursive);
  const LabelSet labels = io::readLabelSet(own + "/classes.yaml");
  std::string classes = "name: own\nclasses:\n";
  for (const auto& [id, info] : labels.classes()) {
    classes += "  - {id: " + std::to_string(id) + ", name: \"" +
               (info.name == "pole" ? "gnomon" : info.name) + "\"}\n";
  }
  writeText(own + "/classes.yaml", classes);
  // Of a kind that tells nothing alone: only the line says that they are the same.
  writeText(file("own_names.txt"), "object other_object: gnomon, pole\n");
  const Outcome matched = runXview(
      {"match", "-q", "--class-names", file("own_names.txt"), own, map(), file("own_names.csv")},
      {120, 0, ""});
  EXPECT_TRUE(matched.code == 0 || matched.code == 3) << matched.err;
  EXPECT_NE(readText(file("own_names.csv")).find(",\"pole\","), std::string::npos);
}

TEST_F(TinyTown, InfoIsJsonForPrograms) {
  const Json drive = Json::parse(succeed({"info", "-q", "--json", town("rear")}).out);
  EXPECT_EQ(drive["kind"], "sequence");
  EXPECT_EQ(drive["frames"]["count"], io::readPoses(town("rear") + "/poses.txt").size());
  EXPECT_FALSE(drive.contains("bounds")) << "a camera has positions";
  EXPECT_EQ(drive["positions"]["min"].size(), 3u);
  EXPECT_GT(drive["classes"].size(), 3u);
  EXPECT_EQ(succeed({"info", "-q", "--json", map(), "-o", file("map.json")}).out, "");
  const Json of_map = Json::parse(readText(file("map.json")));
  EXPECT_EQ(of_map["sources"], Json::array({town("forward")}));
  std::size_t vertices = 0;
  for (const Json& of_class : of_map["classes"]) vertices += of_class["count"].get<std::size_t>();
  EXPECT_EQ(of_map["graph"]["vertices"], vertices);
}

/// Check fix for: a last operand that existed was read, and the picture of the first written over.
TEST_F(TinyTown, ViewWritesOverNothingThatItWasNotToldToWrite) {
  const fs::path before = fs::current_path();
  fs::create_directories(file("here"));
  fs::current_path(file("here"));
  succeed({"lift", "-q", town("rear"), "--voxel", "0.5", "-o", "town.pcd"});
  const std::string cloud = readText("town.pcd");
  EXPECT_EQ(succeed({"view", "-q", map(), "town.pcd"}).out, "town.xvm.png\n");
  EXPECT_EQ(succeed({"view", "-q", "town.pcd"}).out, "town.pcd.png\n");
  EXPECT_TRUE(readText("town.pcd") == cloud);
  const Outcome refused = runXview({"view", "-q", map(), "town.pcd.png"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("-o town.pcd.png writes it anew"), std::string::npos) << refused.err;
  EXPECT_EQ(succeed({"view", "town.pcd", "-v"}).out, "town.pcd.png\n") << "the same picture again";
  const std::string picture = readText("town.pcd.png");
  EXPECT_EQ(runXview({"view", "-q", "town.pcd", map()}).code, 2) << "a picture of another command";
  EXPECT_TRUE(readText("town.pcd.png") == picture);
  fs::current_path(before);
}

}  // namespace
}  // namespace xview::test
