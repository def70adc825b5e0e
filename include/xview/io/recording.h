// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/labels.h"

namespace xview::io {

/// Half-open range of positions in a sequence, "A:B" or "A:B:STEP"; A and B may be empty.
struct FrameRange {
  std::size_t begin = 0;
  std::optional<std::size_t> end;
  std::size_t step = 1;
};
FrameRange parseFrameRange(const std::string& text);  ///< throws UsageError

enum class InputKind {
  sequence,        ///< folder with camera.yaml, depth/ and label/
  semantic_kitti,  ///< folder with velodyne/ and labels/, or one .bin with its .label
  cloud,           ///< one .pcd, .ply, .las or .e57 with points, or tiles
  cloud_folder,    ///< folder of .pcd/.ply with poses.txt
  graph,           ///< .ply semantic graph
  map,             ///< .xvm
  synthia,         ///< folder with GT/LABELS, Depth and CameraParams
  airsim,          ///< folder with airsim_rec.txt
  tum_rgbd,        ///< folder with depth.txt, groundtruth.txt and label/
  virtual_kitti,   ///< Virtual KITTI 2: folder of one scene and variation
  carla,           ///< folder of dumped CARLA cameras
  bag              ///< .mcap, .db3 or .bag of a robot, or a rosbag2 folder
};
const char* toString(InputKind kind);

struct InputOptions {
  std::string kind;    ///< --input-kind; empty = look at the path
  std::string labels;  ///< label set: name of a shipped one or path of a YAML file; empty = look
  std::optional<LabelSet> map_labels;  ///< classes of the map that it is sought in or added to,
                                       ///< which a recording that names none may have
  ClassNames class_names = ClassNames::shipped();  ///< tell roles and kinds that are not given
  std::string label_field;  ///< clouds: name of the label field; empty = the well-known names
  std::string instance_field;
  std::string mount;  ///< AirSim: "x,y,z,roll,pitch,yaw" of the camera on its vehicle, x forward, y
                      ///< right, z down [m, deg]; empty = settings.json beside the recording
  std::string topic;  ///< bags: the topic of the clouds or depth images; empty = look
  std::string odometry;  ///< bags: the topic of the poses or transforms; empty = look
  FrameRange frames;
  /// A rotation, one scale and a translation that all of it is moved by before anything is made of
  /// it, as p_odom = moved * p_file.
  std::optional<Eigen::Affine3d> moved;
};

/// What the path is. Throws Error if nothing fits or (naming both and --input-kind) if two fit;
/// UsageError if options.kind is no kind. A .xvm is a map even if options.kind is another one,
/// which is then that of the query that is sought in it. A .ply is a graph if its vertices are
/// objects and not samples of surfaces, however many there are (objects_or_samples.cpp).
/// `guess`, if given, receives a sentence if only the content of a .ply told.
InputKind recogniseInput(const std::string& path, const InputOptions& options = {},
                         std::string* guess = nullptr);

/// Opens anything with points (not graph, not map). Checks what can be checked without reading the
/// bulk: that files and poses agree in number, that poses are rigid, that the camera is complete.
/// Throws Error with path and place.
std::unique_ptr<FrameSource> openRecording(const std::string& path,
                                           const InputOptions& options = {});

/// To another frame and to other lengths (InputOptions::moved). A far origin takes the translation,
/// so that millimetres stay.
void moveCloud(const Eigen::Affine3d& moved, LabelledCloud& cloud);

/// The colour image of every frame of a recording: of the images that its rgb.txt lists, as TUM
/// RGB-D has it, the nearest in time within 0.05 s; else that of RECORDING/rgb that has the number
/// of the frame at the end of its name. Throws Error.
std::vector<std::string> colorFiles(const FrameSource& recording);

/// Writes a recording as a sequence folder (camera) or a SemanticKITTI folder (LiDAR); frames are
/// read and written on `threads` threads. `truth` (T_map_sensor per frame) goes to groundtruth.txt.
/// The folder appears whole or not at all (AtomicFolder), since a part of a recording would be
/// taken for a whole one; an older recording in it is replaced, other files stay. Throws Error.
/// `progress`, if not empty, is called with (done, total).
void writeRecording(const std::string& folder, const FrameSource& source,
                    const std::vector<Eigen::Isometry3d>& truth, int threads,
                    const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace xview::io
