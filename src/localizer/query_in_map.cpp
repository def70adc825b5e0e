// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/query_in_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/channel_moves.h"
#include "base/label_match.h"
#include "base/pose.h"
#include "base/stray_points.h"
#include "localizer/query_check.h"
#include "map/contents.h"
#include "place/gravity.h"
#include "place/raw_recording.h"
#include "place/shapes.h"
#include "place/sound_input.h"
#include "search/likelihoods.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"
#include "xview/options.h"

namespace xview {
namespace {

bool isTurn(const Eigen::Quaterniond& R) {
  return R.angularDistance(Eigen::Quaterniond::Identity()) > 0;
}

/// The points of a map are turned as they are, not packed.
void unpack(Place&) {}
void unpack(map::SemanticMap& map) {
  map::unpackPoints(map);
  map::unpackView(map);
  map::unpackVertices(map);
}

template <class PlaceOrMap>
PlaceOrMap turned(PlaceOrMap place, const Eigen::Quaterniond& R) {
  unpack(place);
  for (Vertex& v : place.graph.vertices) v.position = R * v.position;
  const Eigen::Matrix3f R_float = R.toRotationMatrix().cast<float>();
  for (Point& p : place.cloud.points) p.getVector3fMap() = R_float * p.getVector3fMap();
  place.cloud.origin = R * place.cloud.origin;
  place.bev.alignment = place.bev.alignment * R.conjugate();
  for (Eigen::Isometry3d& T : place.poses) T = R * T;
  return place;
}

/// A BEV grid drawn in a turned frame, in which it is upright.
BevGrid turnedBev(const BevGrid& view, const Eigen::Quaterniond& R) {
  BevGrid turned = view;
  turned.alignment = Eigen::Quaterniond::Identity();
  const Eigen::Vector3d origin(view.origin_x, view.origin_y, view.origin_z);
  const auto toTurned = [&](double x, double y, double z) -> Eigen::Vector3d {
    return R * (origin + Eigen::Vector3d(x, y, z)) - origin;
  };
  for (auto& channel : turned.samples) {
    for (BevSample& s : channel) {
      const Eigen::Vector3f p = toTurned(s.x, s.y, s.z).cast<float>();
      s = {p.x(), p.y(), p.z()};
    }
  }
  for (GroundCell& cell : turned.known) {
    const Eigen::Vector3d p =
        toTurned((cell.x + 0.5) * view.cell_m, (cell.y + 0.5) * view.cell_m, cell.z);
    cell.x = static_cast<std::int32_t>(std::floor(p.x() / view.cell_m));
    cell.y = static_cast<std::int32_t>(std::floor(p.y() / view.cell_m));
    cell.z = static_cast<float>(p.z());
  }
  turned.known = onePerCell(std::move(turned.known));
  return turned;
}

/// What the query shows, after a turn; of bare graphs the vertices.
Eigen::AlignedBox3d boxOf(const Query& query, const Eigen::Quaterniond& R) {
  const auto pointAt = [&](std::size_t i) -> Eigen::Vector3d {
    return R * query.cloud.position(i);
  };
  const auto vertexAt = [&](std::size_t i) -> Eigen::Vector3d {
    return R * query.graph.vertices[i].position;
  };
  Eigen::AlignedBox3d box = boxWithoutStrays(query.cloud.size(), pointAt);
  box.extend(boxWithoutStrays(query.graph.size(), vertexAt));
  return box;
}

/// Whether somebody who sees such a box may be at p: on it from above, and not higher or lower than
/// it by what it is high, or a fifth of what it is wide.
bool canBeSeenFrom(const Eigen::Vector3d& p, const Eigen::AlignedBox3d& box) {
  constexpr double kOfWidth = 0.2;
  const Eigen::Vector3d size = box.sizes();
  const double lever_m = std::max(size.z(), kOfWidth * size.head<2>().norm());
  const Eigen::Vector3d margin(0, 0, lever_m);
  return Eigen::AlignedBox3d(box.min() - margin, box.max() + margin).contains(p);
}

using Kinds = std::uint32_t;  ///< bit = Kind

constexpr Kinds bits(std::initializer_list<Kind> kinds) {
  Kinds set = 0;
  for (const Kind kind : kinds) set |= 1u << static_cast<unsigned>(kind);
  return set;
}
constexpr std::uint32_t bits(std::initializer_list<BevChannel> channels) {
  std::uint32_t set = 0;
  for (const BevChannel channel : channels) set |= 1u << static_cast<unsigned>(channel);
  return set;
}

/// Kinds of classes that are seen; a lane marking is part of the road.
Kinds kindsOf(const LabelSet& labels) {
  Kinds kinds = 0;
  for (const auto& [id, info] : labels.classes()) {
    if (info.role == Role::ignored) continue;
    kinds |= bits({info.kind == Kind::lane_marking ? Kind::road : info.kind});
  }
  return kinds;
}

constexpr Kinds kGround = bits({Kind::road, Kind::sidewalk, Kind::terrain});
constexpr Kinds kWalls = bits({Kind::building, Kind::fence});
constexpr Kinds kPosts = bits({Kind::pole, Kind::sign, Kind::light});

/// What is left of kinds where classes come from shapes.
Kinds asShapes(Kinds kinds) {
  constexpr struct {
    Kinds from, to;
  } kLooks[] = {{kGround, bits({Kind::road})},
                {kWalls | bits({Kind::other_surface}), bits({Kind::building})},
                {kPosts | bits({Kind::trunk}), bits({Kind::pole})},
                {bits({Kind::other_object}), 0}};
  for (const auto& look : kLooks) {
    if (kinds & look.from) kinds = (kinds & ~look.from) | look.to;
  }
  return kinds;
}

/// What is seen of kinds that only one of two sets has.
struct Feeds {
  Kinds kinds;  ///< any of them
  std::uint32_t channels;
};
constexpr Feeds kFeeds[] = {
    {kWalls, bits({BevChannel::building, BevChannel::wall_foot, BevChannel::fence})},
    {bits({Kind::vegetation}),
     bits({BevChannel::low_vegetation, BevChannel::canopy, BevChannel::tree})},
    {bits({Kind::trunk}), bits({BevChannel::trunk})},
    {kPosts, bits({BevChannel::pole, BevChannel::sign, BevChannel::light, BevChannel::pole_like})},
    {bits({Kind::vehicle}), bits({BevChannel::vehicle, BevChannel::vehicle_surface})},
    {bits({Kind::other_surface}), bits({BevChannel::other_surface})},
    {bits({Kind::other_object}), bits({BevChannel::other_object})}};

/// Kinds that much of what stands is of: without one of them, obstacles are others.
constexpr Kinds kStanding = bits({Kind::vegetation, Kind::vehicle});

}  // namespace

std::vector<GroundCell> onePerCell(std::vector<GroundCell> cells) {
  std::stable_sort(cells.begin(), cells.end(), [](const GroundCell& a, const GroundCell& b) {
    return std::tuple(a.y, a.x, !a.measured) < std::tuple(b.y, b.x, !b.measured);
  });
  const auto areOne = [](const GroundCell& a, const GroundCell& b) {
    return a.x == b.x && a.y == b.y;
  };
  cells.erase(std::unique(cells.begin(), cells.end(), areOne), cells.end());
  return cells;
}

CommonDetail commonDetail(const LabelSet& query, const LabelSet& map) {
  CommonDetail detail;
  if (query == map) return detail;
  detail.shapes = knowsShapesOnly(query) && !knowsShapesOnly(map);
  const bool by_shape = knowsShapesOnly(query) || knowsShapesOnly(map);
  const Kinds in_query = by_shape ? asShapes(kindsOf(query)) : kindsOf(query),
              in_map = by_shape ? asShapes(kindsOf(map)) : kindsOf(map);
  const auto isTold = [&](Kinds kinds) { return (in_query & kinds) != 0 && (in_map & kinds) != 0; };
  const auto differ = [&](Kinds kinds) { return (in_query & kinds) != (in_map & kinds); };
  detail.one_ground = isTold(kGround) && differ(kGround);
  detail.one_wall = isTold(kWalls) && differ(kWalls);
  detail.one_post = isTold(kPosts) && differ(kPosts);
  for (const Feeds& feeds : kFeeds) {
    if (!isTold(feeds.kinds) && differ(feeds.kinds)) detail.gone |= feeds.channels;
  }
  if (!by_shape && ((!isTold(kWalls) && differ(kWalls)) || differ(kStanding)))
    detail.gone |= bits({BevChannel::obstacle_low, BevChannel::obstacle_high});
  return detail;
}

namespace {

/// Road, sidewalk and terrain become one, and the lines between them go.
void mergeGround(ChannelMoves& moves) {
  using C = BevChannel;
  moves.insert(moves.end(), {{C::sidewalk, {C::road}}, {C::terrain, {C::road}}});
  for (const C line : {C::lane_marking, C::border_road_sidewalk, C::border_sidewalk_terrain,
                       C::border_road_terrain})
    moves.push_back({line, {}});
}

void mergeWalls(BevChannel wall, ChannelMoves& moves) {
  moves.push_back({wall, {BevChannel::building, BevChannel::wall_foot}});
}

void mergePosts(ChannelMoves& moves) {
  for (const BevChannel post : {BevChannel::sign, BevChannel::light})
    moves.push_back({post, {BevChannel::pole}});
}

ChannelMoves movesTo(const CommonDetail& detail) {
  ChannelMoves moves;
  if (detail.one_ground) mergeGround(moves);
  if (detail.one_wall) mergeWalls(BevChannel::fence, moves);
  if (detail.one_post) mergePosts(moves);
  for (std::size_t channel = 0; channel < kBevChannels; ++channel) {
    if (detail.gone >> channel & 1) moves.push_back({static_cast<BevChannel>(channel), {}});
  }
  return moves;
}

/// To the channels that shapes feed.
ChannelMoves movesToShapes() {
  ChannelMoves moves;
  mergeGround(moves);
  mergeWalls(BevChannel::fence, moves);
  mergePosts(moves);
  mergeWalls(BevChannel::other_surface, moves);
  moves.push_back({BevChannel::trunk, {BevChannel::pole, BevChannel::pole_like}});
  moves.push_back({BevChannel::other_object, {}});
  return moves;
}

/// What a thing of this kind looks like to somebody who knows shapes only.
Shape shapeOf(Kind kind) {
  if (isGround(kind)) return Shape::ground;
  if (isPoleLike(kind) || kind == Kind::trunk) return Shape::post;
  if (kind == Kind::building || kind == Kind::fence || kind == Kind::other_surface)
    return Shape::wall;
  if (kind == Kind::vehicle) return Shape::low_thing;
  return kind == Kind::none ? Shape::none : Shape::foliage;
}
std::uint32_t shapeOf(std::uint32_t label, const LabelSet& labels) {
  return static_cast<std::uint32_t>(shapeOf(labels.kind(label)));
}

}  // namespace

map::Reduction reductionTo(const CommonDetail& detail, const LabelSet& of_query,
                           const LabelSet& of_map) {
  map::Reduction reduction{movesTo(detail), nullptr, {}};
  if (!detail.shapes) return reduction;
  const ChannelMoves to_shapes = movesToShapes();
  reduction.moves.insert(reduction.moves.begin(), to_shapes.begin(), to_shapes.end());
  reduction.label = [of_map](std::uint32_t label) { return shapeOf(label, of_map); };
  reduction.labels = of_query;
  return reduction;
}

void reduceToShapes(const LabelSet& shapes, Place& place) {
  for (Point& point : place.cloud.points) point.label = shapeOf(point.label, place.labels);
  for (Vertex& vertex : place.graph.vertices) vertex.label = shapeOf(vertex.label, place.labels);
  moveSamples(movesToShapes(), place.bev);
  place.labels = shapes;
}

Options optionsOfSearch(const Options& given, double size, const LabelSet& map_labels) {
  Options options = inCanonicalLengths(given, size);
  if (!options.places.likelihoods.empty()) return options;
  if (surroundingsOf(size) == search::Surroundings::rooms)
    options.places.likelihoods = search::kRooms;
  else if (knowsShapesOnly(map_labels))
    options.places.likelihoods = search::kShapes;
  return options;
}

std::optional<map::SemanticMap> gravityAlignedMap(const map::SemanticMap& map,
                                                  const Eigen::Quaterniond& R_up) {
  return isTurn(R_up) ? std::optional(turned(map, R_up)) : std::nullopt;
}

Query turnedQuery(const Query& query, const Eigen::Quaterniond& R_up) {
  return turned(query, R_up);
}

Query tiltedQuery(const Query& query, const Eigen::Quaterniond& R) {
  Query tilted = turnedQuery(query, R);
  tilted.bev = turnedBev(tilted.bev, R);
  return tilted;
}

Query scaledQuery(const Query& query, double scale) {
  Query scaled = query;
  scaleLengths(scale, scaled);
  return scaled;
}

QueryInMap::QueryInMap(const Query& given, const LabelSet& map_labels, double map_size,
                       const ClassNames& names)
    : MaybeChanged(given) {
  requireSound(given);
  if (given.size != map_size && !given.bev.known.empty()) {
    throw Error("the query", fmt::format("it was made with lengths of size {0} and the map with "
                                         "those of size {1}; make it again with --size {1}",
                                         sizeText(given.size), sizeText(map_size)));
  }
  const CommonDetail detail = commonDetail(given.labels, map_labels);
  if (knowsShapesOnly(map_labels) && !knowsShapesOnly(given.labels)) {
    changed_ = given;
    reduceToShapes(map_labels, *changed_);
  } else if (!detail.shapes && !(given.labels == map_labels)) {
    const LabelMatch match(given.labels, map_labels, names);
    if (!match.changesNothing() && !match.isHopeless()) changed_ = translated(given, match);
  }
  if (!detail.isAll()) {
    if (!changed_) changed_ = given;
    moveSamples(movesTo(detail), changed_->bev);
  }
  if (map_size != kTownScale) changed_ = scaledQuery(**this, 1 / map_size);
}

AlignedQuery::AlignedQuery(const Query& given, const FrameHypothesis& guess) : MaybeChanged(given) {
  if (guess.scale != 1) changed_ = scaledQuery(given, guess.scale);
  if (isTurn(guess.R_up)) changed_ = turnedQuery(**this, guess.R_up);
}

Eigen::Vector3d middleOf(const Query& query) {
  if (query.graph.empty()) return query.poses.back().translation();
  const std::vector<Vertex>& vertices = query.graph.vertices;
  const Eigen::AlignedBox3d box =
      boxWithoutStrays(vertices.size(), [&](std::size_t i) { return vertices[i].position; });
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Vertex& v : vertices) {
    if (!box.contains(v.position)) continue;
    sum += v.position;
    ++count;
  }
  return sum / count;
}

