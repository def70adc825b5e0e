// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "xview/types/median.h"
#include "xview/types/point.h"

namespace xview {

/// Points of single precision relative to `origin`, so that maps in UTM coordinates keep their
/// millimetres: p_frame = origin + p.
struct LabelledCloud {
  pcl::PointCloud<Point> points;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  Eigen::Vector3d position(std::size_t i) const {
    return origin + points[i].getVector3fMap().cast<double>();
  }
  /// True if the data told instances of things.
  bool hasInstances() const {
    return std::any_of(points.begin(), points.end(),
                       [](const Point& p) { return p.instance != 0; });
  }
  /// The median of what is known of the errors of its points [m]; 0 if it is empty.
  double typicalSigma() const {
    std::vector<float> sigmas;
    sigmas.reserve(size());
    for (const Point& p : points) sigmas.push_back(p.sigma);
    return sigmas.empty() ? 0.0 : medianOf(std::move(sigmas));
  }
};

}  // namespace xview
