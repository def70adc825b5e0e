// SPDX-License-Identifier: BSD-3-Clause
#include "place/raw_recording.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "place/depth_plausibility.h"
#include "place/gravity.h"
#include "place/measure_size.h"
#include "place/shapes.h"
#include "place/shapes_any_way_up.h"
#include "place/smooth_depth.h"
#include "place/up_by_surfaces.h"

namespace xview {
namespace {

constexpr std::size_t kFramesToLookAt = 3;
constexpr double kNoiseOfAverages = 0.2;  ///< what is left of the noise where a plane was found
constexpr double kHidesShapes_m = 0.3;    ///< noise as large as the voxels that shapes are told in
constexpr double kNearlyOnePlace = 0.25;  ///< times the depth: cameras nearer than this see alike
constexpr std::size_t kBefore = 4;        ///< frames before one, and after it, to average it with

/// Depths whose noise no longer hides shapes: without labels all pixels may share a plane.
DepthImage smoothed(const DepthImage& depth, double noise) {
  DepthImage smooth = depth;
  if (isNoiseOfPixels(noise, depth))
    smoothDepth(smooth, LabelImage(depth.width, depth.height, 1), noise, kKnownWell_m);
  return smooth;
}

/// The measurements of a camera frame, turned upright, and the pixels that they are of.
struct PixelPoints {
  pcl::PointCloud<Point> points;
  std::vector<std::size_t> pixels;
};

PixelPoints pointsOf(const Frame& frame, const Eigen::Matrix3d& R_up_sensor,
                     const LiftOptions& options) {
  const double noise = inverseDepthNoise(frame.depth);
  const double farthest = maxRange(frame, options);
  const DepthImage depth = smoothed(frame.depth, noise);
  PixelPoints result;
  result.points.reserve(depth.pixels.size());
  result.pixels.reserve(depth.pixels.size());
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const double z = depth.at(u, v);
      if (!(z > 0) || !(z < farthest)) continue;
      const Eigen::Vector3d p = frame.camera.unproject(u, v, z);
      const double range = p.norm();
      if (range > farthest) continue;
      Point point;
      point.getVector3fMap() = (R_up_sensor * p).cast<float>();
      const bool is_average = depth.at(u, v) != frame.depth.at(u, v);
      point.sigma = static_cast<float>((is_average ? kNoiseOfAverages : 1) * noise * range * range);
      result.points.push_back(point);
      result.pixels.push_back(static_cast<std::size_t>(v) * depth.width + u);
    }
  }
  return result;
}

void labelImage(const Eigen::Matrix3d& R_up_sensor, const LiftOptions& options, double size,
                Frame& frame) {
  PixelPoints seen = pointsOf(frame, R_up_sensor, options);
  labelByShape(seen.points, size);
  frame.label = LabelImage(frame.depth.width, frame.depth.height);
  for (std::size_t i = 0; i < seen.pixels.size(); ++i)
    frame.label.pixels[seen.pixels[i]] = static_cast<std::uint16_t>(seen.points[i].label);
}

/// The frames of a recording that were asked for last, for readers that need neighbours.
class RecentFrames {
 public:
  using Shared = std::shared_ptr<const Frame>;

  Shared read(const FrameSource& source, std::size_t index) {
    Slot& slot = slots_[index % slots_.size()];
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (slot.frame && slot.index == index) return slot.frame;
    }
    auto frame = std::make_shared<const Frame>(source.read(index));
    const std::lock_guard<std::mutex> lock(mutex_);
    slot = {index, frame};
    return frame;
  }

 private:
  struct Slot {
    std::size_t index = 0;
    Shared frame;
  };
  std::mutex mutex_;
  std::array<Slot, 4 * kBefore> slots_;
};

/// Labels the frames of a recording by the shapes of what they show.
class ShapeLabels {
 public:
  ShapeLabels(std::shared_ptr<const FrameSource> source, const Options& options)
      : source_(std::move(source)), lift_(options.lift) {
    if (options.gravity != "aligned") up_ = upOfCamera(*source_);
    size_ = parseSize(options.size);
    if (!size_ && source_->sensor() != Sensor::cloud && source_->size() > 1)
      size_ = measureSize({source_.get()}).size;
  }

  Frame read(std::size_t index) const {
    if (std::optional<Frame> kept = takeKept()) return *std::move(kept);
    Frame frame = source_->read(index);
    requireMetres(frame, source_->name());  // shapes of a thousand times as much take as long
    Eigen::Matrix3d R_up_sensor = frame.T_odom_sensor.linear();
    if (up_.norm() > 0) {
      frame.up_sensor = R_up_sensor.transpose() * up_;
      R_up_sensor = alignmentFromUp(up_) * R_up_sensor;
    }
    const double size = size_ ? *size_ : measureSize(frame).size;
    if (frame.sensor == Sensor::camera) {
      averageWithNeighbours(index, frame);
      labelImage(R_up_sensor, lift_, size, frame);
    } else {
      frame.up_sensor = labelAnyWayUp(R_up_sensor, frame.sensor, size, frame.cloud.points);
    }
    frame.instance = {};
    for (Point& point : frame.cloud.points) point.instance = 0;
    return frame;
  }

