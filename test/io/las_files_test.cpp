// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "base/random.h"
#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

using test::raw;

struct LasPoint {
  std::array<std::int32_t, 3> stored{};
  std::uint8_t class_byte = 0;
};

/// A LAS file, written by hand from the tables of the specification and not by the library.
struct LasFile {
  int minor = 2, format = 0;
  std::vector<LasPoint> points;
  std::array<double, 3> scale{0.01, 0.01, 0.001}, offset{500000, 5000000, -10};
  std::string records;  ///< variable ones
  std::uint32_t record_count = 0;
  std::size_t extra_bytes = 0;

  std::string bytes() const {
    constexpr std::uint16_t kRecordBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    const std::size_t header_bytes = minor == 4 ? 375 : minor == 3 ? 235 : 227;
    const auto record = static_cast<std::uint16_t>(kRecordBytes[format] + extra_bytes);
    const auto count = static_cast<std::uint32_t>(points.size());
    std::string header(header_bytes, '\0');
    const auto put = [&](std::size_t at, const std::string& text) {
      header.replace(at, text.size(), text);
    };
    put(0, "LASF");
    put(24, raw(std::uint8_t{1}) + raw(static_cast<std::uint8_t>(minor)));
    put(94, raw(static_cast<std::uint16_t>(header_bytes)));
    put(96, raw(static_cast<std::uint32_t>(header_bytes + records.size())) + raw(record_count));
    put(104, raw(static_cast<std::uint8_t>(format)) + raw(record));
    put(107, raw(format < 6 ? count : 0U));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put(131 + 8 * axis, raw(scale[axis]));
      put(155 + 8 * axis, raw(offset[axis]));
    }
    if (minor == 4) put(247, raw(std::uint64_t{count}));
    std::string body;
    for (const LasPoint& point : points) {
      std::string one;
      for (const std::int32_t value : point.stored) one += raw(value);
      one.resize(record, '\x5A');
      one[format < 6 ? 15 : 16] = static_cast<char>(point.class_byte);
      body += one;
    }
    return header + records + body;
  }
};

std::string variableRecord(const std::string& user, std::uint16_t id, const std::string& content) {
  std::string name = user, text(32, '\0');
  name.resize(16, '\0');
  return raw(std::uint16_t{0}) + name + raw(id) + raw(static_cast<std::uint16_t>(content.size())) +
         text + content;
}

LasFile threePoints(int format) {
  LasFile file;
  file.minor = format >= 6 ? 4 : format >= 4 ? 3 : 2;
  file.format = format;
  file.points = {{{12345678, -2345, 100}, 2}, {{12345679, -2344, 101}, 6}, {{1, 2, 3}, 5}};
  return file;
}

class LasFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = folder_ / name;
    test::writeText(path, bytes);
    return path;
  }
  std::string messageOf(const std::string& bytes) const {
    const std::string path = write("bad.las", bytes);
    return test::messageOf<Error>([&] { readCloud(path, {}, false); });
  }
  test::TemporaryFolder folder_;
};

TEST_F(LasFiles, EveryPointFormatGivesPositionsAndClasses) {
  for (int format = 0; format <= 10; ++format) {
    const LasFile file = threePoints(format);
    const LabelledCloud cloud = readCloud(write("a.las", file.bytes()));
    ASSERT_EQ(cloud.size(), 3u) << format;
    EXPECT_EQ(cloud.points[0].label, 2u) << format;
    EXPECT_EQ(cloud.points[1].label, 6u) << format;
    EXPECT_EQ(cloud.points[2].label, 5u) << format;
    EXPECT_EQ(cloud.origin, Eigen::Vector3d(623456, 4999976, -10)) << format;
    for (std::size_t i = 0; i < 2; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double expected = file.points[i].stored[axis] * file.scale[axis] + file.offset[axis];
        EXPECT_NEAR(cloud.position(i)[static_cast<int>(axis)], expected, 1e-7) << format;
      }
    }
  }
}

TEST_F(LasFiles, FlagsBesideTheClassAreNoPartOfItAndExtraBytesArePassedOver) {
  LasFile old = threePoints(3);
  old.points[0].class_byte = 0xE0 | 5;
  old.extra_bytes = 7;
  const LabelledCloud cloud = readCloud(write("a.las", old.bytes()));
  EXPECT_EQ(cloud.points[0].label, 5u);
  EXPECT_EQ(cloud.points[1].label, 6u);
  EXPECT_EQ(readCloud(write("a.las", old.bytes()), {"user_data", ""}).points[0].label, 0x5Au);
  LasFile newer = threePoints(6);
  newer.points[0].class_byte = 200;  // all eight bits are class
  EXPECT_EQ(readCloud(write("a.las", newer.bytes())).points[0].label, 200u);
}

