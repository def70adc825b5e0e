// SPDX-License-Identifier: BSD-3-Clause
// Real scans of a street, and bare graphs: objects of OpenStreetMap and pole maps.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "acceptance/answers.h"
#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

/// The first of two answers is the later scan, where it was, the other one out of the map.
void expectFoundAndRefused(const std::string& kitti, const std::string& answers) {
  ASSERT_EQ(lineCount(answers), 2u);
  const std::size_t second = answers.find('\n') + 1;
  const Tally found =
      tallyOf(answers.substr(0, second), positionsIn(kitti + "/query_4501/truth.txt"), 0.1);
  EXPECT_EQ(found.accepted, 1u) << found.reasons;
  EXPECT_EQ(found.wrong, 0u) << found.reasons;
  const Tally refused = tallyOfNegatives(answers.substr(second));
  EXPECT_EQ(refused.windows, 1u);
  EXPECT_EQ(refused.accepted, 0u) << refused.reasons;
}

TEST(KittiStreet, ALaterScanIsFoundAndOneFromElsewhereRefused) {
  XVIEW_REQUIRE_DATA(kitti, "kitti00");
  const TemporaryFolder folder;
  const std::string map = folder / "street.xvm";
  outputOf({"map", "--quiet", kitti + "/map", map});
  const std::string answers = localize({kitti + "/query_4501", kitti + "/negative_850", map});
  expectFoundAndRefused(kitti, answers);
}

/// A KITTI folder without its labels, made of links.
std::string withoutLabels(const std::string& recording, const std::string& target) {
  std::filesystem::create_directory(target);
  for (const char* part : {"velodyne", "poses.txt", "calib.txt"})
    std::filesystem::create_symlink(recording + "/" + part, target + "/" + part);
  return target;
}

/// Map and queries have no labels, then only one side has none, where less is in common and the
/// answer less sure.
TEST(KittiStreet, ALaterScanIsFoundWithoutLabels) {
  XVIEW_REQUIRE_DATA(kitti, "kitti00");
  const TemporaryFolder folder;
  const std::string map = folder / "street.xvm", labelled_map = folder / "labelled.xvm";
  outputOf({"map", "--quiet", withoutLabels(kitti + "/map", folder / "map"), map});
  outputOf({"map", "--quiet", kitti + "/map", labelled_map});
  const std::string raw = withoutLabels(kitti + "/query_4501", folder / "raw"),
                    raw_negative = withoutLabels(kitti + "/negative_850", folder / "stranger");
  for (const std::string& answers :
       {localize({raw, raw_negative, map}),
        localize({raw, raw_negative, labelled_map, "--risk", "0.05"}),
        localize({kitti + "/query_4501", kitti + "/negative_850", map})}) {
    expectFoundAndRefused(kitti, answers);
  }
}

/// A vertex of a bare graph, with the rest of its line.
struct Thing {
  Eigen::Vector3d position;
  std::string rest;  ///< label and instance
};

std::vector<Thing> thingsIn(const std::string& ply) {
  std::istringstream lines(readText(ply));
  std::string line;
  while (std::getline(lines, line) && line != "end_header") {
  }
  std::vector<Thing> things;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    Thing thing;
    words >> thing.position.x() >> thing.position.y() >> thing.position.z();
    std::getline(words, thing.rest);
    things.push_back(thing);
  }
  return things;
}

/// What lies around a place, in a frame of its own.
struct Disc {
  Eigen::Vector2d center;
  double radius_m;
  Eigen::Isometry3d T_disc_map = Eigen::Isometry3d::Identity();
};

void writeDisc(const std::string& path, const std::vector<Thing>& things, const Disc& disc) {
  std::string body;
  std::size_t count = 0;
  for (const Thing& thing : things) {
    if ((thing.position.head<2>() - disc.center).norm() > disc.radius_m) continue;
    const Eigen::Vector3d p = disc.T_disc_map * thing.position;
    char xyz[96];
    std::snprintf(xyz, sizeof xyz, "%.3f %.3f %.3f", p.x(), p.y(), p.z());
    body += xyz + thing.rest + "\n";
    ++count;
  }
  writeText(path, "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
                      "\nproperty double x\nproperty double y\nproperty double z\n"
                      "property int label\nproperty uint instance\nend_header\n" +
                      body);
}

Eigen::Isometry3d frameAt(const Eigen::Vector2d& center, double yaw_rad) {
  return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
         Eigen::Translation3d(-center.x(), -center.y(), 0);
}

/// Cuts discs out of one graph and looks for them in another of the same frame. The error of an
/// answer is how far the middle of the disc, the origin of its frame, lies from where it was.
Tally tallyOfDiscs(const std::string& from, const std::string& in, double radius_m,
                   const std::vector<Eigen::Vector2d>& centers) {
  const TemporaryFolder folder;
  const std::vector<Thing> things = thingsIn(from);
  std::vector<std::string> arguments;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    arguments.push_back(folder / ("disc" + std::to_string(i) + ".ply"));
    writeDisc(arguments.back(), things,
              {centers[i], radius_m, frameAt(centers[i], 0.7 + static_cast<double>(i))});
  }
  arguments.push_back(in);
  Tally tally;
  for (const Json& answer : jsonLines(localize(arguments))) {
    const Json& T = answer["T_map_query"];
    const Eigen::Vector2d middle =
        T.is_array() ? Eigen::Vector2d(T[3], T[7]) : Eigen::Vector2d::Constant(NAN);
    count(tally, answer, (middle - centers.at(tally.windows)).norm(), 5);
  }
  return tally;
}

TEST(OpenStreetMap, PlacesOfTodayAreFoundInTheMapOfEightYearsAgo) {
  XVIEW_REQUIRE_DATA(osm, "osm");
  const Tally tally = tallyOfDiscs(osm + "/monaco_2020-07-19.ply", osm + "/monaco_2012-07-06.ply",
                                   200, {{-500, -300}, {-100, -300}, {500, 500}, {-300, 100}});
  EXPECT_EQ(tally.windows, 4u);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 3u) << tally.reasons;
}

TEST(OpenStreetMap, PlacesOfAnotherCountryAreRefused) {
  XVIEW_REQUIRE_DATA(osm, "osm");
  const Tally tally = tallyOfDiscs(osm + "/monaco_2020-07-19.ply", osm + "/andorra_2020-05-01.ply",
                                   200, {{-500, -300}, {500, 500}});
  EXPECT_EQ(tally.windows, 2u);
  EXPECT_EQ(tally.accepted, 0u) << tally.reasons;
}

TEST(PoleMaps, PolesFoundByAProgramAreFoundAmongThoseMappedByHand) {
  XVIEW_REQUIRE_DATA(poles, "pole_maps");
  const Tally tally = tallyOfDiscs(poles + "/poles_nclt_auto.ply", poles + "/poles_nclt_gt.ply",
                                   100, {{-500, -100}, {-300, -100}, {-700, -300}, {-100, 100}});
  EXPECT_EQ(tally.windows, 4u);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 3u) << tally.reasons;
}

}  // namespace
}  // namespace xview::test