std::optional<Query> seenFromItsCentre(const Query& query) {
  if (query.sensor != Sensor::cloud || query.poses.size() != 1 || query.graph.empty())
    return std::nullopt;
  const Eigen::Quaterniond& R_up = query.gravity.alignment;
  if (canBeSeenFrom(R_up * query.poses[0].translation(), boxOf(query, R_up))) return std::nullopt;
  Query centred = query;
  centred.poses = {Eigen::Isometry3d(Eigen::Translation3d(middleOf(query)))};
  return centred;
}

std::vector<double> scalesIn(const ScaleRange& range) {
  const double ratio = range.high / range.low;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::log(ratio) / kScaleStep)));
  std::vector<double> scales;
  for (int i = 0; i <= steps; ++i)
    scales.push_back(range.low * std::pow(ratio, static_cast<double>(i) / steps));
  return scales;
}

Eigen::Isometry3d alignedAbout(const Eigen::Vector3d& point, const Eigen::Isometry3d& T) {
  Eigen::Isometry3d aligned = poseFromYaw(Eigen::Vector3d::Zero(), yawOf(T.linear()));
  aligned.translation() = T * point - aligned.linear() * point;
  return aligned;
}

Gravity gravityOf(const map::SemanticMap& map, const std::string& mode) {
  return map::hasView(map) ? gravityOf(map.bev)
                           : gravityOf(map::allVertices(map), map.labels, mode);
}

}  // namespace xview
