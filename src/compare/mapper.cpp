// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include <fmt/core.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "base/label_match.h"
#include "base/pose.h"
#include "compare/self_similarity.h"
#include "localizer/query_check.h"
#include "localizer/query_in_map.h"
#include "map/contents.h"
#include "place/bev_grid.h"
#include "place/gravity.h"
#include "place/lift.h"
#include "place/measure_size.h"
#include "place/merge.h"
#include "place/odometry_check.h"
#include "place/recordings_in_one_set.h"
#include "place/shared_frames.h"
#include "place/sound_input.h"
#include "pose/distribution_map.h"
#include "search/distance_field.h"
#include "xview/base/error.h"
#include "xview/localizer.h"

namespace xview {
namespace {

constexpr double kSameUp_rad = 0.03;

/// The options that a map remembers. The number of threads changes no result, so it is none of
/// them.
std::string recordOf(Options options) {
  options.threads = Options().threads;
  return toYaml(options);
}

/// What messages call it.
std::string nameOf(const map::SemanticMap& addition) {
  return addition.sources.empty() ? "addition" : addition.sources.front();
}

/// Edges found in images and edges of a radius say different things of the same vertices.
void requireSameSpace(const map::SemanticMap& map, const map::SemanticMap& addition) {
  if (map.graph.space == addition.graph.space || map.graph.empty() || addition.graph.empty())
    return;
  throw Error(nameOf(addition), std::string("its graph_space is ") +
                                    toString(addition.graph.space) + ", that of the map is " +
                                    toString(map.graph.space));
}

/// A bare graph has no lengths of its own.
void requireSameSize(const map::SemanticMap& map, const map::SemanticMap& addition) {
  if (map.size == addition.size || addition.bev.known.empty()) return;
  throw Error(nameOf(addition), "it was made with lengths of size " + sizeText(addition.size) +
                                    " and the map with those of size " + sizeText(map.size) +
                                    "; make it again with --size " + sizeText(map.size));
}

/// Points of columns in which nothing is new stay packed.
void appendCloud(map::SemanticMap& map, const LabelledCloud& addition, double voxel_m) {
  LabelledCloud& cloud = map.cloud;
  if (map::countsOf(map).points == 0) return cloud.append(addition);
  map::unpackPointsAround(addition, map);
  const Eigen::Vector3f shift = (addition.origin - cloud.origin).cast<float>();
  for (Point point : addition.points) {
    point.getVector3fMap() += shift;
    cloud.points.push_back(point);
  }
  for (Point& point : cloud.points) point.instance = 0;  // numbers of two recordings differ
  cloud = thinByVoxel(cloud, voxel_m);
}

/// All but the sources, which are those of the map from `first_source` on.
void merge(const map::SemanticMap& given, std::uint32_t first_source, const Options& in_metres,
           map::SemanticMap& map) {
  const Options options = inCanonicalLengths(in_metres, map.size);
  const Scaled<map::SemanticMap> addition(given, 1 / map.size);
  if (map.size != kTownScale) scaleLengths(1 / map.size, map);
  map.checksum = 0;
  mergeGraphs(map.graph, addition->graph, map.labels, options.merge, options.edges);
  map::growView(addition->bev, map);
  appendCloud(map, addition->cloud, options.map.cloud_voxel_m);
  for (std::size_t i = 0; i < addition->poses.size(); ++i)
    map.addKeyframe(addition->poses[i], addition->frames[i], addition->stamps_s[i],
                    first_source + addition->source_of_pose[i]);
  if (map.size != kTownScale) scaleLengths(map.size, map);
}

/// Of a map that grows it is what it was.
void noteNoise(map::SemanticMap& map, const Options& in_metres) {
  if (map.cloud.empty() || map.stored_points) return;
  map.noise = pose::measureNoise(*Scaled<LabelledCloud>(map.cloud, 1 / map.size), map.labels,
                                 optionsOfSearch(in_metres, map.size, map.labels).refine);
}

/// A map of frames that come one by one. Of a long drive its parts are merged, and their points
/// packed: the voxels and unthinned points of a kilometre take 100 MB.
class MapBuilder {
 public:
  MapBuilder(const LabelSet& labels, const Options& options)
      : labels_(labels), options_(options), part_(newPart()) {}

