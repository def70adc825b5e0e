// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/cloud_files.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

using test::messageOf;
using test::raw;

/// Every test works in a folder of its own.
class CloudFiles : public ::testing::Test {
 protected:
  std::string written(const std::string& name, const std::string& bytes) {
    test::writeText(folder_ / name, bytes);
    return folder_ / name;
  }

  LabelledCloud read(const std::string& name, const std::string& bytes) {
    return readCloud(written(name, bytes));
  }

  /// What is said about the file, without the folder.
  std::string complaint(const std::string& name, const std::string& bytes) {
    const std::string path = written(name, bytes);
    const std::string error = messageOf<Error>([&] { readCloud(path); });
    return error.rfind(folder_.path() + "/", 0) == 0 ? error.substr(folder_.path().size() + 1)
                                                     : error;
  }

  test::TemporaryFolder folder_;
};

std::string pcdHeader(const std::string& label_type, const std::string& label_size,
                      const std::string& points, const std::string& data) {
  return "VERSION .7\nFIELDS x y z label\nSIZE 4 4 4 " + label_size + "\nTYPE F F F " + label_type +
         "\nWIDTH " + points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::string xyz(float x, float y, float z) { return raw(x) + raw(y) + raw(z); }

/// A binary PCD with one point and this label.
template <class T>
std::string onePoint(const char* type, T label) {
  return pcdHeader(type, std::to_string(sizeof(T)), "1", "binary") + xyz(1, 2, 3) + raw(label);
}

std::string bigEndian(std::string bytes) {
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// The body of a binary_compressed PCD: LZF with literals only, which needs no search.
std::string compressedBody(const std::string& unpacked) {
  std::string packed;
  for (std::size_t i = 0; i < unpacked.size(); i += 32) {
    const std::string run = unpacked.substr(i, 32);
    packed += static_cast<char>(run.size() - 1) + run;
  }
  return raw(static_cast<std::uint32_t>(packed.size())) +
         raw(static_cast<std::uint32_t>(unpacked.size())) + packed;
}

TEST_F(CloudFiles, LabelsOfEveryBinaryTypeAreRead) {
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint8_t{200})).points[0].label, 200u);
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint16_t{60000})).points[0].label, 60000u);
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint32_t{4000000000})).points[0].label, 4000000000u);
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint64_t{4000000000})).points[0].label, 4000000000u);
  EXPECT_EQ(read("a.pcd", onePoint("I", std::int8_t{100})).points[0].label, 100u);
  EXPECT_EQ(read("a.pcd", onePoint("I", std::int16_t{300})).points[0].label, 300u);
  EXPECT_EQ(read("a.pcd", onePoint("I", std::int32_t{70000})).points[0].label, 70000u);
  EXPECT_EQ(read("a.pcd", onePoint("I", std::int64_t{4000000000})).points[0].label, 4000000000u);
  EXPECT_EQ(read("a.pcd", onePoint("F", 40.0f)).points[0].label, 40u);
  EXPECT_EQ(read("a.pcd", onePoint("F", 4000000001.0)).points[0].label, 4000000001u);
}

TEST_F(CloudFiles, NegativeLabelsAreUnlabelled) {
  EXPECT_EQ(read("a.pcd", onePoint("I", std::int8_t{-1})).points[0].label, 0u);
  EXPECT_EQ(read("a.pcd", onePoint("I", std::int64_t{-7})).points[0].label, 0u);
  EXPECT_EQ(read("a.pcd", onePoint("F", -1.0f)).points[0].label, 0u);
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint32_t{0xFFFFFFFF})).points[0].label, 0u);
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint64_t{0xFFFFFFFFFFFFFFFF})).points[0].label, 0u);
}

TEST_F(CloudFiles, LabelsThatAreNotANumberAreUnlabelledAndCounted) {
  const LabelledCloud cloud =
      read("a.pcd", pcdHeader("F", "8", "2", "binary") + xyz(1, 2, 3) + raw(7.0) + xyz(1, 2, 4) +
                        raw(std::numeric_limits<double>::quiet_NaN()));
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points[0].label, 7u);
  EXPECT_EQ(cloud.points[1].label, 0u);
  EXPECT_EQ(read("b.pcd", onePoint("F", 71.0001F)).points[0].label, 71u) << "rounded by a program";
  EXPECT_EQ(cloud.left_out.text(), "1 of 2 points have NaN for a class and are unlabelled");
}

