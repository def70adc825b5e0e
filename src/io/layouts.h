// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "input_file.h"
#include "xview/io/recording.h"

namespace xview::io {

/// A frame before it is read.
struct ListedFrame {
  std::int64_t number = 0;
  double stamp_s = 0;
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  std::string measurement;  ///< path of the depth image or cloud
  std::string label;        ///< path of the label file, if the measurement does not hold them
  std::string instance;     ///< path of the instance image; empty = none
  /// Of a frame that is moved: its pose before, which its reader knows.
  std::optional<Eigen::Isometry3d> T_before = std::nullopt;
};

/// All that one layout has to say about a recording. The reader fills the images or the cloud of
/// the frame; it is called from several threads.
struct RecordingListing {
  Sensor sensor = Sensor::camera;
  LabelSet labels;  ///< empty if there are no labels at all
  std::vector<ListedFrame> frames;
  std::vector<std::string> notes;  ///< FrameSource::notes()
  std::function<void(const ListedFrame&, Frame&)> read;
};

/// Nothing on Earth is farther from the origin of its coordinates [m].
constexpr double kFarthest_m = 1e8;

Frame readListed(const RecordingListing& listing, const ListedFrame& listed);

/// The frames of a listing as a recording.
std::unique_ptr<FrameSource> makeRecording(const std::string& name, RecordingListing listing);
/// Those of the range, in other lengths and another odometry frame if they are `moved`. Throws
/// UsageError if the range is beyond the last frame, Error if a frame is too far away.
std::unique_ptr<FrameSource> makeRecording(const std::string& path, RecordingListing listing,
                                           const FrameRange& range,
                                           const std::optional<Eigen::Affine3d>& moved = {});

// One function per layout: what frames there are and how each is read. All throw Error with path
// and place.

/// Folder with camera.yaml, poses.txt, depth/ and label/.
RecordingListing listSequence(const std::string& folder, const InputOptions& options);
RecordingListing listCloud(const std::string& path, const InputOptions& options);
RecordingListing listCloudFolder(const std::string& folder, const InputOptions& options);
/// CARLA cameras saved raw: depth/ and semantic/ with camera.yaml and poses.txt as in a sequence
/// folder.
RecordingListing listCarla(const std::string& folder, const InputOptions& options);
/// A sequence folder, or one .bin file.
RecordingListing listSemanticKitti(const std::string& path, const InputOptions& options);
/// SYNTHIA video sequence: Depth, GT/LABELS and CameraParams, each with folders for the cameras.
/// The folder of one camera below Depth chooses that camera; else the first one in the order of the
/// names.
RecordingListing listSynthia(const std::string& folder, const InputOptions& options);
/// SEQ/Depth/Stereo_Left/Omni_F: one camera of a SYNTHIA sequence.
bool isSynthiaCamera(const std::string& folder);
/// AirSim recording: airsim_rec.txt and images/ with depth (types 1 and 2) and segmentation (type
/// 5).
RecordingListing listAirsim(const std::string& folder, const InputOptions& options);
/// TUM RGB-D layout: depth.txt, groundtruth.txt, and label/ named as the depth or colour images.
RecordingListing listTumRgbd(const std::string& folder, const InputOptions& options);
/// An image and when it was taken.
struct StampedFile {
  double stamp_s = 0;
  std::string path;
};
/// A list of TUM RGB-D, as rgb.txt: lines "stamp file", with files from its own folder; comments
/// start with #. Throws Error.
std::vector<StampedFile> readFileList(const std::string& path);
/// That of the nearest time, the first of equals; null if none is at most `within_s` away.
const StampedFile* nearestTo(double stamp_s, const std::vector<StampedFile>& files,
                             double within_s);
/// A bag (isBag): clouds or depth images of one topic, with poses of another one.
RecordingListing listBag(const std::string& path, const InputOptions& options);
/// Virtual KITTI 2: the folder of one scene and variation; camera 0.
RecordingListing listVirtualKitti(const std::string& folder, const InputOptions& options);

/// Whether the vertices of a .ply are things, each with a place of its own, and not samples of
/// surfaces. Edges, and properties that only graphs have (observations, extent_x), say so;
/// faces, or no label at all, say that they are not, and so do classes that are asked of shapes.
/// Else the vertices themselves tell: things have instances of their own, or are a metre and more
/// apart, or at least have neighbours of other classes; samples lie close, among their like, and
/// are many. That is a guess; if it is not a clear one, `guess`, if given, receives a sentence
/// about it. Of a cloud no more is read than it takes to know. Throws Error.
bool holdsGraph(const std::string& path, const InputOptions& options, std::string* guess = nullptr);

// What layouts share.

/// A series of numbered files: depth/000017.png.
struct FileSeries {
  std::string name;  ///< "depth", for messages
  std::string folder;
  std::vector<std::string> endings;  ///< ".png"
};

/// One frame per file of the series, in the order of the numbers in their names ("frame_17": 17),
/// else by name and numbered by position. Throws Error: no such folder, none of these files, the
/// same stem twice.
std::vector<ListedFrame> listFrames(const FileSeries& measurements);

/// Gives each frame its file of another series. Throws Error unless both have the same stems; the
/// message has both counts and a stem that is missing.
void addFiles(const std::string& recording, const FileSeries& series,
              std::string ListedFrame::*file, const std::string& measurements_name,
              std::vector<ListedFrame>& frames);

/// Number of the frame that a single file holds; 0 if its name has none.
std::int64_t frameNumberOf(const std::string& path);

/// Which line of a text file belongs to each frame, for files with one line per frame: in order if
/// there are as many lines as frames; with more lines, line `number` (from 0) belongs to frame
/// `number`. Fewer lines are an Error.
std::vector<std::size_t> linesOfFrames(const std::string& path, const std::string& what,
                                       std::size_t lines, const std::vector<std::int64_t>& numbers);
std::vector<std::int64_t> numbersOf(const std::vector<ListedFrame>& frames);

/// Stamps and poses from a file of poses (posesOfFrames).
void setPoses(const std::string& path, std::vector<ListedFrame>& frames);

// Poses as they stand in one line of a text file. `file` gives path and line of what is wrong.

/// tx ty tz qx qy qz qw; the quaternion may be off by rounding (1 %) and is normalised.
Eigen::Isometry3d poseFromTum(const double* numbers, const InputFile& file);
/// The first three rows of a 4x4 matrix, row by row; its rotation may be off by 1e-3 and is made
/// orthonormal.
Eigen::Isometry3d poseFromRows(const double* numbers, const InputFile& file);

/// Throws Error if an image differs in size from another one.
void requireSameSize(const std::string& path, std::int64_t width, std::int64_t height,
                     const std::string& other_path, int other_width, int other_height);
/// The same as soon as the header of an image is read (SizeCheck), against the depth of its frame.
std::function<void(std::int64_t, std::int64_t)> asLargeAsDepth(const std::string& path,
                                                               const ListedFrame& listed,
                                                               const Frame& frame);

// What is done about the classes of a recording of which only the ids are known; what was guessed
// is said in listing.notes.

/// How often each class id occurs.
using LabelCounts = std::map<std::uint32_t, std::uint64_t>;
/// In at most `max_frames` frames spread over the recording.
LabelCounts countLabels(const RecordingListing& listing, std::size_t max_frames);

/// Those that are named (namedLabels); else options.map_labels if it knows nearly all ids; else
/// SemanticKITTI's if they can be no others; either only if its ground is flat and below what
/// stands on it, as far as there is any; else a generic set.
void nameClasses(RecordingListing& listing, const InputOptions& options, const std::string& folder,
                 const std::optional<LabelSet>& own = std::nullopt);

/// SemanticKITTI labels exist in three id spaces that no file names: raw ids, the 19 training
/// classes counted from 1, and from 0. Ids that only one of them has decide; else
/// options.map_labels if it is of another data set, else the ground, facades and vegetation that
/// make up most of any scan. Ids of none of them are taken as by nameClasses(). LabelSet::name()
/// tells which.
void guessSemanticKittiLabels(RecordingListing& listing, const InputOptions& options);

}  // namespace xview::io
