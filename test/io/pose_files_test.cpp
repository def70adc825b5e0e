// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/pose_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/pose.h"
#include "base/random.h"
#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

using test::messageOf;

class PoseFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    test::writeText(folder_ / "poses.txt", text);
    return folder_ / "poses.txt";
  }
  std::string messageFor(const std::string& text) const {
    const std::string path = write(text);
    return messageOf([&] { readPoses(path); });
  }
  std::string at(int line) const { return (folder_ / "poses.txt") + ":" + std::to_string(line); }

  test::TemporaryFolder folder_;
};

TEST_F(PoseFiles, EightNumbersAreStampTranslationAndQuaternion) {
  const auto poses = readPoses(write("# a comment\n12.5 1 2 3 0 0 0.70710678 0.70710678\n\n"));
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].stamp_s, 12.5);
  EXPECT_EQ(poses[0].T_frame_sensor.translation(), Eigen::Vector3d(1, 2, 3));
  const Eigen::Vector3d x = poses[0].T_frame_sensor.linear() * Eigen::Vector3d::UnitX();
  EXPECT_NEAR((x - Eigen::Vector3d::UnitY()).norm(), 0, 1e-9);
}

TEST_F(PoseFiles, TwelveNumbersAreRowsAndTheLineIsTheStamp) {
  const auto poses =
      readPoses(write("1 0 0 5 0 1 0 6 0 0 1 7\r\n0 -1 0 8 1 0 0 9 0 0 1 10 # turned\r\n"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].stamp_s, 1);
  EXPECT_EQ(poses[1].T_frame_sensor * Eigen::Vector3d::UnitX(), Eigen::Vector3d(8, 10, 10));
}

TEST_F(PoseFiles, RoundedRotationsBecomeRotations) {
  const auto quaternion = readPoses(write("0 0 0 0 0 0 0.7 0.708\n"));
  EXPECT_TRUE(isRigid(quaternion[0].T_frame_sensor.matrix(), 1e-12));
  const auto rows = readPoses(write("1.0002 0.0001 0 0 0 1 0 0 0 0 1 0\n"));
  EXPECT_TRUE(isRigid(rows[0].T_frame_sensor.matrix(), 1e-12));
}

TEST_F(PoseFiles, WhatIsWrongIsNamedWithItsLine) {
  EXPECT_EQ(messageFor("1 2 3\n"), at(1) + ": expected 8 numbers (TUM) or 12 (KITTI), found 3");
  EXPECT_EQ(messageFor("# c\n0 0 0 0 0 0 0 1\n1 0 0 0 0 1 0 0 0 0 1 0\n"),
            at(3) + ": expected 8 numbers as in the lines before, found 12");
  EXPECT_EQ(messageFor("0 0 0 0 0 0 zero 1\n"), at(1) + ": expected a finite number, found 'zero'");
  EXPECT_EQ(messageFor("0 0 nan 0 0 0 0 1\n"), at(1) + ": expected a finite number, found 'nan'");
  EXPECT_EQ(messageFor("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 0\n"),
            at(2) + ": expected a unit quaternion, found length 0");
  EXPECT_EQ(messageFor("2 0 0 0 0 2 0 0 0 0 2 0\n"),
            at(1) + ": expected a rotation in columns 1-3, found R R^T off by 3 and determinant 8");
  EXPECT_NE(messageFor("1 0 0 0 0 1 0 0 0 0 -1 0\n").find("determinant -1"), std::string::npos);
  EXPECT_NE(messageFor("1,0 0 0 0 0 0 0 1\n"), "");
  EXPECT_NE(messageFor(std::string("0 0 0 0 0 0 0 1\0", 16)), "");
}

TEST_F(PoseFiles, AnEmptyFileHasNoPosesAndAMissingOneIsAnError) {
  EXPECT_TRUE(readPoses(write("")).empty());
  EXPECT_THROW(readPoses(folder_ / "absent.txt"), Error);
}

