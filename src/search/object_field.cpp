// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <tuple>

#include "base/pose.h"
#include "search/object_verifier.h"

namespace xview::search {
namespace {

/// Steps of a raster byte per nat of evidence, and the largest byte.
constexpr double kRasterStepsPerNat = 3;
constexpr int kHighestRasterValue = 15;
constexpr double kFarthest = 10;  // squared Mahalanobis distance beyond which nothing is stamped
constexpr double kLeastShare =
    0.3;  // of the weight of a surface: what does not tell places apart still tells where they are
constexpr double kHeadingBlur = 0.5;  // [m^2] the pose is known to half a yaw step only

constexpr double kCell_m = 3;            // of the fine raster
constexpr std::size_t kSmallMap = 1000;  // vertices; the fine raster is searched directly
constexpr double kCellsPerRoot =
    37;  // cells kept of the first look: 3700 for 10,000 vertices, 37,000 for a million
constexpr std::size_t kCellsPerPose = 20;  // kept of small maps: many are neighbours
/// Of the best score of the first look at a large map: cells below it are no rivals.
constexpr double kLeastOfBest = 0.5;
constexpr double kCoarseYawStep = 0.16, kFineYawStep = 0.105;  // [rad]
constexpr double kCentreMargin = 15;    // [m] beyond the gap around the query's own centre
constexpr double kSurfaceWeight = 0.2;  // of a vertex of a surface in a dense part of a query
// Scales of the standard deviations: they narrow while the pose gets better.
constexpr double kRoughStep = 1.8, kRoughScore = 1.3;
constexpr double kSteps[] = {1.8, 1.4, 1.2, 1.0, 1.0};

/// A Gaussian around a map point.
struct Stamp {
  double along, across;  // standard deviations [m]
  double log_gain;
  double weight;
};

void raiseAround(const MapPoint& p, const Stamp& stamp, LikelihoodRaster& raster) {
  const double cell = raster.cellSize();
  const double dx = p.hasTangent() ? p.tangent_x : 1, dy = p.hasTangent() ? p.tangent_y : 0;
  const double reach = std::sqrt(kFarthest) * std::max(stamp.along, stamp.across);
  forSquare(p.x, p.y, reach, cell, [&](const PlaneCell& at) {
    const double ex = (at.x + 0.5) * cell - p.x, ey = (at.y + 0.5) * cell - p.y;
    const double u = (ex * dx + ey * dy) / stamp.along, v = (-ex * dy + ey * dx) / stamp.across;
    const double distance2 = u * u + v * v;
    if (distance2 > kFarthest) return;
    const double nats = stamp.weight * softplus(stamp.log_gain - 0.5 * distance2);
    const int value =
        std::min(kHighestRasterValue, static_cast<int>(kRasterStepsPerNat * nats + 0.5));
    if (value > 0) raster.raise(p.slot, at.x, at.y, static_cast<std::uint8_t>(value));
  });
}

/// Where a query vertex falls within its cell is unknown, which adds to the variance.
Stamp widened(const ObjectClass& model, bool directed, double cell_m) {
  const double blur = cell_m * cell_m / 6 + kHeadingBlur;
  const double along = std::sqrt(model.along_m * model.along_m + blur);
  // The samples of the query are as far apart as a cell at least, see ObjectQuery::samples.
  const double weight = model.is_surface
                            ? std::min(1.0, std::max(model.spacing_m, cell_m) / kIndependentM) *
                                  std::max(kLeastShare, model.gain_weight)
                            : model.weight;
  if (!model.is_surface) return {along, along, 0, weight};
  if (!directed) return {0.8 * along, 0.8 * along, 0, weight};
  return {along, std::sqrt(model.across_m * model.across_m + blur), 0, weight};
}

LikelihoodRaster emptyRaster(const ObjectMap& map, double cell_m) {
  return {cell_m, std::vector<std::uint8_t>(map.classes().size(), 0)};
}

void rasterize(const MapPoint& point, const ObjectMap& map, LikelihoodRaster& raster) {
  const ObjectClass& model = map.classes()[point.slot];
  Stamp stamp = widened(model, point.hasTangent(), raster.cellSize());
  stamp.log_gain =
      logGain(model, stamp.along * stamp.across, map.logClutter(point.slot, point.x, point.y));
  raiseAround(point, stamp, raster);
}

/// The farthest that a point is stamped [m].
double farthestStamp(const ObjectMap& map, double cell_m) {
  double farthest = 0;
  for (const ObjectClass& model : map.classes()) {
    for (const bool directed : {false, true}) {
      const Stamp stamp = widened(model, directed, cell_m);
      farthest = std::max({farthest, stamp.along, stamp.across});
    }
  }
  return std::sqrt(kFarthest) * farthest;
}

/// The fine raster of a large map, written where it is looked at.
class FineRaster {
 public:
  explicit FineRaster(const ObjectMap& map)
      : map_(map),
        raster_(emptyRaster(map, kCell_m)),
        rim_m_(farthestStamp(map, kCell_m) + kCell_m) {}

