// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/matrix_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/test_data.h"
#include "xview/types/error.h"

namespace xview {
namespace {

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
  try {
    writeMatrix(folder / "no/T.txt", somewhere());
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no/T.txt"), std::string::npos) << e.what();
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace xview