TEST_F(PoseFiles, AsManyPosesAsFramesAreTakenInOrder) {
  const auto path = write("0 10 0 0 0 0 0 1\n1 11 0 0 0 0 0 1\n");
  const auto poses = posesOfFrames(path, {7, 9});
  EXPECT_EQ(poses[0].stamp_s, 0);
  EXPECT_EQ(poses[1].stamp_s, 1);
}

TEST_F(PoseFiles, MorePosesThanFramesAreTakenByNumber) {
  const auto path = write("0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  const auto poses = posesOfFrames(path, {0, 2});
  EXPECT_EQ(poses[1].stamp_s, 2);
  EXPECT_EQ(messageOf([&] {
              posesOfFrames(path, {0, 3});
            }),
            path +
                ": 3 poses for 2 frames, taken by the number of the frame, but frame 3 is beyond "
                "the last line");
}

TEST_F(PoseFiles, FewerPosesThanFramesAreAnErrorThatNamesBoth) {
  const auto path = write("0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(messageOf([&] { posesOfFrames(path, {0, 1, 2}); }), path + ": 1 poses for 3 frames");
}

TEST_F(PoseFiles, WrittenPosesAreReadBack) {
  Random random(1);
  std::vector<StampedPose> poses(20);
  for (StampedPose& pose : poses) {
    pose.stamp_s = 1.6e9 + random.uniform();
    pose.T_frame_sensor.linear() =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
            .normalized()
            .toRotationMatrix();
    pose.T_frame_sensor.translation() << random.uniform(-1e5, 1e5), random.uniform(), 3;
  }
  writeTumPoses(folder_ / "tum.txt", poses);
  const auto read = readPoses(folder_ / "tum.txt");
  ASSERT_EQ(read.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(read[i].stamp_s, poses[i].stamp_s, 1e-6);
    EXPECT_LT((read[i].T_frame_sensor.matrix() - poses[i].T_frame_sensor.matrix()).norm(), 1e-7);
  }
}

Eigen::Isometry3d somewhere() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(453210.123456789, -5.4e6 / 7, 1.0 / 3);
  return T;
}

TEST(MatrixFile, FourLinesOfFourNumbersRowByRowToTheLastBit) {
  const test::TemporaryFolder folder;
  const Eigen::Isometry3d T = somewhere();
  writeMatrix(folder / "T.txt", T);
  std::ifstream file(folder / "T.txt");
  int rows = 0;
  for (std::string line; std::getline(file, line); ++rows) {
    ASSERT_LT(rows, 4);
    std::istringstream words(line);
    std::string word;
    for (int column = 0; column < 4; ++column) {
      ASSERT_TRUE(words >> word);
      EXPECT_EQ(std::stod(word), T.matrix()(rows, column)) << rows << "," << column;
    }
    EXPECT_FALSE(words >> word) << line;
  }
  EXPECT_EQ(rows, 4);
}

TEST(MatrixFile, FolderThatDoesNotExistIsAnErrorWithThePath) {
  const test::TemporaryFolder folder;
  const std::string said =
      test::messageOf<Error>([&] { writeMatrix(folder / "no/T.txt", somewhere()); });
  EXPECT_NE(said.find("no/T.txt"), std::string::npos) << said;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

/// Check fix for: a pose at 1e308 m was taken, and everything seen from there vanished.
TEST(PoseFile, PositionsBeyondEarthAreErrorsWithTheirLine) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "poses.txt";
  const auto said = [&](const std::string& text) {
    test::writeText(path, text);
    return test::messageOf<Error>([&] { readPoses(path); });
  };
  EXPECT_EQ(said("0 1e8 -1e8 0 0 0 0 1\n1 0 0 1.1e8 0 0 0 1\n"),
            path + ":2: expected a position within 1e+08 m of the origin, found 1.1e+08 m");
  EXPECT_EQ(said("1 0 0 0 0 1 0 -1e308 0 0 1 0\n"),
            path + ":1: expected a position within 1e+08 m of the origin, found 1e+308 m");
  EXPECT_EQ(said("0 691000 5334000 520 0 0 0 1\n"), "") << "UTM";
}

}  // namespace
}  // namespace xview::io
