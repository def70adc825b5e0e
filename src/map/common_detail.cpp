// SPDX-License-Identifier: BSD-3-Clause
#include "map/common_detail.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "base/channel_moves.h"
#include "map/contents.h"
#include "packed_cloud.h"
#include "place/raw_recording.h"
#include "place/shapes.h"

namespace xview::map {
namespace {

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

void reduceTo(const CommonDetail& detail, BevGrid& bev) { moveSamples(movesTo(detail), bev); }

void reduceToShapes(const LabelSet& shapes, Place& place) {
  for (Point& point : place.cloud.points) point.label = shapeOf(point.label, place.labels);
  for (Vertex& vertex : place.graph.vertices) vertex.label = shapeOf(vertex.label, place.labels);
  moveSamples(movesToShapes(), place.bev);
  place.labels = shapes;
}

namespace {

using Relabel = std::function<std::uint32_t(std::uint32_t)>;

class ReducedCloud final : public StoredCloud {
 public:
  ReducedCloud(std::shared_ptr<const StoredCloud> cloud, Relabel label)
      : cloud_(std::move(cloud)), label_(std::move(label)), recent_(kMostRecent) {}

  std::size_t size() const override { return cloud_->size(); }
  std::vector<PlaneCell> columns() const override { return cloud_->columns(); }
  std::shared_ptr<const LabelledCloud> pointsOf(const PlaneCell& column) const override {
    return recent_.findOrMake(column, [&] {
      auto points = std::make_shared<LabelledCloud>(*cloud_->pointsOf(column));
      for (Point& point : points->points) point.label = label_(point.label);
      return points;
    });
  }

 private:
  static constexpr std::size_t kMostRecent = 8;

  std::shared_ptr<const StoredCloud> cloud_;
  Relabel label_;
  mutable RecentColumns<LabelledCloud> recent_;
};

class ReducedVertices final : public StoredVertices {
 public:
  ReducedVertices(std::shared_ptr<const StoredVertices> vertices, Relabel label)
      : vertices_(std::move(vertices)), label_(std::move(label)) {}

  std::size_t size() const override { return vertices_->size(); }
  Vertex at(std::uint32_t number) const override { return relabelled(vertices_->at(number)); }
  Eigen::AlignedBox3d bounds() const override { return vertices_->bounds(); }
  void forAll(const Visit& visit) const override { vertices_->forAll(relabelling(visit)); }
  void forAllIn(const Eigen::AlignedBox2d& box, const Visit& visit) const override {
    vertices_->forAllIn(box, relabelling(visit));
  }
  SemanticGraph whole() const override {
    SemanticGraph graph = vertices_->whole();
    for (Vertex& vertex : graph.vertices) vertex.label = label_(vertex.label);
    return graph;
  }

 private:
  Vertex relabelled(Vertex vertex) const {
    vertex.label = label_(vertex.label);
    return vertex;
  }
  Visit relabelling(const Visit& visit) const {
    return [this, &visit](std::uint32_t number, const Vertex& v) { visit(number, relabelled(v)); };
  }

  std::shared_ptr<const StoredVertices> vertices_;
  Relabel label_;
};

class ReducedView final : public StoredView {
 public:
  ReducedView(std::shared_ptr<const StoredView> view, ChannelMoves moves)
      : view_(std::move(view)), moves_(std::move(moves)), recent_(kMostRecent) {}

  std::vector<PlaneCell> columns() const override { return view_->columns(); }
  std::shared_ptr<const BevGrid> partOf(const PlaneCell& column) const override {
    return recent_.findOrMake(column, [&] {
      auto part = std::make_shared<BevGrid>(*view_->partOf(column));
      moveSamples(moves_, *part);
      return part;
    });
  }
  const BevGrid& whole() const override {
    std::call_once(unpacked_, [&] {
      whole_ = view_->whole();
      moveSamples(moves_, whole_);
    });
    return whole_;
  }
  std::size_t sampleCount() const override { return whole().sampleCount(); }
  /// Tells it from the whole view and from other reductions; the samples are not counted.
  std::uint64_t fingerprint() const override {
    std::uint64_t sum = view_->fingerprint();
    for (const auto& [from, targets] : moves_) {
      sum = search::fingerprintOfSum(31 * sum, static_cast<std::uint64_t>(from));
      for (const BevChannel to : targets)
        sum = search::fingerprintOfSum(31 * sum, static_cast<std::uint64_t>(to) + 1);
    }
    return sum;
  }

 private:
  static constexpr std::size_t kMostRecent = 64;

  std::shared_ptr<const StoredView> view_;
  ChannelMoves moves_;
  mutable RecentColumns<BevGrid> recent_;
  mutable std::once_flag unpacked_;
  mutable BevGrid whole_;
};

/// The overview of a reduced view. The nearest sample of several channels is the nearest of the
/// nearest ones; of the median class the same is taken, which may be too near.
search::MapOverview reducedOverview(search::MapOverview overview, const ChannelMoves& moves) {
  constexpr std::size_t kSquares = search::MapOverview::kSide * search::MapOverview::kSide;
  constexpr std::uint8_t kFar = search::kUnknownBin - 1;
  const auto each = [](std::uint8_t a, std::uint8_t b, const auto& of) {
    return static_cast<std::uint8_t>(of(a >> 4, b >> 4) << 4 | of(a & 15, b & 15));
  };
  const auto nearer = [](int a, int b) { return std::min(a, b); };
  const auto without = [](int a, int) { return a == search::kUnknownBin ? a : int{kFar}; };
  for (search::MapOverview::Tile& tile : overview.tiles) {
    for (const auto& [from, targets] : moves) {
      std::uint8_t* const of_from = tile.squares.data() + kSquares * static_cast<std::size_t>(from);
      for (const BevChannel to : targets) {
        std::uint8_t* const of_to = tile.squares.data() + kSquares * static_cast<std::size_t>(to);
        for (std::size_t i = 0; i < kSquares; ++i) of_to[i] = each(of_to[i], of_from[i], nearer);
      }
      for (std::size_t i = 0; i < kSquares; ++i) of_from[i] = each(of_from[i], 0, without);
    }
  }
  return overview;
}

}  // namespace

SemanticMap reduced(const SemanticMap& map, const CommonDetail& detail, const LabelSet& of_query) {
  const bool knows_overview = map.stored_view || hasOverview(map);
  ChannelMoves moves = detail.shapes ? movesToShapes() : ChannelMoves();
  for (ChannelMove& move : movesTo(detail)) moves.push_back(std::move(move));
  SemanticMap result = map;
  result.packed_vertices.reset();
  if (detail.shapes) {
    const Relabel label = [labels = map.labels](std::uint32_t of_map) {
      return shapeOf(of_map, labels);
    };
    reduceToShapes(of_query, result);
    if (map.stored_points)
      result.stored_points = std::make_shared<const ReducedCloud>(map.stored_points, label);
    if (map.stored_vertices)
      result.stored_vertices = std::make_shared<const ReducedVertices>(map.stored_vertices, label);
  }
  reduceTo(detail, result.bev);
  if (map.stored_view)
    result.stored_view = std::make_shared<const ReducedView>(map.stored_view, moves);
  if (!knows_overview) return result;
  auto overview = reducedOverview(*map.overview, moves);
  if (!map.stored_view) overview.checksum = search::checksumOf(result.bev);
  result.overview = std::make_shared<const search::MapOverview>(std::move(overview));
  return result;
}

}  // namespace xview::map