TEST_F(CloudFiles, AViewpointThatIsNotAppliedIsSaid) {
  const auto notesOf = [&](const std::string& viewpoint) {
    std::string bytes = onePoint("U", std::uint8_t{1});
    bytes.insert(bytes.find("POINTS"), "VIEWPOINT " + viewpoint + "\n");
    test::writeText(folder_ / "v.pcd", bytes);
    return readCloudHeader(folder_ / "v.pcd").notes;
  };
  EXPECT_TRUE(notesOf("0 0 0 1 0 0 0").empty());
  EXPECT_TRUE(notesOf("0.0 0 -0 1.0 0 0 0").empty());
  ASSERT_EQ(notesOf("1 2 3 1 0 0 0").size(), 1u);
  EXPECT_NE(notesOf("1 2 3 1 0 0 0")[0].find("VIEWPOINT is not applied"), std::string::npos);
}

TEST_F(CloudFiles, TheLargestByteIsALabel) {
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint8_t{255})).points[0].label, 255u);
  EXPECT_EQ(read("a.pcd", onePoint("U", std::uint16_t{65535})).points[0].label, 65535u);
}

TEST_F(CloudFiles, LabelsThatAreNoIdsAreErrorsThatNameThePoint) {
  const std::string expected = "a.pcd: point 0: 'label' must be a whole number below 2^32, found ";
  EXPECT_EQ(complaint("a.pcd", onePoint("F", 7.5f)), expected + "7.5");
  EXPECT_EQ(complaint("a.pcd", onePoint("F", -0.5f)), expected + "-0.5");
  EXPECT_EQ(complaint("a.pcd", onePoint("F", 1e20)), expected + "1e+20");
  EXPECT_EQ(complaint("a.pcd", onePoint("F", -std::numeric_limits<float>::infinity())),
            expected + "-inf");
  EXPECT_EQ(complaint("a.pcd", onePoint("U", std::uint64_t{1} << 32)), expected + "4294967296");
}

TEST_F(CloudFiles, TextErrorsNameTheLine) {
  const std::string header = pcdHeader("F", "4", "2", "ascii");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n1 2 3 7.5\n"),
            "a.pcd:10: 'label' must be a whole number below 2^32, found 7.5");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n1 2 3\n"),
            "a.pcd:10: too few values, expected x y z label");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7 8\n1 2 3 7\n"),
            "a.pcd:9: too many values, expected x y z label");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n\n1 2 3 7\n"),
            "a.pcd:10: an empty line, expected x y z label");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n# no\n1 2 3 7\n"),
            "a.pcd:10: '#' is not a number");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n1,5 2 3 7\n"), "a.pcd:10: '1,5' is not a number");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n1 2 3 0x7\n"), "a.pcd:10: '0x7' is not a number");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n"),
            "a.pcd:9: the file ends after 1 of 2 rows of 'point'");
  EXPECT_EQ(complaint("a.pcd", header + "1 2 3 7\n1 2 3 7\n1 2 3 7\n"),
            "a.pcd:11: more lines than the header announces");
}

TEST_F(CloudFiles, ANumberOfATextThatItsTypeCannotHoldIsAnError) {
  EXPECT_EQ(complaint("a.pcd", pcdHeader("U", "1", "1", "ascii") + "1 2 3 256\n"),
            "a.pcd:9: the value of 'label' does not fit its type, whose largest is 255");
  EXPECT_EQ(complaint("a.pcd", pcdHeader("F", "4", "1", "ascii") + "1e999 2 3 1\n"),
            "a.pcd:9: '1e999' is out of range");
}

TEST_F(CloudFiles, BlankLinesAtTheEndOfATextAreFine) {
  EXPECT_EQ(read("a.pcd", pcdHeader("U", "4", "1", "ascii") + "1 2 3 7\n\n \t \r\n").size(), 1u);
  EXPECT_EQ(read("a.pcd", pcdHeader("U", "4", "1", "ascii") + "1 2 3 7").size(), 1u);
}

TEST_F(CloudFiles, SignsAndExponentsOfATextAreUnderstood) {
  const LabelledCloud cloud =
      read("a.pcd", pcdHeader("U", "4", "1", "ascii") + " +1.5e1\t-.5 2. +7  \n");
  EXPECT_EQ(cloud.position(0), Eigen::Vector3d(15, -0.5, 2));
  EXPECT_EQ(cloud.points[0].label, 7u);
}

