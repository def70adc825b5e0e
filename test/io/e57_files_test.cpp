// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "support/e57.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

using test::e57Real;
using test::e57Whole;

const std::vector<test::E57Column> kDoubles = {e57Real("cartesianX", 64), e57Real("cartesianY", 64),
                                               e57Real("cartesianZ", 64)};

/// Points whose numbers are packed into 19, 32 and 64 bits, with a class of 5 bits, a constant and
/// a colour that is passed over.
test::E57Points mixed(std::size_t points, std::size_t packets) {
  test::E57Points scan;
  scan.columns = {e57Whole("cartesianX", -250000, 250000, "scale=\"1e-3\" offset=\"10\""),
                  e57Real("cartesianY", 32),
                  e57Whole("colorRed", 0, 255),
                  e57Real("cartesianZ", 64),
                  e57Whole("label", 0, 30),
                  e57Whole("instance", 4, 4)};
  Random random(5);
  for (std::size_t i = 0; i < points; ++i)
    scan.rows.push_back({static_cast<double>(random.below(500000)) - 250000,
                         random.uniform(-50, 50), static_cast<double>(random.below(256)),
                         random.uniform(-5, 5), static_cast<double>(random.below(31)), 4});
  scan.packets = packets;
  scan.has_index = packets > 1;
  return scan;
}

class E57Files : public ::testing::Test {
 protected:
  std::string write(const std::string& bytes) const {
    const std::string path = folder_ / "scan.e57";
    test::writeText(path, bytes);
    return path;
  }
  LabelledCloud read(const std::vector<test::E57Points>& scans) const {
    return readCloud(write(test::e57Paged(test::e57Content(scans))), {}, false);
  }
  std::string messageOf(const std::string& bytes) const {
    const std::string path = write(bytes);
    const std::string message = test::messageOf<Error>([&] { readCloud(path, {}, false); });
    EXPECT_TRUE(message.empty() || message.find(path + ": ") == 0) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  std::string messageOfLie(const std::string& from, const std::string& to) const {
    return messageOf(test::e57Paged(test::e57Content({mixed(50, 2)}, from, to)));
  }
  test::TemporaryFolder folder_;
};

TEST_F(E57Files, HoldNumbersOfAnyWidthInAnyNumberOfPackets) {
  for (const std::size_t packets : {1U, 2U, 3U, 7U, 64U}) {
    const test::E57Points scan = mixed(1000, packets);
    const LabelledCloud cloud = read({scan});
    ASSERT_EQ(cloud.size(), 1000u);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const std::vector<double>& row = scan.rows[i];
      const Eigen::Vector3d expected(10 + 1e-3 * row[0], row[1], row[3]);
      ASSERT_LT((cloud.position(i) - expected).norm(), 1e-4) << i << " of " << packets;
      ASSERT_EQ(cloud.points[i].label, static_cast<std::uint32_t>(row[4]));
      ASSERT_EQ(cloud.points[i].instance, 4u);
    }
  }
}