TEST_F(LasFiles, ExtraBytesThatAreNumbersWithNamesAreFields) {
  const auto described = [](std::uint8_t type, std::uint8_t options, const std::string& name) {
    std::string one(192, '\0');
    one[2] = static_cast<char>(type);
    one[3] = static_cast<char>(options);
    return one.replace(4, name.size(), name);
  };
  LasFile file = threePoints(3);
  file.extra_bytes = 5;
  file.record_count = 1;
  file.records =
      variableRecord("LASF_Spec", 4, described(9, 0, "refl") + described(1, 0, "my class"));
  const std::string las = write("a.las", file.bytes()), ply = folder_ / "a.ply";
  EXPECT_EQ(readCloud(las, {"my_class", ""}).points[0].label, 0x5Au);
  copyCloud(las, ply, Eigen::Affine3d::Identity());
  const std::vector<std::string> fields = readCloudHeader(ply).fields;
  EXPECT_EQ(std::count(fields.begin(), fields.end(), "refl"), 1);
  file.records =
      variableRecord("LASF_Spec", 4, described(9, 8, "refl") + described(1, 0, "my class"));
  EXPECT_THROW(readCloud(write("a.las", file.bytes()), {"my_class", ""}), Error)
      << "of scaled ones the bytes are no values";
  file.records = variableRecord("LASF_Spec", 4, described(9, 0, "x") + described(1, 0, "Label"));
  const LabelledCloud named = readCloud(write("b.las", file.bytes())), plain = readCloud(las);
  EXPECT_EQ(named.position(0), plain.position(0)) << "an added x is no coordinate";
  EXPECT_EQ(named.points[0].label, plain.points[0].label) << "and an added label no class";
}

TEST_F(LasFiles, AMovedFileHasAllBytesButThoseOfCoordinates) {
  for (int format = 0; format <= 10; ++format) {
    LasFile file = threePoints(format);
    file.extra_bytes = 5;
    file.points[1].class_byte = 0xE5;
    file.records = variableRecord("somebody", 7, "their own");
    file.record_count = 1;
    const std::string tail = "waveforms", bytes = file.bytes() + tail;
    const std::string before = write("a.las", bytes), after = folder_ / "b.las";
    Eigen::Affine3d moved(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
    moved.translation() << 10, 20, 1;
    copyCloud(before, after, moved);
    const LabelledCloud from = readCloud(before), to = readCloud(after);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LT((moved * from.position(i) - to.position(i)).norm(), 0.01) << format;
      EXPECT_EQ(from.points[i].label, to.points[i].label) << format;
    }
    const LabelSet las = shippedLabelSet("las");
    copyCloud(before, folder_ / "b.pcd", moved, &las);
    EXPECT_EQ(readCloud(folder_ / "b.pcd").points[1].label, to.points[1].label) << "no flags";
    EXPECT_EQ(openRecording(folder_ / "b.pcd")->labels().className(2), "ground") << format;
    copyCloud(before, folder_ / "raw.pcd", moved);
    EXPECT_TRUE(openRecording(folder_ / "raw.pcd")->labels().empty()) << format;
    std::string now = test::readText(after);
    ASSERT_EQ(now.size(), bytes.size()) << format;
    const std::size_t rows = bytes.size() - tail.size(),
                      row = file.bytes().size() - LasFile{file.minor,  format,       {}, file.scale,
                                                          file.offset, file.records, 1}
                                                      .bytes()
                                                      .size();
    for (std::size_t i = 0; i < 3; ++i)
      now.replace(rows - row + i * row / 3, 12, bytes, rows - row + i * row / 3, 12);
    now.replace(131, 96, bytes, 131, 96);
    EXPECT_EQ(now, bytes) << format;
  }
}

