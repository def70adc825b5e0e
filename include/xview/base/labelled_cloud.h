// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/register_point_struct.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace xview {

/// `Point::view` of a point of which nobody knows from where it was seen.
constexpr std::uint32_t kNoView = std::numeric_limits<std::uint32_t>::max();

/// A labelled point of PCL: 16 bytes of x, y, z, 1 first, its maps and operator<<, and registered
/// there, so that one pcl::PointCloud<Point> flows through the program and into any transform,
/// filter, search, registration, writer or viewer of PCL. It is not made of PCL's macros because
/// <pcl/point_types.h> takes twice as long to compile as everything else here.
struct alignas(16) Point {
  union {
    float data[4] = {0, 0, 0, 1};
    struct {
      float x, y, z;
    };
  };
  std::uint32_t label = 0;       ///< class id
  std::uint32_t instance = 0;    ///< 0 = none given by the data
  float sigma = 0;               ///< standard deviation of its position [m]; 0 = not known to err
  std::uint32_t view = kNoView;  ///< which of the poses of its place saw it

  Point() = default;
  Point(float px, float py, float pz, std::uint32_t class_id = 0)
      : data{px, py, pz, 1}, label(class_id) {}

  using Vector3fMap = Eigen::Map<Eigen::Vector3f>;
  using ConstVector3fMap = Eigen::Map<const Eigen::Vector3f>;
  using Array4fMap = Eigen::Map<Eigen::Array4f, Eigen::Aligned>;
  using ConstArray4fMap = Eigen::Map<const Eigen::Array4f, Eigen::Aligned>;
  using Vector4fMap = Eigen::Map<Eigen::Vector4f, Eigen::Aligned>;
  using ConstVector4fMap = Eigen::Map<const Eigen::Vector4f, Eigen::Aligned>;
  Vector3fMap getVector3fMap() { return Vector3fMap(data); }
  ConstVector3fMap getVector3fMap() const { return ConstVector3fMap(data); }
  Vector4fMap getVector4fMap() { return Vector4fMap(data); }
  ConstVector4fMap getVector4fMap() const { return ConstVector4fMap(data); }
  Array4fMap getArray4fMap() { return Array4fMap(data); }
  ConstArray4fMap getArray4fMap() const { return ConstArray4fMap(data); }
};

/// (x,y,z - label), as PCL prints its own points.
std::ostream& operator<<(std::ostream& out, const Point& point);

}  // namespace xview

// clang-format off
POINT_CLOUD_REGISTER_POINT_STRUCT(xview::Point,
  (float, x, x) (float, y, y) (float, z, z)
  (std::uint32_t, label, label) (std::uint32_t, instance, instance)
  (float, sigma, sigma) (std::uint32_t, view, view))
// clang-format on

namespace xview {

/// What was left out of a cloud when it was taken in.
struct LeftOut {
  std::size_t of = 0;         ///< points that there were
  std::size_t far = 0;        ///< too far from the middle of the others
  std::size_t repeated = 0;   ///< at a position that many points have exactly
  double farther_than_m = 0;  ///< along an axis, what `far` counts
  std::size_t no_class = 0;   ///< kept, but unlabelled: their class is not a number (NaN)

  bool any() const { return far + repeated + no_class > 0; }
  std::string text() const;  ///< for a note; empty if there is nothing to say
  LeftOut& operator+=(const LeftOut& other);
};

/// Points of single precision relative to `origin`, so that maps in UTM coordinates keep their
/// millimetres: p_frame = origin + p.
struct LabelledCloud {
  pcl::PointCloud<Point> points;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  LeftOut left_out;  ///< as it was read

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  Eigen::Vector3d position(std::size_t i) const {
    return origin + points[i].getVector3fMap().cast<double>();
  }
  /// Adds the points of another cloud of the same frame, whatever its origin.
  void append(const LabelledCloud& other) {
    if (empty()) {
      *this = other;
      return;
    }
    const Eigen::Vector3f shift = (other.origin - origin).cast<float>();
    for (Point point : other.points) {
      point.getVector3fMap() += shift;
      points.push_back(point);
    }
  }
  /// True if the data told instances of objects.
  bool hasInstances() const {
    return std::any_of(points.begin(), points.end(),
                       [](const Point& p) { return p.instance != 0; });
  }
  /// True if the data told how well the points are known.
  bool hasSigmas() const {
    return std::any_of(points.begin(), points.end(), [](const Point& p) { return p.sigma != 0; });
  }
  /// The median of what is known of the errors of its points [m]; 0 if it is empty.
  double typicalSigma() const;
};

}  // namespace xview
