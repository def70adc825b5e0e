// SPDX-License-Identifier: BSD-3-Clause
#include "inputs.h"

#include <fmt/core.h>

#include <map>

#include "classes.h"
#include "io/graph_files.h"
#include "map/contents.h"
#include "place/depth_plausibility.h"
#include "place/edges.h"
#include "place/lift.h"
#include "place/measure_size.h"
#include "place/raw_recording.h"
#include "place/smooth_depth.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"
#include "xview/base/localization.h"
#include "xview/io/label_files.h"
#include "xview/map/semantic_map.h"
#include "xview/options.h"

namespace xview::tools {
namespace {

/// What its reader says of it.
void logNotes(const FrameSource& source, const Narrative& narrate) {
  for (const std::string& note : source.notes()) narrate.note(source.name() + ": " + note);
}

/// Lengths that may be no metres, an axis that may be up.
void logConsistencyChecks(const std::string& path, const Place& place, const Narrative& narrate) {
  for (const auto& problem : {checkMetres(place), checkUpright(place)})
    if (problem) narrate.note(path + ": " + *problem);
}

void logShares(const std::string& path, const ShapeShares& shares, const LabelSet& shapes,
               const std::string& labels, const Narrative& narrate) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] >= 0.005) order.push_back(i);
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return shares[a] > shares[b]; });
  if (order.empty()) return;
  std::string text = path + ": " + labels + "; classes from shapes:";
  for (const std::size_t i : order) {
    text += fmt::format("{} {} {:.0f} %", i == order[0] ? "" : ",",
                        shapes.className(static_cast<std::uint32_t>(i)), 100 * shares[i]);
  }
  narrate.noteFirst(labels, text);
}

/// What has no labels gets them from shapes.
std::unique_ptr<FrameSource> openWithLabels(const std::string& path,
                                            const io::InputOptions& options, const Job& job) {
  const Progress reading = job.narrate.busy("read");
  std::unique_ptr<FrameSource> source = io::openRecording(path, options);
  const bool has_labels = !source->labels().empty();
  if (has_labels && options.labels != kShapes) return source;
  const LabelSet shapes = io::shippedLabelSet(kShapes);
  ShapeShares shares{};
  source = withShapeLabels(std::move(source), shapes, job.options, &shares);
  const bool is_told = !options.labels.empty() && options.labels != kShapes;
  logShares(path, shares, shapes,
            has_labels ? "labels are left aside"
            : is_told
                ? fmt::format("no labels of '{}', --label-field names their field", options.labels)
                : "no labels",
            job.narrate);
  return source;
}

/// In a map from shapes classes come from shapes, whatever labels the query has.
io::InputOptions queryIn(const InputFlags& input, const LabelSet& map_labels) {
  io::InputOptions options = inputIn(input, map_labels);
  if (map_labels.name() == kShapes) options.labels = kShapes;
  return options;
}

/// Position of the first frame that is at most this many metres of travel before the last one.
std::size_t firstWithin(const FrameSource& source, double length_m) {
  std::size_t first = source.size();
  double travelled = 0;
  while (first > 1 && travelled <= length_m) {
    --first;
    travelled += (source.pose(first).translation() - source.pose(first - 1).translation()).norm();
  }
  return travelled > length_m ? first : 0;
}

}  // namespace

io::InputOptions InputFlags::parsed() const {
  if (given_) return *given_;
  io::InputOptions options;
  options.kind = kind_;
  options.labels = labels_;
  options.label_field = label_field_;
  options.instance_field = instance_field_;
  options.mount = mount_;
  options.topic = topic_;
  options.odometry = odometry_;
  if (!class_names_.empty()) options.class_names = io::readClassNames(class_names_);
  if (!frames_.empty()) options.frames = io::parseFrameRange(frames_);
  return options;
}

