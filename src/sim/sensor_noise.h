// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/option_field.h"
#include "xview/base/frame.h"

namespace xview {

/// Errors of a stereo camera, or of one that projects a pattern.
struct DepthNoise {
  double baseline_m = 0.5;          ///< distance of the two cameras
  double disparity_sigma_px = 0.2;  ///< sigma_z = z^2 / (fx * baseline) * this
  double bleeding_px = 1.5;         ///< near objects grow over their edges by up to this
  double invalid_share = 0.03;      ///< of the pixels: without depth
  double max_range_m = 100;         ///< no depth beyond
};

/// Errors like those of a segmentation network.
struct LabelNoise {
  double accuracy = 0.83;    ///< share of the pixels that keep their label, on average over frames
  double variation = 0.02;   ///< standard deviation of that between frames
  double persistence = 0.5;  ///< 0 = errors change with the image, 1 = they stick to places
  double patch_m = 3;        ///< size of regions that are wrong for their place in the world
};

template <class Visitor>
void visit(LabelNoise& o, Visitor&& field) {
  field("accuracy", o.accuracy, Range{0.3, 1}, "share of the pixels with the right label");
}

struct LidarNoise {
  double range_sigma_m = 0.02;
  double dropout_share = 0.02;       ///< of the returns: lost
  double label_accuracy = 0.95;      ///< share of the points with the right label
  double uncorrected_motion = 0.05;  ///< share of the own motion in a turn that stays in the scan
};

// All take a perfect frame of a simulated town and give a bad one. Equal seeds give equal errors;
// use one seed for a whole recording, the frame's number varies what must vary.

Frame withDepthNoise(Frame frame, const DepthNoise& noise, std::uint64_t seed);

/// Wrong regions lie along boundaries and on difficult classes, are blobs of some 10 to 40 pixels
/// with a plausible wrong label, and thin objects are partly missed. Pixels that lose their label
/// lose their instance. Call before withDepthNoise, because errors that stick to places need the
/// true depth. Frames without labels of the town stay as they are.
Frame withLabelNoise(Frame frame, const LabelNoise& noise, std::uint64_t seed);

Frame withLidarNoise(Frame frame, const LidarNoise& noise, std::uint64_t seed);

/// A scan as it comes from a scanner on the move: a turn begins and ends behind it (azimuth pi),
/// the pose of the frame is that of the middle of the turn, and every point is relative to where
/// the scanner was when it was measured. The motion in one turn is `share` of `step`, which is in
/// the frame of the sensor. The surfaces that are hit are those of a scanner at rest.
Frame withOwnMotion(Frame frame, const Eigen::Isometry3d& step, double share);

}  // namespace xview
