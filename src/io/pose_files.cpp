// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/pose_files.h"

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "layouts.h"
#include "process/atomic_file.h"

namespace xview::io {
namespace {

void requireNear(const Eigen::Vector3d& position, const InputFile& file) {
  const double away_m = position.cwiseAbs().maxCoeff();
  if (!(away_m <= kFarthest_m))
    file.failAtLine("expected a position within {:.0e} m of the origin, found {:.6g} m",
                    kFarthest_m, away_m);
}

}  // namespace

Eigen::Isometry3d poseFromTum(const double* numbers, const InputFile& file) {
  const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (std::abs(q.norm() - 1) > 0.01) {
    file.failAtLine("expected a unit quaternion, found length {:.6g}", q.norm());
  }
  const Eigen::Vector3d position(numbers[0], numbers[1], numbers[2]);
  requireNear(position, file);
  return poseOf(q.normalized().toRotationMatrix(), position);
}

Eigen::Isometry3d poseFromRows(const double* numbers, const InputFile& file) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers);
  if (!isRigid(matrix, 1e-3)) {
    const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
    const double skew = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    file.failAtLine(
        "expected a rotation in columns 1-3, found R R^T off by {:.6g} and determinant {:.6g}",
        skew, R.determinant());
  }
  requireNear(matrix.topRightCorner<3, 1>(), file);
  return poseOf(orthonormalized(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
}

std::vector<StampedPose> readPoses(const std::string& path) {
  InputFile file(path);
  std::vector<StampedPose> poses;
  std::size_t columns = 0;
  std::vector<std::string_view> words;
  while (file.readWords(words, "#")) {
    const std::vector<double> numbers = file.numbersOf(words);
    if (numbers.size() != 8 && numbers.size() != 12) {
      file.failAtLine("expected 8 numbers (TUM) or 12 (KITTI), found {}", numbers.size());
    }
    if (columns == 0) columns = numbers.size();
    if (numbers.size() != columns) {
      file.failAtLine("expected {} numbers as in the lines before, found {}", columns,
                      numbers.size());
    }
    StampedPose pose;
    if (columns == 8) {
      pose.stamp_s = numbers[0];
      pose.T_frame_sensor = poseFromTum(numbers.data() + 1, file);
    } else {
      pose.stamp_s = static_cast<double>(poses.size());
      pose.T_frame_sensor = poseFromRows(numbers.data(), file);
    }
    poses.push_back(pose);
  }
  return poses;
}

std::vector<StampedPose> posesOfFrames(const std::string& path,
                                       const std::vector<std::int64_t>& frame_numbers) {
  const std::vector<StampedPose> poses = readPoses(path);
  std::vector<StampedPose> chosen;
  for (const std::size_t line : linesOfFrames(path, "poses", poses.size(), frame_numbers)) {
    chosen.push_back(poses[line]);
  }
  return chosen;
}

std::optional<Eigen::Isometry3d> poseAt(const std::vector<StampedPose>& poses, double stamp_s,
                                        double longest_gap_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp_s,
                       [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (after == poses.end()) return std::nullopt;
  if (after->stamp_s == stamp_s) return after->T_frame_sensor;
  if (after == poses.begin()) return std::nullopt;
  const StampedPose& a = *std::prev(after);
  const StampedPose& b = *after;
  if (b.stamp_s - a.stamp_s > longest_gap_s) return std::nullopt;
  const double share = (stamp_s - a.stamp_s) / (b.stamp_s - a.stamp_s);
  return interpolated(a.T_frame_sensor, b.T_frame_sensor, share);
}

void writeTumPoses(const std::string& path, const std::vector<StampedPose>& poses) {
  std::string text;
  for (const StampedPose& pose : poses) {
    const Eigen::Vector3d t = pose.T_frame_sensor.translation();
    Eigen::Quaterniond q(pose.T_frame_sensor.linear());
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    text += fmt::format("{:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", pose.stamp_s,
                        t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  writeFile(path, text);
}

void writeMatrix(const std::string& path, const Eigen::Isometry3d& T_target_source, double scale) {
  std::string text;
  Eigen::Matrix4d m = T_target_source.matrix();
  m.topLeftCorner<3, 3>() *= scale;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", m(row, 0), m(row, 1), m(row, 2),
                        m(row, 3));
  writeFile(path, text);
}

Eigen::Affine3d readMatrix(const std::string& path) {
  InputFile file(path);
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  std::vector<std::string_view> words;
  Eigen::Index row = 0;
  for (; file.readWords(words, "#"); ++row) {
    const std::vector<double> numbers = file.numbersOf(words);
    if (numbers.size() != 4 || row >= 4)
      file.failAtLine("expected four lines of four numbers, found {} in line {}", numbers.size(),
                      row + 1);
    T.matrix().row(row) = Eigen::Map<const Eigen::RowVector4d>(numbers.data());
  }
  if (row != 4) file.fail("expected four lines of four numbers, found {}", row);
  const double scale = std::cbrt(T.linear().determinant());
  Eigen::Matrix4d rigid = T.matrix();
  rigid.topLeftCorner<3, 3>() /= scale;
  if (!(scale > 0) || !isRigid(rigid))
    file.fail(
        "expected a rotation, one scale and a translation, found something that bends shapes");
  return T;
}

}  // namespace xview::io
