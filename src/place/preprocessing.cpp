// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/stray_points.h"
#include "place/bev_grid.h"
#include "place/blobs.h"
#include "place/clean_labels.h"
#include "place/depth_plausibility.h"
#include "place/measure_size.h"
#include "place/point_quality.h"
#include "place/shared_frames.h"
#include "place/smooth_depth.h"
#include "place/sound_input.h"
#include "process/helpers.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview {
namespace {

constexpr std::size_t kFramesAhead = 8;  ///< preprocessed and not yet taken
constexpr float kHalfWeight_m = 0.3F;    ///< a point of a cloud known to this has half a weight
constexpr float kReferenceFocal =
    160;  ///< weights count measurements per solid angle of such a camera [px]

/// Weight of a measurement over its range: half at `half_m`, none beyond `reach_m`; thin things are
/// resolved within `thin_m` only.
struct RangeWeight {
  float half_m, reach_m, thin_m, gain;
};

RangeWeight rangeWeightOf(Sensor sensor, bool aerial, bool sparse) {
  if (sensor == Sensor::cloud) return {INFINITY, INFINITY, INFINITY, sparse ? 2.F : 1.F};
  if (sensor == Sensor::lidar) return {40, 50, 60, 2};
  return aerial ? RangeWeight{60, 90, 90, 1} : RangeWeight{10, 30, 25, 1};
}

/// A voxel counts as its measurements, at most four, half of them each; less with the square of the
/// range.
void setWeights(const Frame& frame, const std::vector<std::uint32_t>& points_per_voxel,
                PreprocessedFrame& preprocessed) {
  const bool sparse =
      frame.sensor == Sensor::cloud && isSparse(preprocessed.cloud, points_per_voxel, kBevVoxel_m);
  const RangeWeight weight = rangeWeightOf(frame.sensor, preprocessed.aerial, sparse);
  const float density = frame.sensor == Sensor::camera
                            ? kReferenceFocal * kReferenceFocal /
                                  static_cast<float>(frame.camera.fx * frame.camera.fy)
                            : 1.f;
  preprocessed.weights.resize(preprocessed.cloud.size());
  preprocessed.resolves_thin.assign(preprocessed.cloud.size(), true);
  for (std::size_t i = 0; i < preprocessed.cloud.size(); ++i) {
    const float range = rangeOf(preprocessed, i);
    const float measured =
        std::min(4.f, std::max(1.f, density * static_cast<float>(points_per_voxel[i])));
    const float fade = range / weight.half_m;
    preprocessed.weights[i] =
        range > weight.reach_m ? 0.f : weight.gain * 0.5f * measured / (1 + fade * fade);
    preprocessed.resolves_thin[i] = range <= weight.thin_m;
  }
}

/// Clouds do not tell their ranges, but some of them what the ranges are asked for.
void weighBySigma(PreprocessedFrame& preprocessed) {
  for (std::size_t i = 0; i < preprocessed.weights.size(); ++i)
    preprocessed.weights[i] /= 1 + preprocessed.cloud.points[i].sigma / kHalfWeight_m;
}

/// Where nothing tells how well points are known, their density does. Objects are small: few points
/// are no sign of a long way.
void weighByDensity(const LabelSet& labels, const std::vector<std::uint32_t>& points_per_voxel,
                    double voxel_m, PreprocessedFrame& preprocessed) {
  const std::vector<float> weights = densityWeights(preprocessed.cloud, points_per_voxel, voxel_m);
  for (std::size_t i = 0; i < preprocessed.weights.size(); ++i) {
    if (labels.role(preprocessed.cloud.points[i].label) != Role::object)
      preprocessed.weights[i] *= weights[i];
  }
}

void findImageBlobs(const Frame& cleaned, const LabelSet& labels, const Options& options,
                    PreprocessedFrame& preprocessed) {
  ImageBlobs found =
      extractImageBlobs(cleaned, labels, maxRange(cleaned, options.lift), options.blobs);
  preprocessed.blobs = std::move(found.blobs);
  preprocessed.blob_edges = std::move(found.edges);
}

/// The classes whose blobs merging uses: surfaces are sampled in mode running_mean, and most
/// points are theirs.
WholeClasses blobClasses(const Options& options) {
  if (usesImageRegions(options)) return WholeClasses::none;
  return options.merge.mode == "running_mean" ? WholeClasses::no_surfaces : WholeClasses::all;
}

std::vector<Blob> frameBlobs(const LabelledCloud& points, const LabelSet& labels,
                             const Options& options) {
  const bool thin = options.blobs.voxel_m > 0;
  return extractBlobs(thin ? thinByVoxel(points, options.blobs.voxel_m) : points, labels,
                      options.blobs);
}

/// Without classes nothing of a frame would be left.
void requireClasses(const LabelSet& labels, const std::string& name) {
  if (!labels.empty()) return;
  throw Error(name,
              "it has no labels; withClasses() gives it classes from the shapes of its points");
}

}  // namespace

PreprocessedFrame readAndPreprocess(const FrameSource& source, std::size_t i,
                                    const Options& options) {
  Stopwatch watch;
  Frame frame = source.read(i);
  requireMetres(frame, source.name());
  const double read_ms = watch.lap_ms();
  PreprocessedFrame preprocessed = preprocessFrame(std::move(frame), source.labels(), options);
  preprocessed.timing_ms.insert(preprocessed.timing_ms.begin(), {"read", read_ms});
  return preprocessed;
}