std::unique_ptr<FrameSource> openInput(const std::string& path, const io::InputOptions& options,
                                       const Job& job) {
  std::unique_ptr<FrameSource> source = openWithLabels(path, options, job);
  logNotes(*source, job.narrate);
  const bool is_of_map = options.map_labels && source->labels() == *options.map_labels;
  if (!is_of_map && source->labels().name() != kShapes)
    logGuesses(path, source->labels(), job.narrate);
  return source;
}

std::unique_ptr<FrameSource> openInOwnClasses(const std::string& path,
                                              const io::InputOptions& options, const Job& job) {
  std::unique_ptr<FrameSource> source = openWithLabels(path, options, job);
  logNotes(*source, job.narrate);
  if (source->labels().name() == kShapes) return source;  // they meet those of a map by kind
  if (options.map_labels && source->labels() == *options.map_labels) return source;
  source = withRolesByShape(std::move(source), job.options.lift, job.options.threads,
                            options.map_labels ? &*options.map_labels : nullptr);
  logGuesses(path, source->labels(), job.narrate);
  tellHowClassesMeet(source->name(), source->labels(), options, job.narrate);
  return source;
}

std::unique_ptr<FrameSource> openPlaceInput(const std::string& path,
                                            const io::InputOptions& options, const Job& job) {
  return inClassesOfMap(openInOwnClasses(path, options, job), options);
}

io::InputOptions inputIn(const InputFlags& input, const LabelSet& map_labels) {
  io::InputOptions options = input.parsed();
  options.map_labels = map_labels;
  return options;
}

Job inMap(Job job, const map::SemanticMap& map) {
  const std::string size = sizeText(map.size);
  const auto asked = parseSize(job.options.size);
  if (asked && *asked != map.size)
    job.narrate.note("the map has lengths of size " + size +
                     ", and so has what is looked for in it");
  job.options.size = size;
  return job;
}

io::InputKind chooseKind(const std::string& path, io::InputOptions& options, const Job& job) {
  std::string guess;
  const io::InputKind kind = io::recogniseInput(path, options, &guess);
  if (!guess.empty()) job.narrate.note(path + ": " + guess);
  if (kind == io::InputKind::graph || kind == io::InputKind::cloud) options.kind = toString(kind);
  return kind;
}

Place readLabelledGraph(const std::string& path, const io::InputOptions& input, const Job& job) {
  io::GraphFile file = io::readGraph(path);
  if (file.graph.empty()) throw Error(path, "the graph has no vertices");
  if (!file.has_edges)
    useRadius(file.graph, atSize(job.options, sizeFor(job.options, file.graph)).edges);
  Place place;
  place.labels = labelsOfGraph(path, file.graph, file.labels, input, job.narrate);
  place.graph = std::move(file.graph);
  return place;
}

std::optional<Place> readStored(const std::string& path, io::InputOptions& input, const Job& job) {
  const io::InputKind kind = chooseKind(path, input, job);
  if (kind == io::InputKind::map) return map::unpacked(map::openMap(path));
  if (kind == io::InputKind::graph) return readLabelledGraph(path, input, job);
  return std::nullopt;
}

map::SemanticMap mapOfRecordings(
    const std::vector<const FrameSource*>& sources, const Job& job, RecordingsUse use,
    const std::function<void(const FrameSource&, const PreprocessedFrame&)>& seen) {
  std::map<const FrameSource*, LiftCounts> counts;
  const auto count = [&](const FrameSource& source, const PreprocessedFrame& frame) {
    counts[&source] += frame.counts;
    if (seen) seen(source, frame);
  };
  const Progress progress = job.narrate.progress("map");
  map::SemanticMap map = use == RecordingsUse::map
                             ? buildMap(sources, job.options, progress, count)
                             : buildVisit(sources, job.options, progress, count);
  for (const FrameSource* source : sources) logLeftOut(*source, counts[source], job.narrate);
  logConsistencyChecks(sources[0]->name(), map, job.narrate);
  return map;
}