  ShapeShares look() {
    ShapeShares shares{};
    const std::size_t size = source_->size(), frames = std::min(kFramesToLookAt, size);
    for (std::size_t i = 0; i < frames; ++i) {
      Frame frame = read(i * size / frames);
      for (const std::uint16_t label : frame.label.pixels) shares[label] += label > 0;
      for (const Point& point : frame.cloud.points) shares[point.label] += 1;
      if (size == 1) kept_ = std::move(frame);  // a cloud may be all that memory holds
    }
    double sum = 0;
    for (const double share : shares) sum += share;
    for (double& share : shares) share /= std::max(1.0, sum);
    return shares;
  }

 private:
  /// Where noise hides the shapes in one frame, as from the air, several frames show them.
  void averageWithNeighbours(std::size_t index, Frame& frame) const {
    const double noise = inverseDepthNoise(frame.depth);
    const double z = medianDepth(frame.depth);
    if (noise * z * z < kHidesShapes_m || !isNoiseOfPixels(noise, frame.depth)) return;
    const auto seesAlike = [&](std::size_t other) {
      return (source_->pose(other).translation() - frame.T_odom_sensor.translation()).norm() <
             kNearlyOnePlace * z;
    };
    std::size_t first = index, last = index;
    while (first > 0 && index - first < kBefore && seesAlike(first - 1)) --first;
    while (last + 1 < source_->size() && last - index < kBefore && seesAlike(last + 1)) ++last;
    std::vector<RecentFrames::Shared> kept;
    std::vector<const Frame*> others;
    for (std::size_t i = first; i <= last; ++i) {
      if (i == index) continue;
      kept.push_back(recent_.read(*source_, i));
      others.push_back(kept.back().get());
    }
    frame.depth = averageDepth(frame, others, noise);
  }

  std::optional<Frame> takeKept() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(kept_, std::nullopt);
  }

  std::shared_ptr<const FrameSource> source_;
  LiftOptions lift_;
  Eigen::Vector3d up_ = Eigen::Vector3d::Zero();  ///< where z is not up; see upOfCamera
  std::optional<double> size_;                    ///< of all frames; without it each is measured
  mutable RecentFrames recent_;
  mutable std::mutex mutex_;
  mutable std::optional<Frame> kept_;  ///< the only frame, until somebody reads it
};

}  // namespace

std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const LiftOptions& options, int threads,
                                              const LabelSet* of_map) {
  constexpr std::size_t kFrames = 60;
  constexpr double kVoxel_m = 0.25;
  if (!hasUnknown(source->labels())) return source;
  LabelSet labels = source->labels();
  if (of_map) labels = withRolesOf(*of_map, labels);
  if (hasUnknown(labels)) {
    std::vector<LabelledCloud> clouds(std::min(kFrames, source->size()));
    parallelFor(clouds.size(), threads, [&](std::size_t i) {
      const Frame frame = source->read(i * source->size() / clouds.size());
      clouds[i] = thinByVoxel(lift(frame, labels, options), kVoxel_m);
    });
    LabelledCloud whole;
    for (const LabelledCloud& cloud : clouds) whole.append(cloud);
    labels = rolesByShape(labels, whole);
  }
  return std::make_unique<RelabelledRecording>(std::move(source), std::move(labels));
}

std::unique_ptr<FrameSource> withShapeLabels(std::unique_ptr<FrameSource> source, LabelSet shapes,
                                             const Options& options, ShapeShares* shares) {
  const std::shared_ptr<const FrameSource> measured = std::move(source);
  const auto by_shape = std::make_shared<ShapeLabels>(measured, options);
  if (shares) *shares = by_shape->look();
  return std::make_unique<RelabelledRecording>(
      measured, std::move(shapes), [by_shape](std::size_t index) { return by_shape->read(index); });
}

std::unique_ptr<const FrameSource> withClasses(const FrameSource& recording, const Options& options,
                                               const LabelSet* of_map) {
  auto borrowed = std::make_unique<ForwardingSource>(recording);
  if (knowsShapesOnly(recording.labels())) return borrowed;
  if (recording.labels().empty() || (of_map && knowsShapesOnly(*of_map)))
    return withShapeLabels(std::move(borrowed), labelsOfShapes(), options);
  return withRolesByShape(std::move(borrowed), options.lift, options.threads, of_map);
}

}  // namespace xview
