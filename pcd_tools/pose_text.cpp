// SPDX-License-Identifier: BSD-3-Clause
#include "pose_text.h"

#include <cmath>
#include <filesystem>
#include <vector>

#include "base/pose.h"
#include "base/user_text.h"
#include "io/bag_files.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

/// The finite numbers between any of the separators; nothing if a word is none.
std::vector<double> numbersIn(const std::string& text, const char* separators) {
  std::vector<double> numbers;
  for (std::size_t end = 0;;) {
    const std::size_t begin = text.find_first_not_of(separators, end);
    if (begin == std::string::npos) return numbers;
    end = std::min(text.find_first_of(separators, begin), text.size());
    const auto number = numberFrom<double>(text.substr(begin, end - begin));
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
}

}  // namespace

std::optional<io::StampedPose> parseStampedPose(const std::string& text) {
  const std::vector<double> n = numbersIn(text, " \t\r");
  if (n.size() != 8) return std::nullopt;
  constexpr double kFarthest_m = 1e8;  // as in files of poses
  const Eigen::Vector3d position(n[1], n[2], n[3]);
  const Eigen::Quaterniond q(n[7], n[4], n[5], n[6]);
  if (!(position.cwiseAbs().maxCoeff() <= kFarthest_m) || !(std::abs(q.norm() - 1) < 0.01))
    return std::nullopt;
  return io::StampedPose{n[0], poseOf(q.normalized().toRotationMatrix(), position)};
}

std::optional<Eigen::Isometry3d> parseSensorBase(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (std::filesystem::exists(text)) {
    const Eigen::Affine3d T = io::readMatrix(text);
    if (!isRigid(T.matrix())) throw Error(text, "expected a rotation without a scale");
    return Eigen::Isometry3d(T.matrix());
  }
  const std::vector<double> n = numbersIn(text, ",");
  if (n.size() != 6)
    throw UsageError("--T_sensor_base " + text +
                     ": expected x,y,z,roll,pitch,yaw [m, deg] or a file of 4 x 4 numbers");
  constexpr double kDegree = M_PI / 180;
  return Eigen::Translation3d(n[0], n[1], n[2]) *
         Eigen::AngleAxisd(n[5] * kDegree, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(n[4] * kDegree, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(n[3] * kDegree, Eigen::Vector3d::UnitX());
}

std::optional<Eigen::Isometry3d> sensorBaseOf(const std::string& text, const std::string& path,
                                              const io::InputOptions& options) {
  if (!text.empty() || !io::isBag(path)) return parseSensorBase(text);
  const std::optional<Eigen::Isometry3d> T_base_sensor = io::mountingIn(path, options);
  return T_base_sensor ? std::optional(T_base_sensor->inverse()) : std::nullopt;
}

}  // namespace xview::tools
