// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/camera.h"
#include "xview/types/image.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"

namespace xview {

enum class Sensor {
  camera,  ///< depth and label image
  lidar,   ///< one labelled scan, points in the sensor frame
  cloud    ///< a labelled cloud without a view-point, e.g. a saved map; points in the frame of the
           ///< pose
};

/// One measurement with its odometry pose.
struct Frame {
  std::int64_t number = 0;  ///< number in the file name, or position in the sequence
  double stamp_s = 0;
  Sensor sensor = Sensor::camera;
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();

  Camera camera;        ///< camera only
  DepthImage depth;     ///< camera only
  LabelImage label;     ///< camera only; same size as depth
  LabelImage instance;  ///< camera only; empty if there are no instances

  LabelledCloud cloud;  ///< lidar and cloud only, in the sensor frame
};

/// A recording: frames that can be read one by one, in any order and from several threads.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual std::size_t size() const = 0;
  virtual Eigen::Isometry3d pose(std::size_t index) const = 0;  ///< T_odom_sensor
  virtual double stamp(std::size_t index) const = 0;            ///< seconds
  virtual std::int64_t number(std::size_t index) const = 0;     ///< number in the file name
  virtual Frame read(std::size_t index) const = 0;  ///< throws Error with path and place
  virtual Sensor sensor() const = 0;
  virtual const LabelSet& labels() const = 0;
  virtual const std::string& name() const = 0;  ///< the path as given
  /// What its reader guessed or left out, and why: whole sentences without the path.
  virtual std::vector<std::string> notes() const { return {}; }
  /// What a label in its frames is that labels() does not know.
  virtual std::string describeUnknown(std::uint32_t label) const {
    return "class " + std::to_string(label) + " (label set '" + labels().name() +
           "' has no such id)";
  }
};

}  // namespace xview
