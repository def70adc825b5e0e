// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "base/random.h"
#include "small_files.h"
#include "support/clouds.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

using Writer = void (*)(const std::string&, const LabelledCloud&, const LabelSet*);

LabelledCloud randomCloud(std::size_t points, bool instances) {
  LabelledCloud cloud;
  Random random(3);
  for (std::size_t i = 0; i < points; ++i) {
    Point point;
    point.x = static_cast<float>(random.uniform(-100, 100));
    point.y = static_cast<float>(random.uniform(-1e4, 1e4));
    point.z = static_cast<float>(random.uniform(-1e-3, 1e-3));
    point.label = random.below(1000);
    cloud.points.push_back(point);
    if (instances) cloud.points.back().instance = random.below(70000);
  }
  return cloud;
}

LabelSet oneClass() {
  LabelSet labels("test");
  ClassInfo info;
  info.id = 7;
  info.name = "pole";
  info.color = {255, 128, 1};
  labels.add(info);
  return labels;
}

void expectSame(const LabelledCloud& a, const LabelledCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(test::instancesOf(a), test::instancesOf(b));
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.points[i].getVector3fMap(), b.points[i].getVector3fMap());
    ASSERT_EQ(a.points[i].label, b.points[i].label);
  }
}

class CloudWriters : public ::testing::TestWithParam<std::pair<const char*, Writer>> {
 protected:
  std::string path() const { return folder_ / GetParam().first; }
  void write(const LabelledCloud& cloud, const LabelSet* colors = nullptr) const {
    GetParam().second(path(), cloud, colors);
  }
  test::TemporaryFolder folder_;
};

TEST_P(CloudWriters, WhatIsWrittenReadsBackExactly) {
  const LabelSet labels = oneClass();
  for (const bool instances : {false, true}) {
    for (const LabelSet* colors : {static_cast<const LabelSet*>(nullptr), &labels}) {
      const LabelledCloud cloud = randomCloud(5000, instances);
      write(cloud, colors);
      expectSame(readCloud(path()), cloud);
    }
  }
}

TEST_P(CloudWriters, KnownErrorsReadBackAndUnknownOnesTakeNoRoom) {
  LabelledCloud cloud = randomCloud(50, true);
  write(cloud);
  EXPECT_EQ(readCloudHeader(path()).fields.back(), "instance");
  cloud.points[7].sigma = 0.25F;
  write(cloud);
  EXPECT_EQ(readCloudHeader(path()).fields.back(), "sigma");
  const LabelledCloud read = readCloud(path());
  expectSame(read, cloud);
  EXPECT_EQ(read.points[7].sigma, 0.25F);
  EXPECT_EQ(read.points[8].sigma, 0);
  for (const float wrong : {-0.1F, std::numeric_limits<float>::quiet_NaN()}) {
    cloud.points[9].sigma = wrong;
    write(cloud);
    EXPECT_THROW(readCloud(path()), Error);
  }
}

TEST_P(CloudWriters, CoordinatesFarAwayKeepTheirMicrometres) {
  LabelledCloud cloud = randomCloud(500, true);
  cloud.origin = {500000, 4649776, 53};
  write(cloud);
  const LabelledCloud read = readCloud(path());
  ASSERT_EQ(read.size(), cloud.size());
  EXPECT_FALSE(read.origin.isZero());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((read.position(i) - cloud.position(i)).norm(),
              2e-3);  // 20 km apart: float32 steps of 1 mm
  }
}

TEST_P(CloudWriters, WrittenFarCoordinatesAreDoubles) {
  LabelledCloud cloud = randomCloud(1, false);
  cloud.origin = {500000, 4649776, 53};
  write(cloud);
  const std::string bytes = test::readText(path());
  EXPECT_NE(bytes.find(test::raw(cloud.position(0).y())), std::string::npos);
}

TEST_P(CloudWriters, OriginsNearByStaySinglePrecisionForPcl) {
  LabelledCloud cloud = randomCloud(200, false);
  for (Point& point : cloud.points) point.y *= 0.01F;
  cloud.origin = {-208, 5190, -18};
  write(cloud);
  const LabelledCloud read = readCloud(path());
  EXPECT_TRUE(read.origin.isZero());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_LT((read.position(i) - cloud.position(i)).norm(), 5e-4);
}