TEST_F(CloudFiles, PointsThatAreNotFiniteAreDroppedWithTheirLabels) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::string bytes = pcdHeader("F", "4", "3", "binary") + xyz(nan, nan, nan) + raw(nan) +
                            xyz(1, 2, 3) + raw(5.0f) + xyz(1, -infinity, 3) + raw(0.5f);
  const LabelledCloud cloud = read("a.pcd", bytes);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.points[0].label, 5u);
  EXPECT_TRUE(cloud.points.is_dense);
}

TEST_F(CloudFiles, FieldsOfSeveralValuesAndPaddingAreSkipped) {
  const std::string header =
      "FIELDS _ label x histogram z y _\nSIZE 1 2 8 4 4 4 4\nTYPE U U F F F F U\nCOUNT 3 1 1 5 1 1 "
      "2\n"
      "WIDTH 1\nHEIGHT 2\nPOINTS 2\nDATA ";
  std::string rows;
  for (int i = 0; i < 2; ++i) {
    rows += std::string(3, 'p') + raw(std::uint16_t(10 + i)) + raw(1.0 + i) + std::string(20, 'h') +
            raw(3.0f) + raw(2.0f) + std::string(8, 'q');
  }
  const LabelledCloud binary = read("a.pcd", header + "binary\n" + rows);
  const LabelledCloud text =
      read("b.pcd", header + "ascii\n0 0 0 10 1 5 5 5 5 5 3 2 9 9\n0 0 0 11 2 5 5 5 5 5 3 2 9 9\n");
  const std::string columns = std::string(6, 'p') + raw(std::uint16_t{10}) +
                              raw(std::uint16_t{11}) + raw(1.0) + raw(2.0) + std::string(40, 'h') +
                              raw(3.0f) + raw(3.0f) + raw(2.0f) + raw(2.0f) + std::string(16, 'q');
  const LabelledCloud compressed =
      read("c.pcd", header + "binary_compressed\n" + compressedBody(columns));
  for (const LabelledCloud* cloud : {&binary, &text, &compressed}) {
    ASSERT_EQ(cloud->size(), 2u);
    EXPECT_EQ(cloud->position(0), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(cloud->position(1), Eigen::Vector3d(2, 2, 3));
    EXPECT_EQ(cloud->points[0].label, 10u);
    EXPECT_EQ(cloud->points[1].label, 11u);
  }
}

TEST_F(CloudFiles, CompressedRunsThatOverlapThemselvesAreUnpacked) {
  // 12 bytes zero, by one literal and a copy from one byte back, then the label as literals.
  const std::string packed = std::string("\x00\x00\xE0\x02\x00\x03\x07\x00\x00\x00", 10);
  const std::string body = raw(std::uint32_t{10}) + raw(std::uint32_t{16}) + packed;
  const LabelledCloud cloud = read("a.pcd", pcdHeader("U", "4", "1", "binary_compressed") + body);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.position(0), Eigen::Vector3d::Zero());
  EXPECT_EQ(cloud.points[0].label, 7u);
}

TEST_F(CloudFiles, CompressedBlocksThatReachOutsideAreErrors) {
  const std::string header = pcdHeader("U", "4", "1", "binary_compressed");
  const auto withBlock = [&](const std::string& packed) {
    return complaint("a.pcd", header + raw(static_cast<std::uint32_t>(packed.size())) +
                                  raw(std::uint32_t{16}) + packed);
  };
  const std::string damaged = "a.pcd: the compressed block is damaged";
  EXPECT_EQ(withBlock(std::string("\x00\x00\x20\x05", 4)),
            damaged);  // copies from before the begin
  EXPECT_EQ(withBlock(std::string("\x00\x00\xE0\xFF\x00", 5)), damaged);  // writes behind the end
  EXPECT_EQ(withBlock(std::string("\x1F\x00\x00", 3)),
            damaged);  // literals behind the end of the input
  EXPECT_EQ(withBlock(std::string("\x00\x00\xE0", 3)), damaged);  // ends within a copy
  EXPECT_EQ(withBlock(std::string("\x00\x00\x20", 3)), damaged);
  EXPECT_EQ(withBlock(std::string("\x03\x00\x00\x00\x00", 5)),
            damaged);  // fills the output only in part
}