  const LikelihoodRaster& raster() const { return raster_; }

  void writeAll() {
    for (const MapPoint& point : map_.points()) rasterize(point, map_, raster_);
  }
  /// The square of cells is complete while the lock is held.
  std::unique_lock<std::mutex> write(std::int64_t x, std::int64_t y, std::int64_t side) {
    std::unique_lock<std::mutex> lock(mutex_);
    const double half_m = 0.5 * static_cast<double>(side) * kCell_m;
    const double middle_x = static_cast<double>(x) * kCell_m + half_m,
                 middle_y = static_cast<double>(y) * kCell_m + half_m;
    forSquare(middle_x, middle_y, half_m + rim_m_, ObjectMap::kBlock_m,
              [&](const PlaneCell& block) {
                std::uint8_t& is_written = written_.at(block);
                if (is_written) return;
                is_written = 1;
                map_.visitBlock(
                    block, [&](std::uint32_t i) { rasterize(map_.points()[i], map_, raster_); });
              });
    return lock;
  }

 private:
  const ObjectMap& map_;
  LikelihoodRaster raster_;
  const double rim_m_;
  std::mutex mutex_;
  TilePlane<std::uint8_t> written_;  ///< blocks
};

/// The rotation that tilts an upright query by a slope of its heights.
Eigen::AngleAxisd tilted(const Eigen::Vector2d& slope) {
  const double rise = slope.norm();
  if (rise < 1e-9) return Eigen::AngleAxisd(0, Eigen::Vector3d::UnitX());
  return Eigen::AngleAxisd(std::atan(rise), Eigen::Vector3d(slope.y(), -slope.x(), 0) / rise);
}

/// Pairs that are more likely than not, each vertex in one of them at most, in the order of the
/// query.
std::vector<Correspondence> pairsOf(const ObjectVerifier& verifier, const ObjectQuery& query) {
  std::vector<Correspondence> pairs;
  for (std::size_t i = 0; i < query.items().size(); ++i) {
    const Association& association = verifier.associations()[i];
    if (association.chance() <= 0.5f) continue;
    pairs.push_back({query.items()[i].vertex, verifier.mapPoint(association.local).vertex,
                     association.chance()});
  }
  std::sort(pairs.begin(), pairs.end(), [](const Correspondence& a, const Correspondence& b) {
    return std::make_tuple(a.map, -a.similarity, a.query) <
           std::make_tuple(b.map, -b.similarity, b.query);
  });
  const auto last =
      std::unique(pairs.begin(), pairs.end(),
                  [](const Correspondence& a, const Correspondence& b) { return a.map == b.map; });
  pairs.erase(last, pairs.end());
  std::sort(pairs.begin(), pairs.end(),
            [](const Correspondence& a, const Correspondence& b) { return a.query < b.query; });
  return pairs;
}

class ObjectField final : public Field {
 public:
  ObjectField(const AllVertices& vertices, const LabelSet& labels, const SearchOptions& options)
      : options_(options), map_(vertices, labels, options), fine_(map_) {
    if (size() <= kSmallMap) {
      fine_.writeAll();
      return;
    }
    coarse_ = emptyRaster(map_, 2 * kCell_m);
    for (const MapPoint& point : map_.points()) rasterize(point, map_, *coarse_);
  }

  std::unique_ptr<FieldQuery> prepare(const Observation& query) const override;
  std::size_t size() const override { return map_.points().size(); }

  const SearchOptions& options() const { return options_; }
  const ObjectMap& map() const { return map_; }

  RasterLevels rasterLevels(const ObjectQuery& query) const {
    RasterLevels levels{{fine_.raster(), query.samples(map_, kCell_m), kFineYawStep}, std::nullopt};
    if (coarse_) {
      levels.fine.write_first = [this](std::int64_t x, std::int64_t y, std::int64_t side) {
        return fine_.write(x, y, side);
      };
      levels.coarse.emplace(
          RasterLevel{*coarse_, query.samples(map_, coarse_->cellSize()), kCoarseYawStep});
      levels.least_share = kLeastOfBest;
    }
    // The more places there are, the more of them look as good as the right one at first.
    const double vertices = static_cast<double>(size());
    levels.keep_poses =
        static_cast<std::size_t>(std::clamp(150 * std::pow(vertices / 1e4, 0.3), 60.0, 600.0));
    levels.keep_cells = coarse_ ? static_cast<std::size_t>(kCellsPerRoot * std::sqrt(vertices))
                                : kCellsPerPose * levels.keep_poses;
    levels.margin_m = query.emptyRadius() + kCentreMargin;
    return levels;
  }

