// SPDX-License-Identifier: BSD-3-Clause
#include "xview/place_builder.h"

#include <algorithm>
#include <utility>

#include "base/in_order.h"
#include "base/stray_points.h"
#include "place/bev_grid.h"
#include "place/edges.h"
#include "place/gravity.h"
#include "place/measure_size.h"
#include "place/merge.h"
#include "place/odometry_check.h"
#include "place/point_quality.h"
#include "place/raw_recording.h"
#include "place/sound_input.h"
#include "place/storeys.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"

namespace xview {
namespace {

/// Distance between the sensor poses that a map remembers [m]: they are drawn, and the last one is
/// answered when the map itself is the query.
constexpr double kKeyframeEvery_m = 2;

/// Frames of a query from which on most of it may be of before its odometry went wrong.
constexpr std::size_t kFewestToDoubt = 3;

/// The points of a map are thinned when their number has doubled since the last time, and grown by
/// this.
constexpr std::size_t kSlackPoints = 500000;
/// Frames a little farther back are kept, too: sums of path lengths depend on where they begin.
constexpr double kWayRounding_m = 0.01;
/// If the typical standard deviation of the accurate points is more than this share of the limit
/// refine.max_sigma_m, they are the tail of a distribution of inaccurate ones.
constexpr double kEdge = 0.6;

double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace

namespace {

/// Lists of a frame that somebody made by hand may be too short.
void requireWhole(const PreprocessedFrame* frame) {
  if (frame == nullptr) throw UsageError("a frame is null");
  const std::size_t points = frame->cloud.size(), blobs = frame->blobs.size();
  if (frame->weights.size() < points || frame->resolves_thin.size() < points)
    throw UsageError(
        "a frame has fewer weights than points; preprocessFrame() makes one that is whole");
  for (const auto& [a, b] : frame->blob_edges) {
    if (a >= blobs || b >= blobs) throw UsageError("a frame has edges to blobs that there are not");
  }
}

}  // namespace

bool isImageSpace(const Options& options) { return options.graph_space == "image"; }
bool usesImageRegions(const Options& options) { return options.graph_space != "cloud"; }

void requireGraphSpace(const Options& options, Sensor sensor, const std::string& recording) {
  if (!usesImageRegions(options) || sensor == Sensor::camera) return;
  throw UsageError("graph_space = " + options.graph_space + " needs depth and label images, but " +
                   recording + (sensor == Sensor::lidar ? " holds LiDAR scans" : " is a cloud") +
                   "; use graph_space = cloud");
}

PlaceBuilder::PlaceBuilder(const LabelSet& labels, const Options& options, PlaceUse use,
                           std::size_t frames_for_gravity)
    : given_(options),
      options_(inCanonicalLengths(options, parseSize(options.size).value_or(kTownScale))),
      use_(use),
      frames_for_gravity_(frames_for_gravity) {
  place_.labels = labels;
  place_.size = parseSize(options.size).value_or(kTownScale);
  graph_ = std::make_unique<PlaceGraphBuilder>(labels, options_.merge);
  bev_ = std::make_unique<BevGridBuilder>(labels);
  if (use == PlaceUse::query && options.odometry.check)
    odometry_ = std::make_unique<OdometryCheck>(labels);
}
PlaceBuilder::PlaceBuilder(PlaceBuilder&&) noexcept = default;
PlaceBuilder& PlaceBuilder::operator=(PlaceBuilder&&) noexcept = default;
PlaceBuilder::~PlaceBuilder() = default;

void PlaceBuilder::add(SharedFrame frame) {
  requireWhole(frame.get());
  if (frame->size != place_.size)
    throw UsageError("a frame of size " + sizeText(frame->size) + " in a place of size " +
                     sizeText(place_.size) + "; set options.size for both");
  Stopwatch watch;
  for (const auto& [stage, ms] : frame->timing_ms) valueOf(place_.timing_ms, stage) += ms;
  if (odometry_) {
    if (const auto jump = odometry_->add(*frame)) beginBehind(*jump);
    if (!odometry_->tellsLastStep()) first_told_ = place_.poses.size();
  }
  takePose(*frame);
  takePoints(frame);
  if (is_aligned_) {
    addAligned(*frame);
  } else {
    waiting_.push_back(std::move(frame));
    if (waiting_.size() == frames_for_gravity_) estimateAlignment();
  }
  graph_ms_ += watch.lap_ms();
}

void PlaceBuilder::beginBehind(const OdometryJump& jump) {
  Place place;
  place.labels = std::move(place_.labels);
  place.size = place_.size;
  place.timing_ms = std::move(place_.timing_ms);
  place.jumps = std::move(place_.jumps);
  place.jumps.push_back(jump);
  place_ = std::move(place);
  graph_ = std::make_unique<PlaceGraphBuilder>(place_.labels, options_.merge);
  bev_ = std::make_unique<BevGridBuilder>(place_.labels);
  waiting_.clear();
  recent_.clear();
  is_aligned_ = false;
  is_new_recording_ = true;
  travelled_m_ = 0;
  first_told_ = 0;
}

std::size_t PlaceBuilder::endRecording() {
  if (!is_aligned_) estimateAlignment();
  is_new_recording_ = true;
  return place_.poses.size();
}

Place PlaceBuilder::finish() {
  Stopwatch watch;
  endRecording();
  askBudget("the view from above");
  place_.bev = bev_->build(place_.size >= kTownScale && place_.sensor != Sensor::camera);
  place_.bev.alignment = place_.gravity.alignment;
  std::vector<StoreyOfPlace> storeys;
  if (use_ == PlaceUse::map) {
    thinPoints();
    storeys = storeysOf(place_);
  }
  askBudget("the graph");
  drawGraph(storeys);
  if (odometry_ && place_.poses.size() >= kFewestToDoubt) place_.newest = newestPart();
  finishPoints(storeys);
  if (use_ == PlaceUse::query && place_.poses.empty())
    place_.poses.push_back(Eigen::Isometry3d::Identity());  // nothing was seen, from nowhere
  if (place_.size != kTownScale) scaleLengths(place_.size, place_);
  place_.timing_ms.emplace_back("graph", graph_ms_ + watch.lap_ms());
  return std::move(place_);
}

/// The last frame, or all behind a step that the scans do not tell.
std::shared_ptr<const Place> PlaceBuilder::newestPart() const {
  PlaceBuilder alone(place_.labels, given_, PlaceUse::query, 1);
  alone.odometry_.reset();
  alone.setGravity(place_.gravity);
  const std::size_t count = first_told_ == 0 ? 1 : place_.poses.size() - first_told_;
  for (std::size_t i = recent_.size() - std::min(count, recent_.size()); i < recent_.size(); ++i)
    alone.add(recent_[i].frame);
  return std::make_shared<const Place>(alone.finish());
}

void PlaceBuilder::setGravity(const Gravity& gravity) {
  place_.gravity = gravity;
  is_aligned_ = true;
}

void PlaceBuilder::takePose(const PreprocessedFrame& frame) {
  place_.sensor = frame.sensor;
  const bool is_key = use_ == PlaceUse::query || is_new_recording_ ||
                      distance(place_.poses.back(), frame.T_odom_sensor) >= kKeyframeEvery_m;
  if (!is_key) return;
  if (!place_.poses.empty()) travelled_m_ += distance(place_.poses.back(), frame.T_odom_sensor);
  place_.poses.push_back(frame.T_odom_sensor);
  place_.frames.push_back(frame.number);
  place_.stamps_s.push_back(frame.stamp_s);
  is_new_recording_ = false;
}

/// The points of a map at once, those of a query when it is known where it ends.
void PlaceBuilder::takePoints(const SharedFrame& frame) {
  if (use_ == PlaceUse::query) {
    recent_.push_back({frame, travelled_m_});
    while (travelled_m_ - recent_.front().travelled_m > options_.refine.reach_m + kWayRounding_m)
      recent_.pop_front();
  } else if (!frame->cloud.empty()) {
    if (place_.cloud.empty()) place_.cloud.origin = frame->cloud.origin;
    appendKnownPoints(frame->cloud, options_.refine.max_sigma_m, kNoView, place_.cloud);
    if (place_.cloud.size() > 2 * thinned_size_ + kSlackPoints) thinPoints();
  }
}

void PlaceBuilder::thinPoints() {
  place_.cloud = thinByVoxel(place_.cloud, options_.map.cloud_voxel_m);
  thinned_size_ = place_.cloud.size();
}

void PlaceBuilder::estimateAlignment() {
  place_.gravity = gravityOf(waiting_, place_.labels, options_.gravity);
  is_aligned_ = true;
  for (const SharedFrame& frame : waiting_) addAligned(*frame);
  waiting_ = {};
}

void PlaceBuilder::addAligned(const PreprocessedFrame& frame) {
  if (usesImageRegions(options_)) {
    graph_->addImageBlobs(frame.blobs, frame.blob_edges, frame.number);
  } else {
    graph_->add(frame.blobs, frame.number);
    graph_->addSurfacePoints(frame.cloud, frame.number);
  }
  if (place_.gravity.known)
    bev_->add(frame.cloud, frame.weights, frame.resolves_thin,
              Eigen::Isometry3d(place_.gravity.alignment), frame.aerial);
}

/// Thin objects stand where the BEV grid has them, unless the graph is made as in the paper.
void PlaceBuilder::drawGraph(const std::vector<StoreyOfPlace>& storeys) {
  place_.graph = graph_->graph();
  if (isImageSpace(options_)) return;
  place_.graph.space = GraphSpace::cloud;
  if (!usesImageRegions(options_) && options_.merge.mode == "running_mean") {
    if (storeys.empty())
      placeThinObjects(place_.graph, place_.bev, place_.labels);
    else
      placeThinObjects(storeys, place_);
  }
  useRadius(place_.graph, options_.edges);
}

/// Points of a query: those of the frames of the last refine.reach_m metres of travel, last frame
/// first. Those of a map are thinned before. Both without points that are less accurate than their
/// neighbours.
void PlaceBuilder::finishPoints(const std::vector<StoreyOfPlace>& storeys) {
  if (!recent_.empty()) place_.cloud.origin = recent_.back().frame->cloud.origin;
  auto view = static_cast<std::uint32_t>(place_.poses.size());
  double travelled = 0;
  while (!recent_.empty() && travelled <= options_.refine.reach_m) {
    const SharedFrame frame = std::move(recent_.back().frame);
    recent_.pop_back();
    appendKnownPoints(frame->cloud, options_.refine.max_sigma_m, --view, place_.cloud);
    if (!recent_.empty())
      travelled += distance(frame->T_odom_sensor, recent_.back().frame->T_odom_sensor);
  }
  // Depths whose error is just below the limit were measured too short by chance: as from the air,
  // where all ground is equally far. They would lift it by that error.
  if (use_ == PlaceUse::query && place_.cloud.typicalSigma() > kEdge * options_.refine.max_sigma_m)
    place_.cloud.points.clear();
  keepBestMeasured(place_.cloud);
  if (!storeys.empty())
    dropContradicted(storeys, place_);
  else if (place_.gravity.known && !place_.bev.aerial)
    dropContradicted(place_.bev, place_.labels, place_.cloud);
}

namespace {

Options ofSize(double size, Options options) {
  options.size = sizeText(size);
  return options;
}

}  // namespace

Query makeQuery(const PreprocessedFrame* first, const PreprocessedFrame* last,
                const LabelSet& labels, const Options& options) {
  const Options sized = first == last ? options : ofSize(first->size, options);
  PlaceBuilder place(labels, sized, PlaceUse::query, static_cast<std::size_t>(last - first));
  for (const PreprocessedFrame* frame = first; frame != last; ++frame) {
    // Owned by the caller, who waits.
    place.add(PlaceBuilder::SharedFrame(PlaceBuilder::SharedFrame(), frame));
  }
  return place.finish();
}

Query makeQuery(const FrameSource& source, const Options& options,
                const std::function<void(const PreprocessedFrame&)>& seen) {
  const auto classified = withClasses(source, options);
  const Options sized =
      ofSize(sizeFor(options, std::vector<const FrameSource*>{classified.get()}), options);
  PlaceBuilder place(classified->labels(), sized, PlaceUse::query);
  preprocessRecording(*classified, sized, [&](PreprocessedFrame frame) {
    if (seen) seen(frame);
    place.add(std::move(frame));
  });
  return place.finish();
}

Query makeQuery(const SemanticGraph& graph, const LabelSet& labels, const Options& options) {
  Stopwatch watch;
  requireSound(graph);
  Query query;
  query.labels = labels;
  query.graph = graph;
  query.size = sizeFor(options, graph);
  if (graph.edgeCount() == 0 && graph.edge_radius_m == 0)
    useRadius(query.graph, atSize(options, query.size).edges);
  query.gravity = gravityOf(graph, labels, options.gravity);
  const Eigen::AlignedBox3d seen =
      boxWithoutStrays(graph.size(), [&](std::size_t i) { return graph.vertices[i].position; });
  query.poses.emplace_back(Eigen::Translation3d(standpoint(Eigen::Vector3d::Zero(), seen)));
  query.timing_ms.emplace_back("graph", watch.lap_ms());
  return query;
}

}  // namespace xview