TEST_F(LasFiles, TheGeoreferenceIsKept) {
  LasFile file = threePoints(1);
  const auto key = [](std::uint16_t id, std::uint16_t value) {
    return raw(id) + raw(std::uint16_t{0}) + raw(std::uint16_t{1}) + raw(value);
  };
  file.records =
      variableRecord("other", 34735, "unknown") +
      variableRecord("LASF_Projection", 34735, key(1, 1) + key(2048, 4326) + key(3072, 32633)) +
      variableRecord("LASF_Projection", 34737, std::string("WGS 84 / UTM 33N|\0", 18));
  file.record_count = 3;
  EXPECT_EQ(readCloudHeader(write("a.las", file.bytes())).georeference,
            "EPSG:32633 WGS 84 / UTM 33N ");
  file.records = variableRecord("LASF_Projection", 2112, "PROJCS[\"local\"]");
  file.record_count = 1;
  EXPECT_EQ(readCloudHeader(write("a.las", file.bytes())).georeference, "PROJCS[\"local\"]");
}

/// Check fix for: a survey in feet was a place 3.28 times as large.
TEST_F(LasFiles, LengthsAreThoseThatTheFileStates) {
  constexpr double kSurveyFoot_m = 1200.0 / 3937;
  const LasFile metres = threePoints(1);
  const LabelledCloud given = readCloud(write("m.las", metres.bytes()));
  const auto key = [](std::uint16_t id, std::uint16_t value) {
    return raw(id) + raw(std::uint16_t{0}) + raw(std::uint16_t{1}) + raw(value);
  };
  const std::string in_feet =
      "PROJCS[\"NAD83\",GEOGCS[\"NAD83\",UNIT[\"degree\",0.0174532925199433]],"
      "UNIT[\"US survey foot\",0.3048006096012192]]";
  const std::string of_2019 =
      "PROJCRS[\"x\",BASEGEOGCRS[\"y\",DATUM[\"z\",ELLIPSOID[\"GRS\",6378137,298.25,"
      "LENGTHUNIT[\"metre\",1]]]],CS[Cartesian,2],AXIS[\"e\",east,LENGTHUNIT[\"US survey foot\", "
      "0.304800609601219]]]";
  struct Case {
    std::string record;
    double unit_m, unit_of_z_m;
  };
  const std::uint16_t keys = 34735, text = 2112;
  const auto as = [](std::uint16_t id, const std::string& content) {
    return variableRecord("LASF_Projection", id, content);
  };
  for (const Case& c : std::vector<Case>{
           {as(keys, key(1, 1) + key(3072, 2263) + key(3076, 9003)), kSurveyFoot_m, kSurveyFoot_m},
           {as(keys, key(1, 1) + key(3076, 9002) + key(4099, 9001)), 0.3048, 1},
           {as(keys, key(1, 1) + key(3072, 32633) + key(3076, 9001)), 1, 1},
           {as(text, in_feet), kSurveyFoot_m, kSurveyFoot_m},
           {as(text, "COMPD_CS[\"a\"," + in_feet + ",VERT_CS[\"b\",UNIT[\"metre\",1]]]"),
            kSurveyFoot_m, 1},
           {as(text, of_2019), kSurveyFoot_m, kSurveyFoot_m},
           {as(text, "COMPD_CS[\"VERTICAL x\"," + in_feet + "]"), kSurveyFoot_m, kSurveyFoot_m},
           {as(text, "PROJCS[\"x\",UNIT[\"foot\",\r\n  0.3048\r\n]]"), 0.3048, 0.3048},
           {as(text, "PROJCS[\"x\",UNIT[\"y\",inf],UNIT[\"z\",1e300]]"), 1, 1},
           {as(text, "PROJCS[\"UNIT[\"ANGLEUNIT[\"a\",7]UNIT[\"\"]UNIT[\"x\",-3]UNIT["), 1, 1}}) {
    LasFile file = metres;
    file.records = c.record;
    file.record_count = 1;
    const std::string path = write("a.las", file.bytes()), moved = folder_ / "moved.las";
    const LabelledCloud read = readCloud(path);
    copyCloud(path, moved, Eigen::Affine3d(Eigen::Translation3d(3, 4, 5)));
    const LabelledCloud again = readCloud(moved);
    for (std::size_t i = 0; i < read.size(); ++i) {
      const Eigen::Array3d unit_m(c.unit_m, c.unit_m, c.unit_of_z_m);
      const Eigen::Vector3d expected = given.position(i).array() * unit_m;
      EXPECT_LT((read.position(i) - expected).norm(), 1e-6 * expected.norm()) << c.record;
      EXPECT_LT((again.position(i) - expected - Eigen::Vector3d(3, 4, 5)).norm(), 0.02) << c.record;
    }
    EXPECT_EQ(readCloudHeader(path).notes.empty(), c.unit_m == 1) << c.record;
  }
}

