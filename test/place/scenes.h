// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/random.h"
#include "place/merge.h"
#include "xview/base/frame.h"
#include "xview/base/graph.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"

namespace xview::test {

// Class ids of townLabels().
constexpr std::uint16_t kVoid = 0, kSky = 1, kRoad = 2, kBuilding = 3, kPole = 4, kCar = 5,
                        kBench = 6;

/// A small label set with every role.
LabelSet townLabels();

/// A cloud in single precision around `origin`.
LabelledCloud cloudOf(const std::vector<Eigen::Vector3f>& points, std::uint32_t label,
                      const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

/// Points in clumps and alone, so that clusters of all sizes come out.
std::vector<Eigen::Vector3f> clumpedPoints(std::size_t count, double extent_m, Random& random);

/// A blob of no size.
Blob blobAt(std::uint32_t label, double x, double y, double z, std::uint32_t points = 50);

/// Merging of this mode that keeps surface vertices of single points.
MergeOptions mergeOptions(const std::string& mode);

/// The vertices of blobs, frame by frame.
std::vector<Vertex> merged(const MergeOptions& options,
                           const std::vector<std::vector<Blob>>& frames);

/// A camera frame in which every pixel has this label and planar depth.
Frame flatFrame(int width, int height, std::uint16_t label, float depth_m);

/// Any rotation, up to a kilometre away.
Eigen::Isometry3d randomPose(Random& random);

}  // namespace xview::test