TEST_F(E57Files, ScansLieWhereTheirPosesPutThem) {
  test::E57Points first, second;
  first.columns = second.columns = kDoubles;
  first.rows = {{1, 2, 3}};
  second.rows = {{1, 0, 0}, {0, 1, 0}};
  second.pose =
      "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">0.70710678118654757"
      "</w><x type=\"Float\"/><y type=\"Float\">0</y><z type=\"Float\">0.70710678118654757</z>"
      "</rotation><translation type=\"Structure\"><x type=\"Float\">100</x><y type=\"Float\"/>"
      "<z type=\"Float\">-2</z></translation></pose>";
  const LabelledCloud cloud = read({first, second});
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_LT((cloud.position(0) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-6);
  EXPECT_LT((cloud.position(1) - Eigen::Vector3d(100, 1, -2)).norm(), 1e-5);
  EXPECT_LT((cloud.position(2) - Eigen::Vector3d(99, 0, -2)).norm(), 1e-5);
}

TEST_F(E57Files, HaveSetupsThatAreReadAloneToo) {
  const test::E57Points first = mixed(30, 1), second = mixed(20, 1);
  const std::string path = write(test::e57Paged(test::e57Content({first, second})));
  EXPECT_EQ(setupsOf(path), (std::vector<std::string>{path + "#1", path + "#2"}));
  EXPECT_EQ(readCloud(path, {}, false).size(), 50U);
  EXPECT_EQ(readCloud(path + "#1", {}, false).size(), 30U);
  EXPECT_EQ(readCloudHeader(path + "#2").points, 20U);
  EXPECT_EQ(openRecording(path + "#2")->read(0).cloud.size(), 20U);
  EXPECT_EQ(test::messageOf<Error>([&] { readCloud(path + "#3", {}, false); }),
            path + "#3: there is no such setup: it has 2 of them");
  EXPECT_NE(test::messageOf<Error>([&] { readCloud(path + "#0", {}, false); }), "");
  ASSERT_EQ(readCloudHeader(path).notes.size(), 1U);
  EXPECT_EQ(readCloudHeader(path).notes[0].rfind("all 2 setups have the same pose; ", 0), 0U);
  EXPECT_TRUE(readCloudHeader(path + "#2").notes.empty());
  const std::string one = write(test::e57Paged(test::e57Content({first})));
  EXPECT_EQ(setupsOf(one), std::vector<std::string>{one});
}

TEST_F(E57Files, PointsThatWereNotMeasuredAreDropped) {
  test::E57Points scan;
  scan.columns = kDoubles;
  scan.columns.push_back(e57Whole("cartesianInvalidState", 0, 2));
  scan.rows = {{1, 2, 3, 0}, {4, 5, 6, 1}, {7, 8, 9, 2}, {10, 11, 12, 0}};
  const LabelledCloud cloud = read({scan});
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.position(1), Eigen::Vector3d(10, 11, 12));
}

TEST_F(E57Files, RangesAndAnglesBecomePoints) {
  test::E57Points scan;
  scan.columns = {e57Real("sphericalRange", 64), e57Real("sphericalAzimuth", 64),
                  e57Real("sphericalElevation", 64)};
  scan.rows = {{10, M_PI / 2, 0}, {10, 0, M_PI / 6}};
  const LabelledCloud cloud = read({scan});
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_LT((cloud.position(0) - Eigen::Vector3d(0, 10, 0)).norm(), 1e-5);
  EXPECT_LT((cloud.position(1) - Eigen::Vector3d(10 * std::cos(M_PI / 6), 0, 5)).norm(), 1e-5);
}

TEST_F(E57Files, KeepMillimetresFarFromTheOrigin) {
  test::E57Points scan;
  scan.columns = kDoubles;
  scan.rows = {{500000.123, 5000000.456, 1}, {500010.789, 5000010.012, 2}};
  const LabelledCloud cloud = read({scan});
  EXPECT_LT((cloud.position(1) - Eigen::Vector3d(500010.789, 5000010.012, 2)).norm(), 1e-5);
}

TEST_F(E57Files, AreDescribedByTheirHeader) {
  const std::string path = write(test::e57Paged(test::e57Content({mixed(50, 1), mixed(20, 1)})));
  const CloudHeader header = readCloudHeader(path);
  EXPECT_EQ(header.format, "E57, 2 scans");
  EXPECT_EQ(header.points, 70u);
  EXPECT_EQ(header.label_field, "label");
  EXPECT_EQ(header.georeference, "EPSG:25832");
  EXPECT_EQ(header.fields,
            (std::vector<std::string>{"x", "y", "z", "colorRed", "label", "instance"}));
  EXPECT_EQ(recogniseInput(path), InputKind::cloud);
  EXPECT_EQ(openRecording(path)->read(0).cloud.size(), 70u);
}

TEST_F(E57Files, ThatAreEmptyAreRead) {
  test::E57Points scan;
  scan.columns = kDoubles;
  EXPECT_EQ(read({scan}).size(), 0u);
}

