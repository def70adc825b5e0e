// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/program.h"
#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

Outcome runExample(const std::string& name, const std::vector<std::string>& arguments) {
  return runProgram(XVIEW_EXAMPLES "/" + name, arguments, {120, 0, ""});
}

/// The matrix that ends what an example prints.
Eigen::Isometry3d printedPose(const std::string& out) {
  std::vector<std::string> lines;
  std::istringstream text(out);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  Eigen::Matrix4d T = Eigen::Matrix4d::Constant(NAN);
  if (lines.size() < 4) return Eigen::Isometry3d(T);
  for (Eigen::Index row = 0; row < 4; ++row) {
    std::istringstream numbers(lines[lines.size() - 4 + static_cast<std::size_t>(row)]);
    for (Eigen::Index column = 0; column < 4; ++column) numbers >> T(row, column);
  }
  return Eigen::Isometry3d(T);
}

/// A binary PCD of x, y and z, without labels.
void writeRaw(const std::string& path, const LabelledCloud& cloud) {
  std::ostringstream pcd;
  pcd << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " << cloud.size()
      << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << cloud.size() << "\nDATA binary\n";
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i).cast<float>();
    pcd.write(reinterpret_cast<const char*>(p.data()), 3 * sizeof(float));
  }
  writeText(path, pcd.str());
}

/// Clouds of the drives through the tiny town, with labels and without.
class Examples : public TinyTown {
 protected:
  static void SetUpTestSuite() {
    TinyTown::SetUpTestSuite();
    for (const std::string session : {"forward", "rear"}) {
      const std::string cloud = file(session + ".pcd");
      succeed({"lift", "-q", town(session), cloud, "--voxel", "0.1"});
      writeRaw(file(session + "_raw.pcd"), io::readCloud(cloud));
    }
    succeed({"map", "-q", file("forward_raw.pcd"), file("raw.xvm")});
  }

  static std::string lidarWithoutLabels() {
    const std::string raw = file("lidar_raw");
    if (fs::exists(raw)) return raw;
    fs::create_directory(raw);
    for (const char* part : {"velodyne", "poses.txt", "calib.txt"})
      fs::create_symlink(town("lidar") + "/" + part, raw + "/" + part);
    return raw;
  }

  /// T_map_query of the program for the same files; NAN if it accepts nothing.
  static Eigen::Isometry3d poseOfProgram(const std::string& query, const std::string& map) {
    const Outcome outcome = runXview({"localize", "-q", "--json", query, map}, {120, 0, ""});
    if (outcome.code != 0)
      return Eigen::Isometry3d(Eigen::Matrix4d(Eigen::Matrix4d::Constant(NAN)));
    return poseIn(jsonLines(outcome.out).at(0));
  }

  /// `tolerance`: six digits of the pose are printed.
  static void expectAnswerOfProgram(const Outcome& outcome, const std::string& query,
                                    const std::string& map, double tolerance = 1e-3) {
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const Eigen::Isometry3d expected = poseOfProgram(query, map), found = printedPose(outcome.out);
    EXPECT_LT((found.matrix() - expected.matrix()).norm(), tolerance) << outcome.out;
  }
};

TEST_F(Examples, OneCallGivesTheAnswerOfTheProgramWithLabelsAndWithout) {
  expectAnswerOfProgram(runExample("01_one_call", {map(), town("rear")}), town("rear"), map());
  expectAnswerOfProgram(runExample("01_one_call", {file("raw.xvm"), file("rear_raw.pcd")}),
                        file("rear_raw.pcd"), file("raw.xvm"));
  EXPECT_EQ(runExample("01_one_call", {map(), town("elsewhere")}).code, 3);
  const Outcome missing = runExample("01_one_call", {file("no.xvm"), town("rear")});
  EXPECT_EQ(missing.code, 1);
  EXPECT_EQ(lineCount(missing.err), 1u) << missing.err;
}

