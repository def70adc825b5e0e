// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "io/listed_recording.h"

namespace xview {

// One function and one file per public data set, each for its own layout of folders. All throw
// Error with path and place.

/// SYNTHIA video sequence: Depth, GT/LABELS and CameraParams, each with folders for the cameras.
/// The folder of one camera below Depth chooses that camera; else the first one in the order of the
/// names.
RecordingListing listSynthia(const std::string& folder, const InputOptions& options);
/// AirSim recording: airsim_rec.txt and images/ with depth (types 1 and 2) and segmentation (type
/// 5).
RecordingListing listAirsim(const std::string& folder, const InputOptions& options);
/// TUM RGB-D layout: depth.txt, groundtruth.txt, and label/ named as the depth or colour images.
RecordingListing listTumRgbd(const std::string& folder, const InputOptions& options);
/// Virtual KITTI 2: the folder of one scene and variation; camera 0.
RecordingListing listVirtualKitti(const std::string& folder, const InputOptions& options);
/// CARLA cameras saved raw: depth/ and semantic/ with camera.yaml and poses.txt as in a sequence
/// folder.
RecordingListing listCarla(const std::string& folder, const InputOptions& options);

}  // namespace xview
