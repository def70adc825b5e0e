// SPDX-License-Identifier: BSD-3-Clause
#include "map/reduced_map.h"

#include <algorithm>
#include <utility>

#include "map/contents.h"
#include "packed_cloud.h"

namespace xview::map {
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

SemanticMap reduced(const SemanticMap& map, const Reduction& reduction) {
  const bool knows_overview = map.stored_view || (map.overview && hasOverview(map));
  SemanticMap result = map;
  result.packed_view.reset();
  result.packed_vertices.reset();
  if (reduction.label) {
    for (Point& point : result.cloud.points) point.label = reduction.label(point.label);
    for (Vertex& vertex : result.graph.vertices) vertex.label = reduction.label(vertex.label);
    if (map.stored_points)
      result.stored_points =
          std::make_shared<const ReducedCloud>(map.stored_points, reduction.label);
    if (map.stored_vertices)
      result.stored_vertices =
          std::make_shared<const ReducedVertices>(map.stored_vertices, reduction.label);
    result.labels = reduction.labels;
  }
  if (map.stored_view)
    result.stored_view = std::make_shared<const ReducedView>(map.stored_view, reduction.moves);
  else
    moveSamples(reduction.moves, result.bev);
  if (!knows_overview) return result;
  auto overview = reducedOverview(*map.overview, reduction.moves);
  if (!map.stored_view) overview.checksum = search::checksumOf(result.bev);
  result.overview = std::make_shared<const search::MapOverview>(std::move(overview));
  return result;
}

}  // namespace xview::map
