// SPDX-License-Identifier: BSD-3-Clause
// Small odd and broken files, each with what must become of it.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <set>

#include "io/graph_files.h"
#include "small_files.h"
#include "support/sanitizers.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

struct BagPoint {
  double x, y, z;
  std::uint32_t label;
};

/// A file that loads with these points.
struct GoodFile {
  const char* name;
  std::vector<BagPoint> points;
};

/// A file that is refused with a message that contains these words.
struct BadFile {
  const char* name;
  const char* words;
};

const std::vector<BagPoint> kHalves = {{1.5, 2.5, 3.5, 7}, {4, 5, 6, 300}};
const std::vector<BagPoint> kWhole = {{1, 2, 3, 7}, {4, 5, 6, 8}};
const std::vector<BagPoint> kThirty = {{1, 2, 3, 7}, {4, 5, 6, 30}};
const std::vector<BagPoint> kThreeHundred = {{1, 2, 3, 7}, {4, 5, 6, 300}};
const std::vector<BagPoint> kUtm = {{500000.123, 4649776.225, 53.1, 7},
                                    {500000.456, 4649776.487, 53.2, 8}};

const GoodFile kGoodFiles[] = {
    {"a_crlf.pcd", kHalves},
    {"a_double.pcd", kUtm},
    {"a_empty.pcd", {}},
    {"a_empty00.pcd", {}},
    {"a_extra.pcd", kWhole},
    {"a_f4.pcd", kHalves},
    {"a_i4.pcd", kHalves},
    {"a_label_1.0_u4.pcd", {{1, 2, 3, 7}, {4, 5, 6, 90}}},
    {"a_label_named_class.pcd", kHalves},
    {"a_label_neg_i4.pcd", {{1, 2, 3, 0}, {4, 5, 6, 7}}},
    {"a_label_neg_u4.pcd", {{1, 2, 3, 0}, {4, 5, 6, 7}}},
    {"a_nan.pcd", {{4, 5, 6, 8}}},
    {"a_reorder.pcd", kWhole},
    {"a_u1.pcd", {{1.5, 2.5, 3.5, 7}, {4, 5, 6, 30}}},
    {"a_u2.pcd", kHalves},
    {"a_u4.pcd", kHalves},
    {"a_u8.pcd", kHalves},
    {"a_utm_float.pcd", kUtm},
    {"a_viewpoint.pcd", kHalves},
    {"b_crlf_hdr.pcd", kWhole},
    {"b_double.pcd", {{500000.123, 4649776.225, 53.1, 7}}},
    {"b_f4.pcd", kThreeHundred},
    {"b_nan.pcd", {{4, 5, 6, 300}}},
    {"b_u2.pcd", kThreeHundred},
    {"b_u4.pcd", kThreeHundred},
    {"empty_out.pcd", {}},
    {"h_no_points.pcd", {{1, 2, 3, 4}, {5, 6, 7, 8}}},
    {"h_points_only.pcd", {{1, 2, 3, 4}, {5, 6, 7, 8}}},
    {"h_size_after_count.pcd", {{1, 2, 3, 4}, {5, 6, 7, 8}}},
    {"p_a_char.ply", kThirty},
    {"p_a_double.ply", kUtm},
    {"p_a_float.ply", kThirty},
    {"p_a_int.ply", kThirty},
    {"p_a_rgb.ply", kThirty},
    {"p_a_scalar_Label.ply", kThirty},
    {"p_a_short.ply", kThirty},
    {"p_a_uchar.ply", kThirty},
    {"p_a_uint.ply", kThirty},
    {"p_a_ushort.ply", kThirty},
    {"p_b_bigendian.ply", kThirty},
    {"p_b_float.ply", kThirty},
    {"p_b_int.ply", kThirty},
    {"p_b_uchar.ply", kThirty},
    {"p_b_uint.ply", kThirty},
    {"p_b_ushort.ply", kThirty},
    {"p_crlf.ply", kWhole},
    {"p_empty.ply", {}},
    {"p_list.ply", kWhole},
    {"p_mixed.ply", kWhole},
    {"p_nan.ply", {{4, 5, 6, 8}}},
    {"p_obj_info.ply", kWhole},
};