TEST_P(CloudWriters, ClassesAreInTheHeaderAndReadBackTheSame) {
  LabelSet labels = oneClass();
  ClassInfo info;
  info.id = 4000000000U;
  info.name = "low  vegetation\n(hedge)";
  info.role = Role::surface;
  info.kind = Kind::vegetation;
  labels.add(info);
  write(randomCloud(3, false), &labels);
  const std::optional<LabelSet> read = readCloudHeader(path()).labels;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->name(), "test");
  ASSERT_EQ(read->classes().size(), 2u);
  EXPECT_EQ(read->className(4000000000U), "low vegetation (hedge)");
  EXPECT_EQ(read->role(4000000000U), Role::surface);
  EXPECT_EQ(read->kind(4000000000U), Kind::vegetation);
  EXPECT_EQ(read->color(7), labels.color(7));
  EXPECT_EQ(openRecording(path())->labels(), *read);
}

TEST_P(CloudWriters, ClassesWithoutNamesAreNotInTheHeader) {
  const LabelSet generic = genericLabelSet({1, 7});
  write(randomCloud(3, false), &generic);
  EXPECT_FALSE(readCloudHeader(path()).labels);
}

TEST_P(CloudWriters, ADamagedClassInTheHeaderIsAnError) {
  const LabelSet labels = oneClass();
  write(randomCloud(3, false), &labels);
  std::string bytes = test::readText(path());
  bytes.replace(bytes.find("object"), 6, "objets");
  test::writeText(path(), bytes);
  EXPECT_NE(test::messageOf<Error>([&] { readCloudHeader(path()); }).find("xview class 7 objets"),
            std::string::npos);
}

TEST_P(CloudWriters, AnEmptyCloudIsAValidFile) {
  const LabelSet labels = oneClass();
  write(LabelledCloud(), &labels);
  EXPECT_EQ(readCloud(path()).size(), 0u);
  EXPECT_EQ(readCloudHeader(path()).label_field, "label");
}

TEST_P(CloudWriters, PointsThatAreNotFiniteAreWrittenAndDroppedOnReading) {
  LabelledCloud cloud = randomCloud(3, false);
  cloud.points[1].x = std::numeric_limits<float>::quiet_NaN();
  write(cloud);
  EXPECT_EQ(readCloudHeader(path()).points, 3u);
  EXPECT_EQ(readCloud(path()).size(), 2u);
}

TEST_P(CloudWriters, AnErrorLeavesTheOldFile) {
  std::filesystem::create_directory(folder_ / "sub");
  const std::string inside = folder_ / "sub/" + GetParam().first;
  const std::string missing = folder_ / "missing/" + GetParam().first;
  const LabelledCloud cloud = randomCloud(3, false);
  EXPECT_EQ(
      test::messageOf<Error>([&] { GetParam().second(missing, cloud, nullptr); }),
      missing + ": cannot write: there is no folder " + (folder_ / "missing") + "; make it first");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "missing"));
  EXPECT_EQ(test::messageOf<Error>([&] { GetParam().second(inside, cloud, nullptr); }), "");
}

TEST_P(CloudWriters, AFullDiskIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const LabelledCloud cloud = randomCloud(100, false);
  EXPECT_EQ(test::messageOf<Error>([&] { GetParam().second("/dev/full", cloud, nullptr); }),
            "/dev/full: cannot write: No space left on device");
}

INSTANTIATE_TEST_SUITE_P(Formats, CloudWriters,
                         ::testing::Values(std::pair<const char*, Writer>{"a.pcd", writePcd},
                                           std::pair<const char*, Writer>{"a.ply", writePly}),
                         [](const auto& format) {
                           return std::string(format.index == 0 ? "Pcd" : "Ply");
                         });

TEST(CloudWriterColors, PlyHasThemAsBytesAndTheClassAsAScalarField) {
  const test::TemporaryFolder folder;
  const LabelSet labels = oneClass();
  LabelledCloud cloud = randomCloud(1, false);
  cloud.points[0].label = 7;
  writePly(folder / "a.ply", cloud, &labels);
  const std::string bytes = test::readText(folder / "a.ply");
  EXPECT_NE(bytes.find("property uchar red\nproperty uchar green\nproperty uchar blue\n"),
            std::string::npos);
  EXPECT_NE(bytes.find("property uint label\nproperty float scalar_label\n"), std::string::npos);
  EXPECT_EQ(bytes.substr(bytes.size() - 11),
            std::string("\xFF\x80\x01", 3) + test::raw(7u) + test::raw(7.0F));
  EXPECT_EQ(readCloud(folder / "a.ply", {}, true).points[0].label, 7u);
}

}  // namespace
}  // namespace xview::io