namespace {

using Take = std::function<void(PreprocessedFrame)>;

/// All frames of a recording in order, as make(take) gives them, if nothing is wrong with them.
void takeChecked(const FrameSource& source, const Options& options, const Take& take,
                 const std::function<void(const Take&)>& make) {
  requireClasses(source.labels(), source.name());
  requireGraphSpace(options, source.sensor(), source.name());
  DepthPlausibility depths;
  make([&](PreprocessedFrame preprocessed) {
    depths.add(preprocessed.counts, preprocessed.cloud, preprocessed.T_odom_sensor.translation(),
               preprocessed.size);
    take(std::move(preprocessed));
  });
  depths.require(source);
}

/// At most `ahead` frames are preprocessed and not yet taken.
void preprocessInOrder(const FrameSource& source, const Options& options, std::size_t ahead,
                       const Take& take) {
  takeChecked(source, options, take, [&](const Take& take_checked) {
    std::vector<PreprocessedFrame> waiting(ahead);
    const auto make = [&](std::size_t i) {
      askBudget("the frames");
      waiting[i % ahead] = readAndPreprocess(source, i, options);
    };
    makeInOrder(source.size(), options.threads, ahead, make,
                [&](std::size_t i) { take_checked(std::move(waiting[i % ahead])); });
  });
}

/// The size is that of the recording, not of each frame.
Options sizedFor(const FrameSource& source, Options options) {
  options.size = sizeText(sizeFor(options, std::vector<const FrameSource*>{&source}));
  return options;
}

}  // namespace

PreprocessedFrame preprocessFrame(Frame frame, const LabelSet& labels, const Options& given) {
  const std::string name = "frame " + std::to_string(frame.number);
  requireClasses(labels, name);
  requireGraphSpace(given, frame.sensor, name);
  Stopwatch watch;
  PreprocessedFrame preprocessed;
  preprocessed.size = parseSize(given.size).value_or(kTownScale);
  requireNear(name + ": T_odom_sensor", frame.T_odom_sensor, preprocessed.size);
  if (preprocessed.size != kTownScale) scaleLengths(1 / preprocessed.size, frame);
  const Options options = inCanonicalLengths(given, preprocessed.size);
  double inverse_depth_sigma = 0;  // depth z of a camera is known to z^2 times this [1/m]
  preprocessed.number = frame.number;
  preprocessed.stamp_s = frame.stamp_s;
  preprocessed.sensor = frame.sensor;
  preprocessed.T_odom_sensor = frame.T_odom_sensor;
  preprocessed.up_sensor = frame.up_sensor;
  // Images of two sizes are refused where they are lifted.
  const bool are_of_one_size =
      frame.label.width == frame.depth.width && frame.label.height == frame.depth.height;
  if (frame.sensor == Sensor::camera && are_of_one_size) {
    const double noise = inverse_depth_sigma = inverseDepthNoise(frame.depth);
    frame.label = cleanLabels(frame.label, labels, options.clean);
    if (isNoiseOfPixels(noise, frame.depth))
      smoothDepth(frame.depth, frame.label, noise, kKnownWell_m);
  }
  ThinFrame lifted = liftThin(frame, labels, options.lift, kBevVoxel_m, blobClasses(options),
                              &preprocessed.counts);
  preprocessed.aerial = lifted.is_aerial;
  preprocessed.cloud = std::move(lifted.thin);
  setSigmas(inverse_depth_sigma, frame.T_odom_sensor.translation(), preprocessed.cloud);
  if (frame.sensor == Sensor::cloud) {
    preprocessed.T_odom_sensor.translation() =
        standpoint(frame.T_odom_sensor.translation(), boxWithoutStrays(preprocessed.cloud));
  }
  setWeights(frame, lifted.points_per_voxel, preprocessed);
  if (frame.sensor == Sensor::cloud && preprocessed.cloud.typicalSigma() > 0)
    weighBySigma(preprocessed);
  else if (frame.sensor == Sensor::cloud)
    weighByDensity(labels, lifted.points_per_voxel, kBevVoxel_m, preprocessed);
  preprocessed.timing_ms.emplace_back("lift", watch.lap_ms());
  askBudget("the frames");
  if (usesImageRegions(options))
    findImageBlobs(frame, labels, options, preprocessed);
  else
    preprocessed.blobs = frameBlobs(lifted.whole, labels, options);
  for (Blob& blob : preprocessed.blobs) blob.first_frame = blob.last_frame = frame.number;
  preprocessed.timing_ms.emplace_back("blobs", watch.lap_ms());
  return preprocessed;
}

void preprocessRecording(const FrameSource& source, const Options& options,
                         const std::function<void(PreprocessedFrame)>& take) {
  preprocessInOrder(source, sizedFor(source, options), kFramesAhead, take);
}

void preprocessByHelpers(Conversation& helpers, const RecordingsInOneSet& recordings,
                         std::size_t which, const Take& take) {
  const FrameSource& source = recordings[which];
  takeChecked(source, recordings.options(), take, [&](const Take& take_checked) {
    const std::size_t count = helpers.helpers();
    for (std::size_t i = 0, asked = 0; i < source.size(); ++i) {
      askBudget("the frames");
      // Each has one to do while the other is on its way.
      for (; asked < std::min(source.size(), i + 2 * count); ++asked)
        helpers.ask(asked % count, frameRequest(which, asked));
      take_checked(preprocessedFrameOf(helpers.answerOf(i % count)));
    }
  });
}

std::vector<PreprocessedFrame> preprocessRecording(const FrameSource& source,
                                                   const Options& options,
                                                   const Progress& progress) {
  std::vector<PreprocessedFrame> preprocessed_frames;
  preprocessed_frames.reserve(source.size());
  const auto take = [&](PreprocessedFrame preprocessed) {
    preprocessed_frames.push_back(std::move(preprocessed));
    if (progress) progress(preprocessed_frames.size(), source.size());
  };
  preprocessInOrder(source, sizedFor(source, options), std::max<std::size_t>(1, source.size()),
                    take);
  return preprocessed_frames;
}

}  // namespace xview