map::SemanticMap mapOf(const std::string& path, io::InputOptions input, const Job& job,
                       const std::optional<Eigen::Isometry3d>& T_map_input) {
  switch (chooseKind(path, input, job)) {
    case io::InputKind::map:
      return map::unpacked(map::openMap(path));
    case io::InputKind::graph: {
      Place file = readLabelledGraph(path, input, job);
      for (Vertex& vertex : file.graph.vertices) {
        if (T_map_input) vertex.position = *T_map_input * vertex.position;
      }
      map::SemanticMap map = buildMap(file.graph, file.labels, path, job.options);
      logConsistencyChecks(path, map, job.narrate);
      return map;
    }
    default: {
      const std::unique_ptr<FrameSource> source = openPlaceInput(path, input, job);
      if (!T_map_input) return mapOfRecordings({source.get()}, job);
      const PosedRecording moved(*source, *T_map_input);
      return mapOfRecordings({&moved}, job);
    }
  }
}

void requireNotEmpty(const map::SemanticMap& map, const std::string& path) {
  const map::Counts counts = map::countsOf(map);
  if (counts.vertices == 0 && counts.points == 0)
    throw Error(path, "the map is empty; build it of a recording that sees something");
}

std::string contentsText(const map::SemanticMap& map) {
  const map::Counts counts = map::countsOf(map);
  return fmt::format("{} vertices, {} key frames, {} points", counts.vertices, map.poses.size(),
                     counts.points);
}

map::SemanticMap readMap(const std::string& path, const InputFlags& input, const Job& job) {
  Stopwatch watch;
  io::InputOptions whole = input.parsed();
  whole.frames = {};  // --frames speaks of the query
  if (!input.mapLabels().empty()) whole.labels = input.mapLabels();
  map::SemanticMap map = chooseKind(path, whole, job) == io::InputKind::map
                             ? map::openMap(path)
                             : mapOf(path, whole, job);
  requireNotEmpty(map, path);
  job.narrate.stage("map", watch.lap_ms(), fmt::format("{}: {}", path, contentsText(map)));
  return map;
}

map::SemanticMap readWholeMap(const std::string& path, const InputFlags& input, const Job& job) {
  return map::unpacked(readMap(path, input, job));
}

std::vector<Eigen::Isometry3d> QueryInput::poses() const {
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; source && i < source->size(); ++i) poses.push_back(source->pose(i));
  return poses;
}

LabelMatch QueryInput::inMap() const { return {labels, *options.map_labels, options.class_names}; }

QueryInput openQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels) {
  QueryInput result;
  result.path = path;
  io::InputOptions& options = result.options = queryIn(input, map_labels);
  const io::InputKind kind = chooseKind(path, options, job);
  if (kind == io::InputKind::map)
    result.whole = makeQuery(map::unpacked(map::openMap(path)), job.options);
  if (kind == io::InputKind::graph) {
    const Place file = readLabelledGraph(path, options, job);
    result.whole = makeQuery(file.graph, file.labels, job.options);
  }
  if (result.whole) {
    tellHowClassesMeet(path, *result.whole, options, job.narrate);
    if (kind == io::InputKind::graph) logConsistencyChecks(path, *result.whole, job.narrate);
  } else {
    result.source = openInOwnClasses(path, options, job);
    if (result.size() == 0) throw Error(path, "no frames");
  }
  result.labels = result.whole ? result.whole->labels : result.source->labels();
  return result;
}