  void add(PreprocessedFrame frame) {
    constexpr double kPart_m = 1000;
    if (last_) way_m_ += (frame.T_odom_sensor.translation() - *last_).norm();
    last_ = frame.T_odom_sensor.translation();
    if (way_m_ > kPart_m && frame.size == kTownScale) {
      endPart();
      if (!map_.cloud.empty()) {
        for (Point& point : map_.cloud.points) point.instance = 0;  // as of all that are merged
        map::packPoints(map_);
      }
#ifdef __GLIBC__
      malloc_trim(0);  // what the part took lies between what stays
#endif
    }
    part_->add(std::move(frame));
  }

  void endRecording(const std::string& name) {
    noteSource();
    sources_.push_back(name);
    last_.reset();
  }

  /// Afterwards the builder is empty.
  map::SemanticMap finish() {
    endPart();
    map_.sources = std::move(sources_);
    return std::move(map_);
  }

 private:
  std::unique_ptr<PlaceBuilder> newPart() const {
    return std::make_unique<PlaceBuilder>(labels_, options_, PlaceUse::map);
  }

  /// Of the poses that came since it was noted last.
  void noteSource() {
    source_of_pose_.resize(part_->endRecording(), static_cast<std::uint32_t>(sources_.size()));
  }

  void endPart() {
    noteSource();
    map::SemanticMap part;
    static_cast<Place&>(part) = part_->finish();
    part.source_of_pose = std::move(source_of_pose_);
    source_of_pose_.clear();
    part_ = newPart();
    way_m_ = 0;
    part_->setGravity(part.gravity);
    if (map_.poses.empty()) {
      map_ = std::move(part);
      noteNoise(map_, options_);
    } else {
      merge(part, 0, options_, map_);
    }
  }