TEST_F(E57Files, WithOneWrongByteAreRefused) {
  const std::string good = test::e57Paged(test::e57Content({mixed(300, 2)}));
  EXPECT_EQ(messageOf(good), "");
  ASSERT_GT(good.size(), 6000u);
  for (std::size_t at = 0; at < good.size(); at += 37) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 4);
    EXPECT_NE(messageOf(bad), "") << at;
  }
  std::string bad = good;
  bad[1500] = static_cast<char>(bad[1500] ^ 1);
  EXPECT_NE(messageOf(bad).find("the page from byte 1024 on is damaged: its CRC-32C"),
            std::string::npos);
}

TEST_F(E57Files, ThatWereCutOffAreRefused) {
  const std::string good = test::e57Paged(test::e57Content({mixed(300, 2)}));
  for (std::size_t bytes = 0; bytes < good.size(); bytes += 64) {
    const std::string message = messageOf(good.substr(0, bytes));
    EXPECT_NE(message.find(bytes < 48 ? "expected an E57 header" : "was it cut off?"),
              std::string::npos)
        << bytes << message;
  }
}

TEST_F(E57Files, ThatLieAreRefused) {
  const struct {
    const char *from, *to, *expected;
  } kLies[] = {
      {"recordCount=\"50\"", "recordCount=\"51\"", "a scan of 51 points ends after 50"},
      {"recordCount=\"50\"", "recordCount=\"50000000000\"", "is too short for its XML"},
      {"recordCount=\"50\"", "recordCount=\"-1\"", "'-1' for 'points recordCount'"},
      {"fileOffset=\"48\"", "fileOffset=\"99999999\"", "points to byte 99999999"},
      {"fileOffset=\"48\"", "fileOffset=\"1022\"", "points to byte 1022"},
      {"fileOffset=\"48\"", "fileOffset=\"56\"", "no section of points"},
      {"cartesianX", "cartesianW", "without sphericalRange"},
      {"<colorRed type=\"Integer\"", "<colorRed type=\"String\"", "'colorRed' of type 'String'"},
      {"minimum=\"0\" maximum=\"255\"", "minimum=\"0\" maximum=\"-5\"", "above the maximum"},
      {"<colorRed type=\"Integer\" minimum=\"0\" maximum=\"255\" />", "", "has 6 streams"},
      {"scale=\"1e-3\"", "scale=\"nan\"", "'nan' for 'cartesianX scale'"},
      {"<data3D", "<data4D", "of its XML: mismatched tag"},
      {"<e57Root", "<!DOCTYPE e57Root [<!ENTITY a \"b\">]><e57Root", "a document type"},
      {"</e57Root>", "", "of its XML: no element found"}};
  for (const auto& lie : kLies) {
    const std::string message = messageOfLie(lie.from, lie.to);
    EXPECT_NE(message.find(lie.expected), std::string::npos) << lie.to << ": " << message;
  }
}

TEST_F(E57Files, OfOneElementWithAMillionAttributesAreRefused) {
  const auto withAttributes = [](int count) {
    std::string tag = "<any ";
    for (int i = 0; i < count; ++i) tag += "b" + std::to_string(i) + "=\">\" ";
    return tag + "/><data3D";
  };
  EXPECT_NE(messageOfLie("<data3D", withAttributes(1000000)).find("a tag of more than"),
            std::string::npos);
  EXPECT_EQ(messageOfLie("<data3D", withAttributes(1000)), "");
  // Texts may be of any length.
  EXPECT_EQ(messageOfLie("<data3D", "<any><![CDATA[" + std::string(1 << 20, '<') + "]]>" +
                                        std::string(1 << 20, 'a') + "</any><data3D"),
            "");
}

TEST_F(E57Files, WhoseScansHaveNotTheSameClassesAreRefused) {
  test::E57Points other;
  other.columns = kDoubles;
  other.rows = {{1, 2, 3}};
  EXPECT_NE(messageOf(test::e57Paged(test::e57Content({mixed(5, 1), other})))
                .find("its scans differ: one has no field 'label'"),
            std::string::npos);
}

}  // namespace
}  // namespace xview::io