namespace {

/// A query of which nothing was read, at the last pose of its recording.
Query unseen(const QueryInput& input) {
  Query query;
  const FrameSource* source = input.source.get();
  query.poses.push_back(source ? source->pose(source->size() - 1) : Eigen::Isometry3d::Identity());
  return query;
}

void readWhole(const std::string& path, const InputFlags& input, const Job& job,
               const LabelSet& map_labels, double last_m, QueryInput& result) {
  result = openQuery(path, input, job, map_labels);
  if (result.whole) return;
  const FrameSource* source = result.source.get();
  std::unique_ptr<FrameSource> end;
  result.used_from = last_m > 0 ? firstWithin(*source, last_m) : 0;
  if (result.used_from > 0) {
    job.narrate.note(
        fmt::format("{}: its last {:g} m tell where it ends (--last)", source->name(), last_m));
    io::InputOptions options = result.options;
    options.frames.begin += result.used_from * options.frames.step;
    end = openInOwnClasses(path, options, job);
    source = end.get();
  }
  FrameReport report(*source, job.narrate, result.inMap());
  result.whole =
      makeQuery(*source, job.options, [&](const PreprocessedFrame& frame) { report.add(frame); });
  report.say();
  logConsistencyChecks(path, *result.whole, job.narrate);
}

}  // namespace

QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels, double last_m) {
  QueryInput result;
  if (cutByBudget([&] { readWhole(path, input, job, map_labels, last_m, result); })) {
    result.path = path;
    result.whole = unseen(result);
  }
  return result;
}

void forEachWindow(const QueryInput& input, const std::vector<Window>& windows, const Job& job,
                   const std::function<void(const Query&, const Window&)>& take) {
  FrameReport report(*input.source, job.narrate, input.inMap());
  std::vector<PreprocessedFrame> kept;  // the last of them is the one that was read last
  auto next = windows.begin();
  Options options = job.options;
  if (job.limits.memory_mb > 0) options.threads = 1;  // else later frames need memory, too
  preprocessRecording(*input.source, options, [&](PreprocessedFrame frame) {
    report.add(frame);
    kept.push_back(std::move(frame));
    for (; next != windows.end() && next->last == report.added(); ++next) {
      const PreprocessedFrame* end = kept.data() + kept.size();
      const Budget budget(job.limits);
      Query query = unseen(input);
      cutByBudget([&] {
        query = makeQuery(end - (next->last - next->first), end, input.labels, job.options);
      });
      take(query, *next);
    }
    const std::size_t first = next == windows.end() ? input.size() : next->first;
    const std::size_t before = report.added() - kept.size();  // frames that are kept no more
    if (first > before)
      kept.erase(kept.begin(),
                 kept.begin() + static_cast<std::ptrdiff_t>(std::min(first - before, kept.size())));
  });
  report.say();
}

void checkOrder(const std::vector<std::string>& operands, const InputFlags& input) {
  const std::string& last = operands.back();
  const auto map = std::find_if(operands.begin(), operands.end() - 1, map::isMapFile);
  if (map == operands.end() - 1) return;
  const io::InputKind kind = io::recogniseInput(last, input.parsed());
  if (kind == io::InputKind::map || kind == io::InputKind::graph) return;
  throw UsageError(fmt::format(
      "{} is a map and {} a recording: the operands are QUERY... MAP, the map comes last", *map,
      last));
}

LabelledCloud liftAll(const FrameSource& source, const Job& job, double voxel_m,
                      LiftCounts* counts) {
  struct Lifted {
    LabelledCloud cloud;
    LiftCounts counts;
    Eigen::Vector3d sensor;
  };
  LabelledCloud whole;
  LiftCounts sum;
  DepthPlausibility depths;
  forEachFrame(
      source, job, "lift",
      [&](const Frame& frame) {
        Lifted lifted;
        lifted.sensor = frame.T_odom_sensor.translation();
        lifted.cloud = lift(frame, source.labels(), job.options.lift, &lifted.counts);
        setSigmas(inverseDepthNoise(frame.depth), lifted.sensor, lifted.cloud);
        return lifted;
      },
      [&](const Lifted& lifted) {
        depths.add(lifted.counts, lifted.cloud, lifted.sensor);
        whole.append(lifted.cloud);
        sum += lifted.counts;
      });
  depths.require(source);
  logLeftOut(source, sum, job.narrate);
  if (counts) *counts = sum;
  if (voxel_m > 0) whole = thinByVoxel(whole, voxel_m);
  return whole;
}

}  // namespace xview::tools
