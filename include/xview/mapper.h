// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "xview/map/semantic_map.h"
#include "xview/options.h"
#include "xview/types/blob.h"
#include "xview/types/frame.h"
#include "xview/types/localization.h"

namespace xview {

/// Called after each frame with (done, total). May be empty.
using Progress = std::function<void(std::size_t, std::size_t)>;

/// What later stages need of one frame; small enough to keep for a whole recording. In the odometry
/// frame.
struct FrameDigest {
  std::int64_t number = 0;
  double stamp_s = 0;
  Sensor sensor = Sensor::camera;
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  LabelledCloud cloud;       ///< lifted, one point per voxel and class
  std::vector<float> votes;  ///< per point: how much it counts (measurements in the voxel, range)
  std::vector<bool> thin_trusted;  ///< per point: measured near enough to believe in thin things
  bool aerial = false;             ///< a camera that looks down from the air
  std::vector<Blob> blobs;
  BlobEdges blob_edges;  ///< image space only (options.graph_space)
  LiftCounts counts;
  Timings timing_ms;  ///< read, lift, blobs
};

/// Image space (options.graph_space) is for depth and label images: UsageError for another sensor,
/// naming the recording.
void requireGraphSpace(const Options& options, Sensor sensor, const std::string& recording);

/// One frame through lift, clean and blobs. Throws UsageError if options.graph_space is image and
/// the frame has no images.
FrameDigest digestFrame(Frame frame, const LabelSet& labels, const Options& options);

/// All frames of a recording, read and digested on options.threads threads, in order.
std::vector<FrameDigest> digestRecording(const FrameSource& source, const Options& options,
                                         const Progress& progress = {});

/// The same one by one, in order, on the caller's thread: only a few of them are in memory at a
/// time.
void digestRecording(const FrameSource& source, const Options& options,
                     const std::function<void(FrameDigest)>& take);

/// Place graph of a recording, with edges; it is that of its map. `seen` is called with every
/// frame, in order. Memory follows the place, not the number of frames.
SemanticGraph buildGraph(const FrameSource& source, const Options& options,
                         const std::function<void(const FrameDigest&)>& seen = {});

/// Map of one or more recordings in one common frame. Label sets must agree (Error).
SemanticMap buildMap(const std::vector<const FrameSource*>& sources, const Options& options,
                     const Progress& progress = {});
/// Map of a bare graph.
SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels, const std::string& source,
                     const Options& options);

/// Adds a recording or another map's content to a map in the same frame.
void appendToMap(SemanticMap& map, const SemanticMap& addition, const Options& options);

}  // namespace xview