const BadFile kBadFiles[] = {
    {"a_bad_data.pcd", ":11: DATA must be ascii, binary or binary_compressed, found 'foo'"},
    {"a_bad_type.pcd", "found 'Q 4'"},
    {"a_comma_locale.pcd", ":12: '1,5' is not a number"},
    {"a_dup_label.pcd", "'label' appears twice"},
    {"a_dup_x.pcd", "'x' appears twice"},
    {"a_fields_mismatch.pcd", ":4: SIZE has 3 values"},
    {"a_garbage.pcd", ":13: 'foo' is not a number"},
    {"a_huge_count.pcd", "'label' must be one number per point"},
    {"a_huge_width.pcd", "is too short for its header: expected 4000000000 rows"},
    {"a_label_missing.pcd", "has no label field"},
    {"a_more_lines.pcd", ":13: more lines"},
    {"a_neg_size.pcd", "found 'U -4'"},
    {"a_neg_width.pcd", ":7: WIDTH must be a whole number >= 0, found '-2'"},
    {"a_no_data.pcd", "ends within the header"},
    {"a_no_size.pcd", "no SIZE entry"},
    {"a_points_ne_wh.pcd", "contradicts itself: WIDTH 2 x HEIGHT 1, POINTS 3"},
    {"a_short_line.pcd", ":13: too few values, expected x y z label"},
    {"a_size3.pcd", "found 'U 3'"},
    {"a_trunc.pcd", ":13: the file ends after 2 of 5"},
    {"a_u1_overflow.pcd", ":13: the value of 'label' does not fit its type"},
    {"a_wh_overflow.pcd", "is too short for its header"},
    {"a_zero_count.pcd", "COUNT of 'label' is 0"},
    {"b_200M_width.pcd", "need at least 3200000000 bytes, found 64"},
    {"b_huge_width.pcd", "need at least 64000000000 bytes"},
    {"b_trunc.pcd", "need at least 80 bytes, found 32"},
    {"b_wh_overflow.pcd", "is too short for its header"},
    {"c_garbage.pcd", "compressed block is damaged"},
    {"c_hugecomp.pcd", "compressed block has 4294967280 bytes, but only 20"},
    {"c_hugeunc.pcd", "unpacks to 4294967280 bytes, expected 2 points"},
    {"c_trunc8.pcd", "ends before the sizes"},
    {"c_zero.pcd", "unpacks to 0 bytes, expected 2 points of 16 bytes"},
    {"crash_crash_sig_11_1.pcd", "ends within the header"},
    {"crash_crash_sig_11_2.pcd", "ends within the header"},
    {"crash_crash_sig_11_3.pcd", ":2: expected an entry of a PCD header, found 'VE'"},
    {"crash_crash_sig_11_4.pcd", ":2: expected an entry of a PCD header, found 'VE'"},
    {"h_count_neg.pcd", ":6: COUNT must be a whole number"},
    {"h_data_first.pcd", "no FIELDS entry"},
    {"h_fields_none.pcd", ":2: FIELDS has no value"},
    {"h_size_abc.pcd", "found 'U q'"},
    {"h_size_first.pcd", "no TYPE entry"},
    {"h_width_abc.pcd", ":7: WIDTH must be a whole number"},
    {"h_ws.pcd", ":13: an empty line"},
    {"m_200M.ply", "expected 200000000 rows of 'vertex'"},
    {"m_200M_ascii.pcd", "expected 200000000 rows of 'point'"},
    {"m_200M_bin.pcd", "expected 200000000 rows of 'point'"},
    {"p_a_trunc.ply", ":10: the file ends after 2 of 5"},
    {"p_b_trunc.ply", "need at least 80 bytes, found 18"},
    {"p_huge.ply", "expected 4000000000 rows"},
    {"p_huge_b.ply", "need at least 64000000000 bytes"},
    {"p_hugelist.ply", "has no label field"},
    {"p_neg.ply", ":3: the count of an element must be a whole number >= 0, found '-1'"},
    {"p_noxyz.ply", "has no field x"},
    {"text.pcd", ":1: expected an entry of a PCD header, found 'hello'"},
    {"text.ply", ":1: is no PLY file"},
    {"x.pcd", "WIDTH 5 x HEIGHT 1, POINTS 1"},
    {"zero.pcd", "the file is empty"},
    {"zero.ply", "the file is empty"},
};

/// Files of other projects' test suites, none with a label: how many finite points they have.
struct VariantFile {
  const char* name;
  std::size_t points;
};

