// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <string>

namespace xview::tools {

using Json = nlohmann::ordered_json;

template <int N>
Json rowMajor(const Eigen::Matrix<double, N, N>& matrix) {
  Json numbers = Json::array();
  for (int row = 0; row < N; ++row) {
    for (int column = 0; column < N; ++column) numbers.push_back(matrix(row, column));
  }
  return numbers;
}

/// The keys "position" and "quaternion".
Json poseJson(const Eigen::Isometry3d& T);
/// On one line; paths need not be UTF-8.
std::string toText(const Json& json);

}  // namespace xview::tools