TEST_F(Examples, StagesFindWindowsWithLabelsAndWithout) {
  const Outcome labelled = runExample("02_stages", {town("forward"), town("rear"), "25"});
  EXPECT_EQ(labelled.code, 0) << labelled.out << labelled.err;
  const Outcome raw = runExample("02_stages", {file("forward_raw.pcd"), file("rear_raw.pcd"), "1"});
  EXPECT_EQ(raw.code, 0) << raw.out << raw.err;
  EXPECT_EQ(raw.out.find("map: 0 vertices"), std::string::npos) << raw.out;
}

TEST_F(Examples, OwnCloudsAreFoundInTheClassesOfTheMap) {
  const Outcome found = runExample("03_own_clouds", {map(), file("rear.pcd")});
  // A pcl::PointXYZL does not say how far it errs; the points of the file do.
  expectAnswerOfProgram(found, file("rear.pcd"), map(), 0.2);
  const Outcome raw = runExample("03_own_clouds", {map(), file("rear_raw.pcd")});
  EXPECT_EQ(raw.code, 1);
  EXPECT_NE(raw.err.find("has no field label"), std::string::npos) << raw.err;
}

TEST_F(Examples, RawCloudsGiveTheAnswerOfTheProgram) {
  expectAnswerOfProgram(
      runExample("04_raw_clouds", {file("forward_raw.pcd"), file("rear_raw.pcd")}),
      file("rear_raw.pcd"), file("forward_raw.pcd"));
}

TEST_F(Examples, ARobotIsFollowedWithLabelsAndWithout) {
  const Outcome labelled = runExample("05_follow", {map(), town("rear"), "15"});
  EXPECT_EQ(labelled.code, 0) << labelled.out << labelled.err;
  EXPECT_NE(labelled.out.find("m by odometry"), std::string::npos) << labelled.out;
  succeed({"map", "-q", town("lidar"), file("lidar.xvm")});
  for (const std::string& recording : {town("lidar"), lidarWithoutLabels()}) {
    const Outcome scans = runExample("05_follow", {file("lidar.xvm"), recording, "10"});
    EXPECT_EQ(scans.code, 0) << recording << "\n" << scans.out << scans.err;
    EXPECT_NE(scans.out.find("m by fix"), std::string::npos) << recording << scans.out;
  }
}

TEST_F(Examples, FindALaterScanOfARealStreet) {
  XVIEW_REQUIRE_DATA(kitti, "kitti00");
  const std::string street = file("street.xvm"), query = file("scan.pcd");
  succeed({"map", "-q", kitti + "/map", street});
  const auto expectFound = [&](const Outcome& found) {
    EXPECT_EQ(found.code, 0) << found.out << found.err;
    const Eigen::Vector3d truth =
        io::readPoses(kitti + "/query_4501/truth.txt").back().T_frame_sensor.translation();
    EXPECT_LT((printedPose(found.out).translation() - truth).norm(), 0.2) << found.out;
  };
  expectFound(runExample("01_one_call", {street, kitti + "/query_4501"}));
  EXPECT_EQ(runExample("01_one_call", {street, kitti + "/negative_850"}).code, 3);
  succeed({"lift", "-q", kitti + "/map", "--voxel", "0", query});
  writeRaw(file("street_raw.pcd"), io::readCloud(query));
  succeed({"lift", "-q", kitti + "/query_4501", "--voxel", "0", query});
  writeRaw(file("scan_raw.pcd"), io::readCloud(query));
  expectFound(runExample("04_raw_clouds", {file("street_raw.pcd"), file("scan_raw.pcd")}));
  EXPECT_EQ(runExample("05_follow", {street, kitti + "/map", "4"}).code, 0);
}

/// A pair of raw sub-maps, the sample of small_gicp.
TEST_F(Examples, FindARealSubMapInAnother) {
  XVIEW_REQUIRE_DATA(pair, "registration");
  const Outcome found = runExample("02_stages", {pair + "/target.ply", pair + "/source.ply", "1"});
  EXPECT_EQ(found.out.find("map: 0 vertices"), std::string::npos) << found.out;
  EXPECT_TRUE(found.code == 0 || found.code == 3) << found.err;
}

}  // namespace
}  // namespace xview::test