const VariantFile kGoodVariants[] = {
    {"pcl_test__bun0.pcd", 397},
    {"pcl_test__bun02.pcd", 217},
    {"pcl_test__bun4.pcd", 361},
    {"pcl_test__canny.pcd", 65536},
    {"pcl_test__closing.pcd", 65536},
    {"pcl_test__colored_cloud.pcd", 1000},
    {"pcl_test__cube.ply", 24},
    {"pcl_test__curve3d.pcd", 110},
    {"pcl_test__dilation.pcd", 65536},
    {"pcl_test__erosion.pcd", 65536},
    {"pcl_test__gauss_smooth.pcd", 65536},
    {"pcl_test__ism_train.pcd", 3400},
    {"pcl_test__lena.pcd", 65536},
    {"pcl_test__milk_color.pcd", 13704},
    {"pcl_test__noisy_slice_displaced.pcd", 3782},
    {"pcl_test__office1_keypoints.pcd", 1318},
    {"pcl_test__opening.pcd", 65536},
    {"pcl_test__pcl_logo.pcd", 12909},
    {"pcl_test__sac_plane_test.pcd", 3283},
    {"pdal_variants__issue_2421.ply", 1},
    {"pdal_variants__mesh_fixed.ply", 4},
    {"pdal_variants__simple_text.ply", 3},
    {"pdal_variants__text_extradim.ply", 1},
    {"pdal_variants__utm17_tab.pcd", 10},
    {"pyntcloud_assets__diamond_ascii.ply", 6},
    {"pyntcloud_assets__diamond_with_bool.ply", 6},
    {"pyntcloud_assets__voxelgrid.ply", 6},
    {"tinyply_assets__icosahedron.ply", 12},
    {"uensalo_kinect_ade__out_apparel.ply", 33979},
};

const BadFile kBadVariants[] = {
    {"mmdet3d_samples__000000.bin", "ends in .pcd, .ply, .las"},
    {"pcl_test__brisk_descriptors_gt.pcd", "has no field x; its fields: brisk_scale"},
    {"pcl_test__stereo_right.pcd", "has no field x; its fields: rgba"},
    {"pdal_variants__no_vertex.ply", "has no element vertex"},
    {"pdal_variants__utm17_comma.pcd", ":11: '289814.15,4320978.61,170.76' is not a number"},
};

/// One line, path first, and these words.
void expectError(const std::string& path, const std::string& words, bool require_label) {
  const std::string error = test::messageOf<Error>([&] { readCloud(path, {}, require_label); });
  EXPECT_EQ(error.rfind(path, 0), 0u) << error;
  EXPECT_NE(error.find(words), std::string::npos) << error << "\nexpected: " << words;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

TEST(OddCloudFiles, ValidOnesLoadWithTheirLabels) {
  XVIEW_REQUIRE_DATA(data, "bad_files");
  for (const GoodFile& file : kGoodFiles) {
    SCOPED_TRACE(file.name);
    LabelledCloud cloud;
    ASSERT_NO_THROW(cloud = readCloud(data + "/" + file.name));
    ASSERT_EQ(cloud.size(), file.points.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const BagPoint& expected = file.points[i];
      EXPECT_LT((cloud.position(i) - Eigen::Vector3d(expected.x, expected.y, expected.z)).norm(),
                1e-4);
      EXPECT_EQ(cloud.points[i].label, expected.label);
    }
    EXPECT_EQ(readCloudHeader(data + "/" + file.name).label_field.empty(), false);
  }
}

TEST(OddCloudFiles, BrokenOnesAreRefusedInOneLine) {
  XVIEW_REQUIRE_DATA(data, "bad_files");
  for (const BadFile& file : kBadFiles) {
    SCOPED_TRACE(file.name);
    expectError(data + "/" + file.name, file.words, true);
  }
}

TEST(OddCloudFiles, APackedCloudOfPclLoads) {
  XVIEW_REQUIRE_DATA(data, "bad_files");
  const LabelledCloud cloud = readCloud(data + "/c_ok.pcd");
  ASSERT_EQ(cloud.size(), 20u);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_EQ(cloud.position(i), Eigen::Vector3d(static_cast<double>(i), 1, 2));
    EXPECT_EQ(cloud.points[i].label, i % 3);
  }
}

TEST(OddCloudFiles, AListThatLiesAboutItsLengthIsRefused) {
  XVIEW_REQUIRE_DATA(data, "bad_files");
  expectError(data + "/p_hugelist.ply", "vertex 0: a list with a length that the file cannot hold",
              false);
}

TEST(OddCloudFiles, VariantsOfOtherProgramsLoadWithoutLabel) {
  XVIEW_REQUIRE_DATA(data, "reader_variants");
  for (const VariantFile& file : kGoodVariants) {
    SCOPED_TRACE(file.name);
    const std::string path = data + "/" + file.name;
    LabelledCloud cloud;
    ASSERT_NO_THROW(cloud = readCloud(path, {}, false));
    EXPECT_EQ(cloud.size(), file.points);
    expectError(path, "has no label field", true);
  }
  for (const BadFile& file : kBadVariants) {
    SCOPED_TRACE(file.name);
    expectError(data + "/" + file.name, file.words, false);
  }
}

