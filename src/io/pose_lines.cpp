// SPDX-License-Identifier: BSD-3-Clause
#include "pose_lines.h"

#include <cmath>
#include <cstdio>
#include <string>

#include "number_words.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

std::string shortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

std::vector<double> numbersOf(const std::vector<std::string_view>& words, const InputFile& file) {
  std::vector<double> numbers;
  numbers.reserve(words.size());
  for (const std::string_view word : words) {
    const std::optional<double> number = asNumber(word);
    if (!number || !std::isfinite(*number)) {
      file.failAtLine("expected a finite number, found " + quoted(word));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

Eigen::Isometry3d poseFromTum(const double* numbers, const InputFile& file) {
  const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (std::abs(q.norm() - 1) > 0.01) {
    file.failAtLine("expected a unit quaternion, found length " + shortNumber(q.norm()));
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() << numbers[0], numbers[1], numbers[2];
  return T;
}

Eigen::Isometry3d poseFromRows(const double* numbers, const InputFile& file) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers);
  if (!isRigid(matrix, 1e-3)) {
    const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
    const double skew = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    file.failAtLine("expected a rotation in columns 1-3, found R R^T off by " + shortNumber(skew) +
                    " and determinant " + shortNumber(R.determinant()));
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = orthonormalized(matrix.topLeftCorner<3, 3>());
  T.translation() = matrix.topRightCorner<3, 1>();
  return T;
}

}  // namespace xview