TEST_F(CloudFiles, DoublesKeepMillimetresFarFromTheOrigin) {
  const Eigen::Vector3d far(4649776.2254, 500000.1236, -53.0019);
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double "
      "y\n"
      "property double z\nproperty uchar label\nend_header\n";
  for (int i = 0; i < 3; ++i)
    bytes += raw(far.x() + i) + raw(far.y()) + raw(far.z()) + raw(std::uint8_t{7});
  const LabelledCloud cloud = read("a.ply", bytes);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.origin, Eigen::Vector3d(4649776, 500000, -54));
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT((cloud.position(i) - far - Eigen::Vector3d(i, 0, 0)).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST_F(CloudFiles, NearPointsBeforeTheFirstFarOneMoveWithTheOrigin) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty "
      "double z\n"
      "property int label\nend_header\n";
  const LabelledCloud cloud = read("a.ply", header + "900 1 2 1\n1100.25 1 2 1\n");
  EXPECT_EQ(cloud.origin, Eigen::Vector3d(1100, 1, 2));
  EXPECT_EQ(cloud.position(0), Eigen::Vector3d(900, 1, 2));
  EXPECT_EQ(cloud.position(1), Eigen::Vector3d(1100.25, 1, 2));
  EXPECT_EQ(read("b.ply", header + "900 1 2 1\n999 1 2 1\n").origin, Eigen::Vector3d::Zero());
}

TEST_F(CloudFiles, BinaryFloatsAreKeptBitByBit) {
  const std::string bytes =
      pcdHeader("U", "4", "1", "binary") + xyz(4649776.5f, 1e-30f, -0.1f) + raw(1u);
  const LabelledCloud cloud = read("a.pcd", bytes);
  EXPECT_EQ(cloud.origin, Eigen::Vector3d::Zero());
  EXPECT_EQ(cloud.points[0].x, 4649776.5f);
  EXPECT_EQ(cloud.points[0].y, 1e-30f);
  EXPECT_EQ(cloud.points[0].z, -0.1f);
}

TEST_F(CloudFiles, CoordinatesOutsideTheWorldAreErrors) {
  EXPECT_EQ(complaint("a.pcd", pcdHeader("U", "4", "1", "binary") + xyz(1, 1e30f, 1) + raw(1u)),
            "a.pcd: its points lie 1e+30 m from zero, expected 1e+08 m at most; are their numbers "
            "of another type, byte order or unit?");
}

TEST_F(CloudFiles, APointOfAScanThatIsFarFromTheOthersIsLeftOut) {
  std::string bytes;
  for (int i = 0; i < 200; ++i)
    bytes += i == 7 ? xyz(1e10F, 0, 0) + raw(1.F)
                    : xyz(static_cast<float>(i % 17), static_cast<float>(i % 5), 0) + raw(1.F);
  const LabelledCloud scan = readKittiScan(written("a.bin", bytes), "");
  EXPECT_EQ(scan.size(), 199u);
  EXPECT_EQ(scan.left_out.text(),
            "1 of 200 points lie more than 1 km from the middle of the others, and are left out");
}

TEST_F(CloudFiles, SamplesOfSurfacesAreNotTakenForThingsBecauseOfStrays) {
  std::string rows;
  for (int i = 0; i < 1000; ++i)
    rows += std::to_string(1000 + i) + "e6 " + std::to_string(i) + " 0 1\n";
  for (int i = 0; i < 4000; ++i)
    rows += std::to_string(0.15 * (i % 60)) + " " + std::to_string(0.15 * (i / 60)) + " 0 1\n";
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 5000\nproperty double x\nproperty double y\n"
      "property double z\nproperty uint label\nend_header\n";
  EXPECT_EQ(recogniseInput(written("a.ply", header + rows)), InputKind::cloud);
}

TEST_F(CloudFiles, SamplesWithWrongLabelsAreNotTakenForThings) {
  const auto file = [&](int count, const char* name) {
    std::string rows;
    for (int i = 0; i < count; ++i)
      rows += std::to_string(0.15 * (i % 150)) + " " + std::to_string(0.15 * (i / 150)) + " 0 " +
              std::to_string(1 + i % 3) + "\n";
    return written(name, "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
                             "\nproperty double x\nproperty double y\nproperty double z\n"
                             "property uint label\nend_header\n" +
                             rows);
  };
  EXPECT_EQ(recogniseInput(file(30000, "many.ply")), InputKind::cloud);
  const std::string few = file(3000, "few.ply");
  EXPECT_EQ(recogniseInput(few), InputKind::graph);
  InputOptions raw;
  raw.labels = "shapes";
  EXPECT_EQ(recogniseInput(few, raw), InputKind::cloud);
}