 private:
  const SearchOptions options_;
  ObjectMap map_;
  mutable FineRaster fine_;  ///< locked while it is written
  std::optional<LikelihoodRaster> coarse_;
};

class ObjectFieldQuery final : public FieldQuery {
 public:
  /// `vertices`: those of the graph that may take part.
  ObjectFieldQuery(const ObjectField& field, const SemanticGraph& graph,
                   const std::vector<std::uint32_t>& vertices,
                   const std::optional<Eigen::Vector3d>& focus)
      : FieldQuery(field.map().origin(), focus),
        field_(field),
        graph_(graph),
        query_(graph, field.map(), vertices) {
    centre_ = query_.centre();
    radius_ = query_.radius();
  }

  std::size_t size() const override { return query_.items().size(); }

  std::unique_ptr<FieldQuery> part(const Eigen::Vector2d& centre, double radius_m) const override {
    std::vector<std::uint32_t> inside;
    for (std::uint32_t i = 0; i < graph_.vertices.size(); ++i) {
      if ((graph_.vertices[i].position.head<2>() - centre).norm() <= radius_m) inside.push_back(i);
    }
    return std::make_unique<ObjectFieldQuery>(field_, graph_, inside, focus_);
  }

  std::vector<Point> points() const override {
    std::vector<Point> points;
    for (const QueryItem& item : query_.items()) {
      const bool is_surface = field_.map().classes()[item.slot].is_surface;
      points.push_back(
          {centre_.head<2>() + Eigen::Vector2d(item.x, item.y), is_surface ? kSurfaceWeight : 1.0});
    }
    return points;
  }

  RasterLevels rasterLevels() const override { return field_.rasterLevels(query_); }

  PlacePose refineLocally(const PlacePose& start, RefinementLevel how) const override {
    if (how == RefinementLevel::polish) return start;  // the end is as exact as vertices are
    ObjectVerifier verifier = verifierAt(start);
    PlacePose pose = start;
    if (how <= RefinementLevel::coarse) {
      pose = verifier.improved(pose, kRoughStep);
      pose.score = scoreBy(verifier, pose, kRoughScore);
    } else {
      for (const double widen : kSteps) pose = verifier.improved(pose, widen);
      pose.score = scoreBy(verifier, pose, 1);
    }
    return pose;
  }

  double scoreAt(const PlacePose& pose) const override {
    ObjectVerifier verifier = verifierAt(pose);
    return scoreBy(verifier, pose, 1);
  }

  PlaceHypothesis describeAt(const PlacePose& pose) const override {
    ObjectVerifier verifier = verifierAt(pose);
    verifier.score(pose, 1);
    PlaceHypothesis h = inMap(pose);
    h.pairs = pairsOf(verifier, query_);
    h.matched = static_cast<int>(h.pairs.size());
    const HeightFit heights = heightsBy(verifier);
    h.T_map_query =
        poseFromYaw({h.centre.x, h.centre.y, heights.height_m + origin_.z()}, pose.yaw) *
        tilted(heights.slope) * Eigen::Translation3d(-centre_);
    h.expected = verifier.expectedScore(pose);
    h.map_coverage = verifier.knownShare();
    return h;
  }

 private:
  ObjectVerifier verifierAt(const PlacePose& pose) const {
    ObjectVerifier verifier(field_.map(), query_, field_.options());
    verifier.moveTo(pose);
    return verifier;
  }

  static double scoreBy(ObjectVerifier& verifier, const PlacePose& pose, double widen) {
    const double seen = verifier.score(pose, widen);
    return seen - verifier.missedObjects(pose) - verifier.heightCost();
  }

  /// Heights of a query without heights tell of the ground, not of a tilt.
  HeightFit heightsBy(ObjectVerifier& verifier) const {
    if (query_.hasHeights()) return search::fitHeights(verifier.heightPairs(), vertexHeights());
    HeightFit level;
    level.height_m = medianRise(verifier.heightPairs());
    return level;
  }

  const ObjectField& field_;
  const SemanticGraph& graph_;
  const ObjectQuery query_;
};

std::unique_ptr<FieldQuery> ObjectField::prepare(const Observation& query) const {
  static const SemanticGraph kNothing;
  const SemanticGraph& graph = query.graph ? *query.graph : kNothing;
  std::vector<std::uint32_t> all(graph.vertices.size());
  std::iota(all.begin(), all.end(), 0u);
  return std::make_unique<ObjectFieldQuery>(*this, graph, all, query.focus);
}

}  // namespace

std::unique_ptr<const Field> makeObjectField(const AllVertices& map, const LabelSet& labels,
                                             const SearchOptions& options) {
  return std::make_unique<ObjectField>(map, labels, options);
}

}  // namespace xview::search
