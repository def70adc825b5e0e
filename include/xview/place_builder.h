// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xview/base/graph.h"
#include "xview/base/semantic_place.h"
#include "xview/options.h"

namespace xview {

class BevGridBuilder;
class OdometryCheck;
class PlaceGraphBuilder;
struct StoreyOfPlace;

/// The name of the label set of classes from shapes.
constexpr const char* kShapes = "shapes";
inline bool knowsShapesOnly(const LabelSet& labels) { return labels.name() == kShapes; }

/// A recording with the classes that maps and queries are made of: its own, with
/// withRolesByShape(); those of shapes if it has none, or if the map knows nothing else. The
/// recording must outlive the result.
std::unique_ptr<const FrameSource> withClasses(const FrameSource& recording, const Options& options,
                                               const LabelSet* of_map = nullptr);

/// Called after each frame with (done, total). May be empty.
using Progress = std::function<void(std::size_t, std::size_t)>;

/// What became of the measurements of a frame.
struct LiftCounts {
  std::uint64_t lifted = 0;
  std::uint64_t no_depth = 0;  ///< depth not positive, NaN or infinite
  std::uint64_t out_of_range = 0;
  std::uint64_t ignored_class = 0;                 ///< role ignored or id unknown to the label set
  std::map<std::uint32_t, std::uint64_t> unknown;  ///< of those the ones that the set does not know
  std::uint64_t all() const { return lifted + no_depth + out_of_range + ignored_class; }
  LiftCounts& operator+=(const LiftCounts& other);
};

/// A preprocessed frame: what later stages need of it, small enough to keep for a whole recording.
/// In the odometry frame, at canonical scale (base/semantic_place.h).
struct PreprocessedFrame {
  double size = 1;  ///< scale: its lengths times this are metres
  std::int64_t number = 0;
  double stamp_s = 0;
  Sensor sensor = Sensor::camera;
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  Eigen::Vector3d up_sensor = Eigen::Vector3d::Zero();  ///< see Frame
  LabelledCloud cloud;                                  ///< lifted, one point per voxel and class
  std::vector<float> weights;       ///< per point, by measurements in its voxel and by range
  std::vector<bool> resolves_thin;  ///< per point: measured near enough to resolve thin objects
  bool aerial = false;              ///< a camera that looks down from the air
  std::vector<Blob> blobs;
  BlobEdges blob_edges;  ///< image space only (options.graph_space)
  LiftCounts counts;
  Timings timing_ms;  ///< read, lift, blobs
};

bool isImageSpace(const Options& options);      ///< options.graph_space
bool usesImageRegions(const Options& options);  ///< blobs come from label images

/// Image space (options.graph_space) is for depth and label images: UsageError for another sensor,
/// naming the recording.
void requireGraphSpace(const Options& options, Sensor sensor, const std::string& recording);

/// One frame through lift, clean and blobs, of the size that options.size says. One frame
/// tells no size, so auto is canonical scale here. Throws Error if there are no classes, without
/// which nothing of it would be left (see withClasses), and UsageError if options.graph_space is
/// image and the frame has no images.
PreprocessedFrame preprocessFrame(Frame frame, const LabelSet& labels, const Options& options);

/// All frames of a recording, read and preprocessed on options.threads threads, in order.
std::vector<PreprocessedFrame> preprocessRecording(const FrameSource& source,
                                                   const Options& options,
                                                   const Progress& progress = {});

/// The same one by one, in order, on the caller's thread: only a few of them are in memory at a
/// time.
void preprocessRecording(const FrameSource& source, const Options& options,
                         const std::function<void(PreprocessedFrame)>& take);

/// What a place is made for. The graph and the BEV grid are the same for both.
enum class PlaceUse {
  query,  ///< with all poses, and the points of the last metres of travel as they were seen
  map     ///< with key frames, and all points, thinned
};

/// Makes a place of frames that come one by one, in the frame of their odometry. Only those of the
/// last metres of a query are kept; memory follows the place, not the number of frames. The first
/// frames tell together which way is up, and wait until they do. A query whose odometry jumps
/// begins again behind the jump (Place::jumps), as what is reported is the pose of its last frame.
class PlaceBuilder {
 public:
  /// Number of frames that estimate gravity unless the caller knows how many there are.
  static constexpr std::size_t kFramesForGravity = 16;
  using SharedFrame = std::shared_ptr<const PreprocessedFrame>;

  PlaceBuilder(const LabelSet& labels, const Options& options, PlaceUse use,
               std::size_t frames_for_gravity = kFramesForGravity);
  PlaceBuilder(PlaceBuilder&&) noexcept;
  PlaceBuilder& operator=(PlaceBuilder&&) noexcept;
  ~PlaceBuilder();

  void add(SharedFrame frame);
  void add(PreprocessedFrame frame) {
    add(std::make_shared<const PreprocessedFrame>(std::move(frame)));
  }
  /// A recording is over: frames that wait are all that tell which way is up, and the next frame
  /// is a key frame. Returns how many poses the place has.
  std::size_t endRecording();
  /// Afterwards the builder is empty.
  Place finish();

  /// For a place in the frame of another one, before its first frame: no frame waits.
  void setGravity(const Gravity& gravity);

 private:
  struct Recent {
    SharedFrame frame;
    double travelled_m;  ///< until this frame
  };
  void beginBehind(const OdometryJump& jump);
  std::shared_ptr<const Place> newestPart() const;
  void takePose(const PreprocessedFrame& frame);
  void takePoints(const SharedFrame& frame);
  void thinPoints();
  void estimateAlignment();
  void addAligned(const PreprocessedFrame& frame);
  void drawGraph(const std::vector<StoreyOfPlace>& storeys);
  void finishPoints(const std::vector<StoreyOfPlace>& storeys);

  Options given_, options_;  ///< in metres, at canonical scale
  PlaceUse use_;
  std::size_t frames_for_gravity_;
  std::unique_ptr<OdometryCheck> odometry_;  ///< of a query
  std::size_t first_told_ = 0;  ///< pose of a query from which on the scans tell each step
  std::unique_ptr<PlaceGraphBuilder> graph_;
  std::unique_ptr<BevGridBuilder> bev_;
  Place place_;
  std::vector<SharedFrame> waiting_;  ///< until it is known which way is up
  bool is_aligned_ = false;
  bool is_new_recording_ = true;
  std::deque<Recent> recent_;  ///< frames of the last metres of a query
  double travelled_m_ = 0;
  std::size_t thinned_size_ = 0;  ///< points of a map after they were thinned last
  double graph_ms_ = 0;
};

/// What is to be found in a map: a place in its own odometry frame.
using Query = Place;

/// A query from a window of frames, which tell all together which way is up.
Query makeQuery(const PreprocessedFrame* first, const PreprocessedFrame* last,
                const LabelSet& labels, const Options& options);
/// A query from a whole recording, frame by frame (PlaceBuilder). A recording without labels gets
/// classes from the shapes of its points (withClasses). `seen` is called with every frame, in
/// order.
Query makeQuery(const FrameSource& source, const Options& options,
                const std::function<void(const PreprocessedFrame&)>& seen = {});
/// A query from a bare graph.
Query makeQuery(const SemanticGraph& graph, const LabelSet& labels, const Options& options);

}  // namespace xview