  const LabelSet labels_;
  const Options options_;
  std::unique_ptr<PlaceBuilder> part_;
  double way_m_ = 0;                     ///< of the part
  std::optional<Eigen::Vector3d> last_;  ///< position, in the recording at hand
  map::SemanticMap map_;
  std::vector<std::uint32_t> source_of_pose_;  ///< of the part
  std::vector<std::string> sources_;
};

/// A map of frames that lie where they were not seen misleads all who are looked for in it.
void requireNoJump(OdometryCheck& odometry, const PreprocessedFrame& frame,
                   const std::string& name) {
  const auto jump = odometry.add(frame);
  if (const auto share = odometry.hardlyInPlace())
    throw Error(name, fmt::format("only {:.0f} % of what a scan shows lies where the scan before "
                                  "shows it, by the poses; are their quaternions w first (x y z w "
                                  "is read), are they inverse (the frame of the sensor to that of "
                                  "the odometry is read), or are stamps shifted? "
                                  "--odometry.check false if the poses are right",
                                  100 * *share));
  if (!jump) return;
  throw Error(name, fmt::format("the scans contradict its odometry, which is off by about {:.1f} m "
                                "at frame {}; map what is before and behind it by itself "
                                "(--frames) and join both (map --join), or say "
                                "--odometry.check false if the poses are right",
                                jump->off_m, jump->frame));
}

constexpr double kEnough_nats = 10;  ///< for or against: a few things that both have seen
constexpr double kClimbReach_m = 5;  ///< of a town; the climb of a search ends about there

/// What the user believes about queries says nothing about maps, and bare walks judge no pose.
Options plainSearch(Options options) {
  options.method = "search";
  options.scale.clear();
  options.prior = {};
  return options;
}

/// The map where another place lies in its frame, with a rim, as far as views are compared there.
/// What is known of distances at wrong places stays that of the whole map.
map::SemanticMap partAround(const Place& place, const map::SemanticMap& map) {
  constexpr double kRim_m = 30;  // of a town; distances are told apart up to a few metres
  Eigen::AlignedBox2d box;
  const auto middleOf = [](const GroundCell& cell, const BevGrid& bev) {
    return Eigen::Vector2d(bev.origin_x + (cell.x + 0.5) * bev.cell_m,
                           bev.origin_y + (cell.y + 0.5) * bev.cell_m);
  };
  for (const GroundCell& cell : place.bev.known) box.extend(middleOf(cell, place.bev));
  box.min().array() -= kRim_m * map.size;
  box.max().array() += kRim_m * map.size;

  map::SemanticMap part;
  part.labels = map.labels;
  part.gravity = map.gravity;
  part.sensor = map.sensor;
  part.size = map.size;
  part.null = map.null;
  part.bev = BevGrid{map.bev.cell_m,
                     map.bev.origin_x,
                     map.bev.origin_y,
                     map.bev.origin_z,
                     map.bev.alignment,
                     map.bev.aerial,
                     {},
                     {}};
  const auto view = map::viewWithin(box, map);
  for (const GroundCell& cell : view->known) {
    if (box.contains(middleOf(cell, map.bev))) part.bev.known.push_back(cell);
  }
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    for (const BevSample& s : view->samples[c]) {
      if (box.contains(Eigen::Vector2d(map.bev.origin_x + s.x, map.bev.origin_y + s.y)))
        part.bev.samples[c].push_back(s);
    }
  }
  return part;
}

double areaOf(const BevGrid& bev) {
  return bev.cell_m * bev.cell_m * static_cast<double>(bev.known.size());
}

/// The key frames of one source by their times; the first of each time.
using Drive = std::map<double, Eigen::Isometry3d>;

std::vector<Drive> drivesOf(const map::SemanticMap& map) {
  std::vector<Drive> drives(map.sources.size());
  for (std::size_t i = 0; i < map.poses.size(); ++i)
    drives[map.source_of_pose[i]].emplace(map.stamps_s[i], map.poses[i]);
  return drives;
}

/// Most key frames of the one are those of the other, at the same times with the same way between
/// them, but for what bending the odometry through fixes changes.
bool isSameDrive(const Drive& a, const Drive& b) {
  constexpr std::size_t kFewest = 4;
  constexpr double kSameTime_s = 1e-5, kLonger = 0.05, kFarther_m = 0.05, kTurn_rad = 0.02;
  std::vector<std::pair<Eigen::Isometry3d, Eigen::Isometry3d>> both;
  for (const auto& [stamp_s, pose] : a) {
    const auto found = b.lower_bound(stamp_s - kSameTime_s);
    if (found != b.end() && found->first <= stamp_s + kSameTime_s)
      both.emplace_back(pose, found->second);
  }
  if (both.size() < kFewest || 2 * both.size() < a.size()) return false;
  std::size_t same = 0;
  for (std::size_t i = 1; i < both.size(); ++i) {
    const Eigen::Isometry3d way_a = both[i - 1].first.inverse() * both[i].first,
                            way_b = both[i - 1].second.inverse() * both[i].second;
    const double off_m = (way_a.translation() - way_b.translation()).norm();
    same += off_m < kLonger * way_a.translation().norm() + kFarther_m &&
            rotationBetween(way_a, way_b) < kTurn_rad;
  }
  return 10 * same >= 9 * (both.size() - 1);
}

/// Most key frames of the one lie where the other was at their times, in one frame. Of a recording
/// that is fused again other frames may be key frames.
bool isOnItsWay(const Drive& a, const Drive& b) {
  constexpr double kFused_m = 0.5;
  std::size_t near = 0;
  for (const auto& [stamp_s, pose] : a) {
    const auto next = b.lower_bound(stamp_s);
    if (next == b.end() || (next == b.begin() && next->first > stamp_s)) continue;
    Eigen::Vector3d there = next->second.translation();
    if (next->first > stamp_s) {
      const auto last = std::prev(next);
      const double share = (stamp_s - last->first) / (next->first - last->first);
      there = last->second.translation() + share * (there - last->second.translation());
    }
    near += (pose.translation() - there).norm() < kFused_m;
  }
  return 2 * near > a.size();
}

}  // namespace

map::SemanticMap buildVisit(
    const std::vector<const FrameSource*>& sources, const Options& given, const Progress& progress,
    const std::function<void(const FrameSource&, const PreprocessedFrame&)>& seen) {
  const RecordingsInOneSet recordings(sources, given);
  const std::size_t total = recordings.frames();
  std::size_t done = 0;
  if (progress) progress(0, total);
  MapBuilder builder(recordings[0].labels(), recordings.options());
  Conversation helpers(sources);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    OdometryCheck odometry(recordings[i].labels());
    const auto take = [&](PreprocessedFrame frame) {
      if (given.odometry.check) requireNoJump(odometry, frame, recordings[i].name());
      if (seen) seen(*sources[i], frame);
      builder.add(std::move(frame));
      if (progress) progress(++done, total);
    };
    if (helpers.helpers() > 0)
      preprocessByHelpers(helpers, recordings, i, take);
    else
      preprocessRecording(recordings[i], recordings.options(), take);
    builder.endRecording(recordings[i].name());
  }
  map::SemanticMap map = builder.finish();
  map.options_yaml = recordOf(recordings.options());
  return map;
}

