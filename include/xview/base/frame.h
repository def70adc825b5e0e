// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"

namespace xview {

/// A row-major image of plain numbers. Empty when width or height is 0.
template <class T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> pixels;

  Image() = default;
  Image(int w, int h, T value = T())
      : width(w),
        height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}

  bool empty() const { return pixels.empty(); }
  T& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const T& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

using DepthImage = Image<float>;          ///< metres; 0 = no measurement
using LabelImage = Image<std::uint16_t>;  ///< class id, or instance id (0 = none)

inline bool isDepth(float z) { return z > 0 && z < 1e9f; }  ///< false for what is none

/// Red, green and blue of each pixel.
using ColorImage = Image<std::array<std::uint8_t, 3>>;

/// Pinhole camera; pixel (u, v) looks along ((u - cx) / fx, (v - cy) / fy, 1): x right, y down, z
/// forward.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0;        ///< pixels
  double cx = 0, cy = 0;        ///< pixels
  double depth_scale = 1;       ///< metres per unit of an integer depth image
  bool depth_is_range = false;  ///< depth along the ray instead of along the optical axis
  double min_range_m = 0;       ///< what this camera measures nearer, or further, is not believed;
  double max_range_m = std::numeric_limits<double>::infinity();  ///< beside the limits of lifting

  /// p_sensor of a pixel of that depth.
  Eigen::Vector3d unproject(double u, double v, double depth) const {
    const Eigen::Vector3d ray((u - cx) / fx, (v - cy) / fy, 1);
    return depth_is_range ? Eigen::Vector3d(ray.normalized() * depth)
                          : Eigen::Vector3d(ray * depth);
  }
};

/// How a segmentation network wants its images, and what its answers mean.
struct NetworkInput {
  int width = 0, height = 0;  ///< size that the network sees [px]; 0 = that of the image
  /// A channel of the network is (value / 255 - mean) / std of a colour; in the order of `order`.
  std::array<double, 3> mean{0, 0, 0}, std{1, 1, 1};
  bool is_rgb = true;              ///< red first; else blue first
  std::vector<std::uint32_t> ids;  ///< class id of each output channel or value; empty = itself
  std::string labels;              ///< the label set of these ids: a shipped name or a file
};

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
  /// Up in the frame of the sensor, where it is known without classes; zero if not.
  Eigen::Vector3d up_sensor = Eigen::Vector3d::Zero();

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
  /// What was left out of the clouds that were read so far.
  virtual LeftOut leftOut() const { return {}; }
  /// The same frames without the labels that are made when one is read.
  virtual const FrameSource& asMeasured() const { return *this; }
  /// What a label in its frames is that labels() does not know.
  virtual std::string describeUnknown(std::uint32_t label) const {
    return "class " + std::to_string(label) + " (label set '" + labels().name() +
           "' has no such id)";
  }
};

/// A recording that is another one but for what a derived class says differently.
class ForwardingSource : public FrameSource {
 public:
  /// The other recording must outlive this object.
  explicit ForwardingSource(const FrameSource& source) : source_(source) {}
  /// The same of one that it holds.
  explicit ForwardingSource(std::shared_ptr<const FrameSource> source)
      : source_(*source), held_(std::move(source)) {}
  std::size_t size() const override { return source_.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return source_.pose(index); }
  double stamp(std::size_t index) const override { return source_.stamp(index); }
  std::int64_t number(std::size_t index) const override { return source_.number(index); }
  Frame read(std::size_t index) const override { return source_.read(index); }
  Sensor sensor() const override { return source_.sensor(); }
  const LabelSet& labels() const override { return source_.labels(); }
  const std::string& name() const override { return source_.name(); }
  std::vector<std::string> notes() const override { return source_.notes(); }
  LeftOut leftOut() const override { return source_.leftOut(); }
  std::string describeUnknown(std::uint32_t label) const override {
    return source_.describeUnknown(label);
  }

 protected:
  const FrameSource& source_;

 private:
  std::shared_ptr<const FrameSource> held_;
};

/// The frames of a recording under other classes.
class RelabelledRecording : public ForwardingSource {
 public:
  /// The frame at a position with its new labels; called from several threads.
  using Read = std::function<Frame(std::size_t index)>;

  /// Without `read` the frames keep their labels.
  RelabelledRecording(std::shared_ptr<const FrameSource> source, LabelSet labels, Read read = {})
      : ForwardingSource(std::move(source)), labels_(std::move(labels)), read_(std::move(read)) {}
  Frame read(std::size_t index) const override {
    return read_ ? read_(index) : ForwardingSource::read(index);
  }
  const LabelSet& labels() const override { return labels_; }
  const FrameSource& asMeasured() const override { return source_.asMeasured(); }

 private:
  LabelSet labels_;
  Read read_;
};

/// Frames of a recording with other poses, e.g. the ones that were found for them.
class PosedRecording final : public ForwardingSource {
 public:
  /// `poses` are T_target_sensor of the frames at those positions. The recording must outlive this
  /// object.
  PosedRecording(const FrameSource& recording, std::vector<std::size_t> positions,
                 std::vector<Eigen::Isometry3d> poses)
      : ForwardingSource(recording), positions_(std::move(positions)), poses_(std::move(poses)) {}
  /// Of the frames from position `first` on.
  PosedRecording(const FrameSource& recording, std::size_t first,
                 std::vector<Eigen::Isometry3d> poses)
      : ForwardingSource(recording), positions_(poses.size()), poses_(std::move(poses)) {
    std::iota(positions_.begin(), positions_.end(), first);
  }
  /// All of its frames, whose odometry frame was found in another one.
  PosedRecording(const FrameSource& recording, const Eigen::Isometry3d& T_target_odom)
      : ForwardingSource(recording) {
    for (std::size_t i = 0; i < recording.size(); ++i) {
      positions_.push_back(i);
      poses_.push_back(T_target_odom * recording.pose(i));
    }
  }

  std::size_t size() const override { return poses_.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return poses_.at(index); }
  double stamp(std::size_t index) const override {
    return ForwardingSource::stamp(positions_.at(index));
  }
  std::int64_t number(std::size_t index) const override {
    return ForwardingSource::number(positions_.at(index));
  }
  Frame read(std::size_t index) const override {
    Frame frame = ForwardingSource::read(positions_.at(index));
    frame.T_odom_sensor = poses_.at(index);
    return frame;
  }

 private:
  std::vector<std::size_t> positions_;
  std::vector<Eigen::Isometry3d> poses_;
};

/// Where a sensor with this attitude in the map looks in the plane, counter-clockwise from x [rad]:
/// cameras along z, everything else along x. For a camera that looks straight down it is what the
/// top of its image shows.
double headingOf(const Eigen::Matrix3d& R_map_sensor, Sensor sensor);

}  // namespace xview