/// Check fix for: degrees were taken as metres, and a place became a speck.
TEST_F(LasFiles, DegreesAreRefusedWithTheWayToMetres) {
  LasFile file = threePoints(1);
  file.record_count = 1;
  for (const std::string& records :
       {variableRecord("LASF_Projection", 34735,
                       raw(std::uint64_t{0}) + raw(std::uint16_t{2048}) + raw(std::uint16_t{0}) +
                           raw(std::uint16_t{1}) + raw(std::uint16_t{4326})),
        variableRecord("LASF_Projection", 2112, "GEOGCS[\"WGS 84\"]")}) {
    file.records = records;
    const std::string message = messageOf(file.bytes());
    EXPECT_NE(message.find("degrees"), std::string::npos) << message;
    EXPECT_NE(message.find("out_srs=EPSG:32631"), std::string::npos) << message;
  }
  std::string none = threePoints(1).bytes();
  none.replace(107, 4, raw(0U));
  EXPECT_NE(messageOf(none).find("has room for 3 of 28 bytes"), std::string::npos)
      << messageOf(none);
}

TEST_F(LasFiles, LyingHeadersAreRefusedInOneLine) {
  const std::string good = threePoints(1).bytes();
  const auto with = [&](std::size_t at, const std::string& text) {
    std::string bad = good;
    return bad.replace(at, text.size(), text);
  };
  const std::pair<std::string, const char*> cases[] = {
      {"", "expected a LAS header"},
      {with(0, "LASX"), "begins with LASF"},
      {with(25, raw(std::uint8_t{5})), "expected LAS 1.0 to 1.4, found 1.5"},
      {with(94, raw(std::uint16_t{100})), "has 227 bytes, this one says 100"},
      {with(94, raw(std::uint16_t{60000})), "expected 59689 bytes more"},
      {with(96, raw(std::uint32_t{4000000000})), "its points begin at byte 4000000000"},
      {with(96, raw(std::uint32_t{10})), "its points begin at byte 10"},
      {with(100, raw(std::uint32_t{4000000000})), "variable record 1 of 4000000000"},
      {with(104, raw(std::uint8_t{0x81})), "laszip"},
      {with(104, raw(std::uint8_t{11})), "point format from 0 to 10, found 11"},
      {with(105, raw(std::uint16_t{27})), "need 28 bytes, its header says 27"},
      {with(107, raw(std::uint32_t{4000000000})), "too short for its header"},
      {with(131, raw(0.0)), "scale of x above 0"},
      {with(139, raw(std::numeric_limits<double>::quiet_NaN())), "scale of y above 0"},
      {with(171, raw(std::numeric_limits<double>::infinity())), "finite offset of z"},
      {good.substr(0, good.size() - 1), "too short for its header"}};
  for (const auto& [bytes, expected] : cases) {
    const std::string message = messageOf(bytes);
    EXPECT_NE(message.find(expected), std::string::npos) << expected << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST_F(LasFiles, WhatNobodyClassifiedIsRaw) {
  LasFile file = threePoints(1);
  EXPECT_EQ(openRecording(write("a.las", file.bytes()))->labels().name(), "las");
  for (LasPoint& point : file.points) point.class_byte = 1;
  const std::string path = write("b.las", file.bytes());
  EXPECT_TRUE(openRecording(path)->labels().empty());
  InputOptions options;
  options.labels = "las";
  EXPECT_EQ(openRecording(path, options)->labels().name(), "las");
}

/// Check fix for: five points of a road surface made 4.8 million unclassified ones a labelled
/// cloud.
TEST_F(LasFiles, OfWhichFewPointsAreClassifiedAreRaw) {
  LasFile file = threePoints(1);
  for (LasPoint& point : file.points) point.class_byte = 6;
  file.points.resize(200, {{12345678, -2345, 100}, 2});
  const auto few = openRecording(write("few.las", file.bytes()));
  EXPECT_TRUE(few->labels().empty());
  ASSERT_FALSE(few->notes().empty());
  EXPECT_NE(few->notes()[0].find("only 1.5 % of its points"), std::string::npos) << few->notes()[0];
  for (int i = 3; i < 40; ++i) file.points[static_cast<std::size_t>(i)].class_byte = 5;
  EXPECT_EQ(openRecording(write("enough.las", file.bytes()))->labels().name(), "las");
  for (int i = 40; i < 160; ++i) file.points[static_cast<std::size_t>(i)].class_byte = 1;
  const auto most_are_not = openRecording(write("most.las", file.bytes()));
  EXPECT_TRUE(most_are_not->labels().empty());
  EXPECT_NE(most_are_not->notes().at(0).find("60 % of its points are unclassified"),
            std::string::npos);
}

TEST_F(LasFiles, DamagedOnesEndInACloudOrAnError) {
  LasFile file = threePoints(7);
  file.records = variableRecord("LASF_Projection", 2112, "LOCAL_CS[\"none\"]") +
                 variableRecord("LASF_Spec", 4, std::string(192, '\1'));
  file.record_count = 2;
  const std::string good = file.bytes();
  for (std::uint64_t i = 0; i < 2000; ++i) {
    Random random(11, i);
    std::string bytes = good;
    for (std::uint32_t flips = 1 + random.below(4); flips > 0; --flips)
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^=
          static_cast<char>(1 << random.below(8));
    const std::string path = write("a.las", bytes);
    try {
      readCloudHeader(path);
      readCloud(path, {}, false);
    } catch (const Error& problem) {
      EXPECT_EQ(std::string(problem.what()).find('\n'), std::string::npos);
    }
  }
  for (std::size_t bytes = 0; bytes < good.size(); ++bytes)
    EXPECT_NE(messageOf(good.substr(0, bytes)), "") << bytes;
}

TEST_F(LasFiles, EndingsMayBeInCapitals) {
  EXPECT_EQ(recogniseInput(write("A.LAS", threePoints(0).bytes())), InputKind::cloud);
}

TEST_F(LasFiles, KindsThatAreNotReadGetAWayThere) {
  const std::pair<const char*, const char*> cases[] = {
      {"a.laz", "pdal translate"}, {"a.copc.laz", "a.copc.las"},
      {"a.ptx", "pdal translate"}, {"a.XYZ", "CloudCompare"},
      {"a.csv", "CloudCompare"},   {"a.txt", "CloudCompare"},
      {"a.pts", "pdal"},           {"a.obj", "SAMPLE_MESH"},
      {"a.stl", "SAMPLE_MESH"},    {"a.npy", "tofile"},
      {"a.ptx", "pdal"},           {"a.gz", "gunzip"},
      {"a.zip", "unzip"},          {"a.tar", "tar xf"},
      {"a.png", "camera.yaml"}};
  for (const auto& [name, expected] : cases) {
    const std::string path = write(name, "x");
    const std::string message = test::messageOf<Error>([&] { recogniseInput(path); });
    EXPECT_NE(message.find(expected), std::string::npos) << name << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// The numbers were taken from the files by a script of their own (struct.unpack of Python).
TEST(RecordedLasFiles, HaveTheValuesOfAnotherReader) {
  XVIEW_REQUIRE_DATA(data, "las_readers");
  const LabelledCloud warsaw = readCloud(data + "/warsaw_small.las");
  ASSERT_EQ(warsaw.size(), 3000u);
  EXPECT_LT((warsaw.position(0) - Eigen::Vector3d(639944.97, 485154.44, 84.82)).norm(), 1e-5);
  EXPECT_LT((warsaw.position(2999) - Eigen::Vector3d(639930.4, 485170.88, 102.86)).norm(), 1e-5);
  EXPECT_EQ(warsaw.points[0].label, 3u);
  EXPECT_EQ(warsaw.points[2999].label, 5u);
  std::array<int, 6> counts{};
  for (const Point& point : warsaw.points) ++counts.at(point.label);
  EXPECT_EQ(counts, (std::array<int, 6>{433, 0, 1381, 257, 27, 902}));
  EXPECT_EQ(readCloud(data + "/simple.las").size(), 1065u);
  EXPECT_EQ(readCloud(data + "/Megaplot.las").size(), 81590u);
  EXPECT_EQ(readCloud(data + "/lots_of_vlr.las").size(), 1u);
  const CloudHeader odd = readCloudHeader(data + "/malformed_extrabytes.las");
  ASSERT_EQ(odd.notes.size(), 1u);
  EXPECT_EQ(odd.notes[0],
            "its header describes 2 extra bytes a point, but its points have 0; none is read");
}

}  // namespace
}  // namespace xview::io