TEST_F(CloudFiles, TheThreePlyEncodingsAgree) {
  const auto header = [](const std::string& format) {
    return "ply\r\nformat " + format +
           " 1.0\r\ncomment made by hand\r\nobj_info nothing\r\nelement face 1\r\nproperty list "
           "uchar int "
           "vertex_indices\r\nelement vertex 2\r\nproperty short x\r\nproperty list uchar short "
           "extra\r\n"
           "property float y\r\nproperty double z\r\nproperty ushort class\r\nproperty int "
           "object\r\n"
           "element edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\nend_header\r\n";
  };
  const auto body = [](auto put) {
    std::string bytes =
        put(std::uint8_t{3}) + put(std::int32_t{0}) + put(std::int32_t{1}) + put(std::int32_t{1});
    bytes += put(std::int16_t{-5}) + put(std::uint8_t{2}) + put(std::int16_t{8}) +
             put(std::int16_t{9}) + put(0.5f) + put(0.25) + put(std::uint16_t{70}) +
             put(std::int32_t{9});
    bytes += put(std::int16_t{6}) + put(std::uint8_t{0}) + put(1.5f) + put(-4.0) +
             put(std::uint16_t{500}) + put(std::int32_t{-1});
    return bytes + put(std::int32_t{0}) + put(std::int32_t{1});
  };
  const std::string text = "3 0 1 1\r\n-5 2 8 9 0.5 0.25 70 9\r\n6 0 1.5 -4 500 -1\r\n0 1\r\n";
  const LabelledCloud clouds[] = {
      read("a.ply", header("ascii") + text),
      read("b.ply", header("binary_little_endian") + body([](auto value) { return raw(value); })),
      read("c.ply",
           header("binary_big_endian") + body([](auto value) { return bigEndian(raw(value)); }))};
  for (const LabelledCloud& cloud : clouds) {
    ASSERT_EQ(cloud.size(), 2u);
    EXPECT_EQ(cloud.position(0), Eigen::Vector3d(-5, 0.5, 0.25));
    EXPECT_EQ(cloud.position(1), Eigen::Vector3d(6, 1.5, -4));
    EXPECT_EQ(cloud.points[0].label, 70u);
    EXPECT_EQ(cloud.points[1].label, 500u);
    EXPECT_EQ(test::instancesOf(cloud), (std::vector<std::uint32_t>{9, 0}));
  }
}

TEST_F(CloudFiles, TheElementsAfterThePointsAreCheckedToo) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty uint label\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  const std::string vertex = xyz(1, 2, 3) + raw(7u);
  const std::string face = raw(std::uint8_t{3}) + raw(0) + raw(0) + raw(0);
  EXPECT_EQ(read("a.ply", header + vertex + face).size(), 1u);
  EXPECT_EQ(complaint("a.ply", header + vertex + face.substr(0, 9)),
            "a.ply: face 0: a list with a length that the file cannot hold");
}

TEST_F(CloudFiles, OnlyPaddingMayFollowBinaryPoints) {
  const std::string file = onePoint("U", 7u);
  EXPECT_EQ(read("a.pcd", file + std::string(4096, '\0')).size(), 1u);
  EXPECT_EQ(read("a.pcd", file + "\n").size(), 1u);
  EXPECT_EQ(
      complaint("a.pcd", file + xyz(4, 5, 6) + raw(8u)),
      "a.pcd: 16 bytes more than the header announces, from byte " + std::to_string(file.size()));
}

TEST_F(CloudFiles, TheFieldsOfTheCallerComeFirst) {
  const std::string bytes =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "property int label\nproperty double truth\nproperty uchar object\nproperty int "
      "id\nend_header\n"
      "1 2 3 4 5 6 7\n";
  const std::string path = written("a.ply", bytes);
  EXPECT_EQ(readCloud(path).points[0].label, 4u);
  EXPECT_EQ(readCloud(path).points[0].instance, 6u);
  EXPECT_EQ(readCloud(path, {"truth", "id"}).points[0].label, 5u);
  EXPECT_EQ(readCloud(path, {"truth", "id"}).points[0].instance, 7u);
  const std::string missing = messageOf<Error>([&] { readCloud(path, {"nothing", ""}); });
  EXPECT_EQ(missing, path + ": has no field 'nothing'; its fields: x y z label truth object id");
  EXPECT_NE(messageOf<Error>([&] { readCloud(path, {"object", ""}); }), "");
}