map::SemanticMap buildMap(
    const std::vector<const FrameSource*>& sources, const Options& options,
    const Progress& progress,
    const std::function<void(const FrameSource&, const PreprocessedFrame&)>& seen) {
  map::SemanticMap map = buildVisit(sources, options, progress, seen);
  measureNullHypothesis(map, options);
  map::roundAsStored(map);
  return map;
}

map::SemanticMap buildMap(const FrameSource& recording, const Options& options) {
  return buildMap(std::vector<const FrameSource*>{&recording}, options);
}

map::SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels,
                          const std::string& source, const Options& options) {
  requireSound(graph);
  map::SemanticMap map;
  map.labels = labels;
  map.graph = graph;
  map.size = sizeFor(options, graph);
  if (graph.edgeCount() == 0 && graph.edge_radius_m == 0)
    useRadius(map.graph, atSize(options, map.size).edges);
  map.sources = {source};
  map.options_yaml = recordOf(options);
  return map;
}

void appendToMap(map::SemanticMap& map, const map::SemanticMap& given, const Options& in_metres) {
  if (map::isPacked(given)) return appendToMap(map, map::unpacked(given), in_metres);
  map::unpackVertices(map);
  const LabelMatch match = requireCommonClasses(given.labels, nameOf(given), map.labels);
  if (!match.changesNothing()) {
    map::SemanticMap same = given;
    static_cast<Place&>(same) = translated(given, match);
    return appendToMap(map, same, in_metres);
  }
  if (map::hasView(map) && !given.bev.known.empty() &&
      map.bev.alignment.angularDistance(given.bev.alignment) > kSameUp_rad) {
    throw Error(
        nameOf(given),
        "its frame is tilted against that of the map; only recordings in one frame can be joined");
  }
  requireSameSpace(map, given);
  requireSameSize(map, given);
  const std::size_t first_pose = map.poses.size();
  merge(given, static_cast<std::uint32_t>(map.sources.size()), in_metres, map);
  map.sources.insert(map.sources.end(), given.sources.begin(), given.sources.end());
  noteNoise(map, in_metres);
  measureNullHypothesis(map, in_metres, first_pose);
}

std::optional<FrameEvidence> evidenceOfOneFrame(const map::SemanticMap& map,
                                                const map::SemanticMap& other,
                                                const Options& options) {
  if (map.size != other.size) return std::nullopt;
  const bool of_views = !other.bev.known.empty() && map.null.poses > 0 &&
                        map.bev.alignment.angularDistance(other.bev.alignment) <= kSameUp_rad;
  const map::SemanticMap part = of_views ? partAround(other, map) : map::SemanticMap();
  if (of_views && part.bev.known.empty()) return std::nullopt;
  const Localizer localizer(map::borrowed(of_views ? part : map), plainSearch(options));
  const Query query = makeQuery(other, options);
  const std::vector<Eigen::Isometry3d> as_it_is{Eigen::Isometry3d::Identity()};
  const PlaceEvidence here = localizer.check(query, as_it_is, 0)[0].evidence;
  if (std::abs(here.score) < kEnough_nats) return std::nullopt;
  const PoseCheck best = localizer.check(query, as_it_is, kClimbReach_m * map.size)[0];
  const Eigen::Vector3d sensor = query.poses.back().translation();
  return FrameEvidence{here.score, here.expected, best.evidence.score,
                       (best.T_map_query * sensor - sensor).norm(),
                       here.map_coverage * areaOf(other.bev)};
}

bool holdsSameDrive(const map::SemanticMap& map, const map::SemanticMap& other) {
  const std::vector<Drive> drives = drivesOf(map), added = drivesOf(other);
  for (std::size_t i = 0; i < added.size(); ++i) {
    for (std::size_t k = 0; k < drives.size(); ++k) {
      if (isSameDrive(added[i], drives[k]) ||
          (other.sources[i] == map.sources[k] && isOnItsWay(added[i], drives[k])))
        return true;
    }
  }
  return false;
}

Query makeQuery(map::SemanticMap map, const Options& options) {
  Query query = static_cast<Place&&>(map);
  query.gravity = gravityOf(query, options.gravity);
  query.sensor = Sensor::cloud;
  query.timing_ms.clear();
  query.frames.clear();  // those of several recordings are in no order
  query.stamps_s.clear();
  if (query.poses.empty()) query.poses.push_back(Eigen::Isometry3d::Identity());
  return query;
}

}  // namespace xview