TEST(OddCloudFiles, TheTablesKnowEveryFile) {
  XVIEW_REQUIRE_DATA(data, "");
  std::set<std::string> known = {"c_ok.pcd"};
  for (const GoodFile& file : kGoodFiles) known.insert(file.name);
  for (const BadFile& file : kBadFiles) known.insert(file.name);
  for (const VariantFile& file : kGoodVariants) known.insert(file.name);
  for (const BadFile& file : kBadVariants) known.insert(file.name);
  for (const char* folder : {"bad_files", "reader_variants"}) {
    for (const auto& entry : fs::directory_iterator(data + folder)) {
      EXPECT_EQ(known.count(entry.path().filename().string()), 1u) << entry.path();
    }
  }
}

TEST(OddCloudFiles, OrganizedPackedCloudsWithHolesLoad) {
  XVIEW_REQUIRE_DATA(data, "mosd");
  const LabelledCloud cloud = readCloud(data + "/learn0.pcd");
  EXPECT_EQ(cloud.size(), 182292u);
  for (const auto& point : cloud.points) ASSERT_NE(point.label, 0u);  // 0 marks holes there
}

/// Headers that demand gigabytes, and files that are gigabytes of nothing (sparse: they take no
/// space).
std::vector<std::string> makeBombs(const test::TemporaryFolder& folder) {
  const auto pcd = [](const std::string& points, const std::string& data) {
    return "FIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nWIDTH " + points + "\nHEIGHT 1\nDATA " +
           data + "\n";
  };
  const std::string ply_header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty uint label\nproperty list uint double rest\nend_header\n";
  struct Bomb {
    std::string name, bytes;
    std::uint64_t size;  ///< the file is extended to it
  };
  const Bomb bombs[] = {
      {"ascii.pcd", pcd("1000000000", "ascii") + "1 2 3 4\n", 0},
      {"binary.pcd", pcd("1000000000", "binary"), 0},
      {"packed.pcd",
       pcd("250000000", "binary_compressed") + test::raw(8u) + test::raw(4000000000u) + "12345678",
       0},
      {"packed_zeros.pcd",
       pcd("250000000", "binary_compressed") + test::raw(3000000000u) + test::raw(4000000000u),
       std::uint64_t{4} << 30},
      {"count.pcd",
       "FIELDS x y z label rest\nSIZE 4 4 4 4 8\nTYPE F F F U F\nCOUNT 1 1 1 1 "
       "2000000000000000000\n"
       "WIDTH 1\nHEIGHT 1\nDATA binary\n",
       0},
      {"sparse.pcd", pcd("1250000000", "binary"), 20000000100},
      {"sparse_ascii.pcd", pcd("1000000000", "ascii"), std::uint64_t{8} << 30},
      {"sparse_header.pcd", "# ", std::uint64_t{8} << 30},
      {"sparse_tail.ply", ply_header + std::string(20, '\0'), std::uint64_t{8} << 30},
      {"list.ply", ply_header + std::string(16, '\0') + test::raw(0xFFFFFFF0u),
       std::uint64_t{1} << 30},
      {"edges.ply",
       "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty "
       "float z\n"
       "property int label\nelement edge 4000000000\nproperty int vertex1\nproperty int "
       "vertex2\nend_header\n",
       0},
  };
  std::vector<std::string> paths;
  for (const Bomb& bomb : bombs) {
    paths.push_back(folder / bomb.name);
    test::writeText(paths.back(), bomb.bytes);
    if (bomb.size > 0) fs::resize_file(paths.back(), bomb.size);
  }
  return paths;
}

/// Reads all files in a process with 2.5 GB of address space and 60 s; the exit code is the number
/// of files that did not end in a cloud or an Error.
int readWithLittleMemory(const std::vector<std::string>& paths) {
  const rlimit memory = {2500u << 20, 2500u << 20};
  if (setrlimit(RLIMIT_AS, &memory) != 0) return 100;
  alarm(60);
  int failures = 0;
  for (const std::string& path : paths) {
    try {
      readCloud(path, {}, false);
    } catch (const Error&) {
    } catch (const std::exception& other) {
      std::cerr << path << ": " << other.what() << std::endl;
      ++failures;
    }
    try {
      readGraph(path);
    } catch (const Error&) {
    } catch (const std::exception& other) {
      std::cerr << path << ": " << other.what() << std::endl;
      ++failures;
    }
  }
  return failures;
}

TEST(OddCloudFiles, NoFileTakesMoreMemoryThanItHasBytes) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer needs terabytes of address space";
  const test::TemporaryFolder folder;
  std::vector<std::string> paths = makeBombs(folder);
  const std::string data = test::dataFolder();
  if (!data.empty()) {
    for (const auto& entry : fs::directory_iterator(data + "/bad_files"))
      paths.push_back(entry.path().string());
  }
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(readWithLittleMemory(paths));
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace xview::io