TEST_F(CloudFiles, EveryWellKnownNameIsALabel) {
  for (const std::string name :
       {"label", "class", "semantic", "sem_label", "scalar_Label", "scalar_label",
        "scalar_Classification", "classification", "scalar_Class"}) {
    const std::string bytes =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
        "float z\n"
        "property float " +
        name + "\nend_header\n1 2 3 40\n";
    EXPECT_EQ(read("a.ply", bytes).points[0].label, 40u) << name;
  }
}

TEST_F(CloudFiles, EveryWellKnownNameIsAnInstance) {
  for (const std::string name :
       {"instance", "object", "ins_label", "scalar_Instance", "scalar_Object"}) {
    const std::string bytes =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
        "float z\n"
        "property uchar label\nproperty double " +
        name + "\nend_header\n1 2 3 40 9\n";
    EXPECT_EQ(test::instancesOf(read("a.ply", bytes)), std::vector<std::uint32_t>{9}) << name;
  }
}

TEST_F(CloudFiles, WithoutLabelTheFieldsAreListed) {
  const std::string path = written("a.pcd",
                                   "FIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH "
                                   "1\nHEIGHT 1\nDATA ascii\n1 2 3 4\n");
  EXPECT_EQ(
      messageOf<Error>([&] { readCloud(path); }),
      path + ": has no label field, name one with --label-field; its fields: x y z intensity");
  EXPECT_EQ(readCloud(path, {}, false).points[0].label, 0u);
}

TEST_F(CloudFiles, TheHeaderTellsWhatReadingWouldUse) {
  const std::string path = written("a.ply",
                                   "ply\nformat ascii 1.0\nelement vertex 2\nproperty float "
                                   "x\nproperty float y\nproperty float z\n"
                                   "property int class\nproperty int object\nelement edge "
                                   "1\nproperty int vertex1\nproperty int vertex2\n"
                                   "end_header\nthe body is not looked at\n");
  const CloudHeader header = readCloudHeader(path);
  EXPECT_EQ(header.format, "PLY ascii");
  EXPECT_EQ(header.points, 2u);
  EXPECT_EQ(header.fields, (std::vector<std::string>{"x", "y", "z", "class", "object"}));
  EXPECT_EQ(header.label_field, "class");
  EXPECT_EQ(header.instance_field, "object");
  EXPECT_EQ(readCloudHeader(path, {"object", "class"}).label_field, "object");
}

TEST_F(CloudFiles, WhatIsNoFileIsNamed) {
  EXPECT_EQ(messageOf<Error>([&] { readCloud(folder_ / "none.pcd"); }),
            folder_ / "none.pcd: cannot open: No such file or directory");
  EXPECT_EQ(messageOf<Error>([&] { readCloud("/dev/null"); }), "/dev/null: is not a regular file");
  EXPECT_EQ(messageOf<Error>([&] { readCloud(folder_.path()); }),
            folder_.path() + ": is a folder, expected a file");
}

/// A text PCD of two points with a field "ring" of that type.
std::string withRing(const char* type, const char* size, const char* first, const char* second,
                     const char* count = "1") {
  return std::string("VERSION .7\nFIELDS x y z label ring\nSIZE 4 4 4 4 ") + size +
         "\nTYPE F F F U " + type + "\nCOUNT 1 1 1 1 " + count +
         "\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 7 " + first + "\n4 5 6 8 " + second +
         "\n";
}

TEST_F(CloudFiles, FieldsThatAreNotReadAreNobodysBusiness) {
  const auto expectIgnored = [&](const std::string& bytes) {
    const LabelledCloud cloud = read("a.pcd", bytes);
    ASSERT_EQ(cloud.size(), 2u);
    EXPECT_EQ(cloud.points[1].label, 8u);
  };
  expectIgnored(withRing("U", "2", "127", "5"));
  expectIgnored(withRing("F", "4", "0.5", "nan"));
  expectIgnored(withRing("U", "2", "1 2", "3 4", "2"));
  expectIgnored(withRing("I", "2", "1", "-1"));
  expectIgnored(withRing("U", "4", "1", "70000"));
}

}  // namespace
}  // namespace xview::io
