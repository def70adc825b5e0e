// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/pose_prior.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "xview/types/error.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

std::vector<double> parseNumbers(const std::string& key, const std::string& text, std::size_t count, const char* meaning) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) {
    try {
      std::size_t used = 0;
      numbers.push_back(std::stod(part, &used));
      if (used != part.size()) throw std::invalid_argument(part);
    } catch (const std::exception&) {
      throw UsageError(key + " = " + text + ", '" + part + "' is not a number");
    }
  }
  if (numbers.size() != count) throw UsageError(key + " = " + text + ", must be " + meaning);
  return numbers;
}

/// Where the sensor looks in the plane: cameras along z, everything else along x.
double headingOf(const Eigen::Matrix3d& R, Sensor sensor) {
  const Eigen::Vector3d forward = R * (sensor == Sensor::camera ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX());
  return std::atan2(forward.y(), forward.x());
}

}  // namespace

PlacePrior parsePrior(const PriorOptions& options) {
  PlacePrior prior;
  if (!options.near.empty()) {
    const auto n = parseNumbers("prior.near", options.near, 3, "x,y,radius");
    if (!(n[2] > 0)) throw UsageError("prior.near = " + options.near + ", the radius must be positive");
    prior.near = PlacePrior::Circle{n[0], n[1], n[2]};
  }
  if (!options.yaw.empty()) {
    const auto n = parseNumbers("prior.yaw", options.yaw, 2, "heading,tolerance");
    if (!(n[1] > 0)) throw UsageError("prior.yaw = " + options.yaw + ", the tolerance must be positive");
    prior.heading = PlacePrior::Heading{n[0] * M_PI / 180, n[1] * M_PI / 180};
  }
  return prior;
}

PlacePrior priorOfPoint(const PlacePrior& prior, const Query& query, const Eigen::Vector2d& point) {
  PlacePrior result = prior;
  if (query.poses.empty()) return result;
  const Eigen::Isometry3d& last = query.poses.back();
  if (result.near) result.near->radius += (last.translation().head<2>() - point).norm();
  if (result.heading) result.heading->yaw = angleDifference(prior.heading->yaw, headingOf(last.linear(), query.sensor));
  return result;
}

bool satisfies(const PlacePrior& prior, const Query& query, const Eigen::Isometry3d& T_map_query) {
  if (query.poses.empty()) return true;
  const Eigen::Isometry3d pose = T_map_query * query.poses.back();
  if (prior.near && std::hypot(pose.translation().x() - prior.near->x, pose.translation().y() - prior.near->y) > prior.near->radius) {
    return false;
  }
  return !prior.heading ||
         std::abs(angleDifference(headingOf(pose.linear(), query.sensor), prior.heading->yaw)) <= prior.heading->tolerance;
}

}  // namespace xview
