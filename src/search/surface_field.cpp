// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <utility>

#include "base/cells.h"
#include "base/median.h"
#include "base/parallel.h"
#include "search/heights.h"
#include "search/raster.h"
#include "search/search.h"

namespace xview::search {
namespace {

constexpr double kMapNullMix = 0.5;  ///< weight of the map's own wrong poses against learned ones
constexpr double kRasterUnitsPerNat = 4;
constexpr double kRasterCap = 255;
constexpr double kYawStep_rad = 6 * M_PI / 180;  ///< largest of the exhaustive search
constexpr std::size_t kKeepCells = 4000, kKeepPoses = 400, kRefinePoses = 100;  ///< of it
/// Of the best score of the first look at a large map: cells below it are no rivals.
constexpr double kLeastShare = 0.2;
/// Nor are cells below this share that are not among the first few: the larger a map, the more
/// cells are between the two.
constexpr double kClearShare = 0.3;
constexpr std::size_t kFewCells = 60;
/// First steps of the fine refinement, and how far a step of yaw moves the rim at most.
constexpr double kStep_m = 0.5, kStep_rad = 0.012, kRimStep_m = 0.5;
constexpr double kPolishStep_m = 0.125, kPolishStep_rad = 0.003;
constexpr double kMapOverlapPrior_nats =
    15;  ///< added to the expected score: few landmarks tell little
/// Presumed of obstacles of a query, found and expected, so that a few of them say little.
constexpr double kObstaclePrior_nats = 20, kMostStanding = 1.5;
constexpr double kLooked_m2 = 150;  ///< a query that measured less ground shows too little of a map

WeightedRatios weighted(const LogRatios& ratios, bool coarse) {
  WeightedRatios result;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const auto weight = static_cast<float>(sampleWeight(static_cast<BevChannel>(c), coarse));
    for (int b = 0; b <= kDistanceBins; ++b) result.value[c][b] = weight * ratios.value[c][b];
    result.expected[c] = weight * ratios.expected[c];
  }
  return result;
}

/// Fine cells per side of a coarse one: a power of two, so that tiles hold whole coarse cells.
int cellsPerSide(double coarse_cell_m, double fine_cell_m) {
  int sub = 1;
  while (sub < DistanceField::kTileCells && sub * 1.5 < coarse_cell_m / fine_cell_m) sub *= 2;
  return sub;
}

/// Mean and maximum of the fine cells in a coarse one, blended: a surface that only touches the
/// cell still counts.
float blendedRatio(const std::uint8_t* bins, int sub,
                   const std::array<float, kDistanceBins + 1>& ratios, float mean_share) {
  float sum = 0, best = ratios[bins[0]];
  for (int y = 0; y < sub; ++y) {
    for (int x = 0; x < sub; ++x) {
      const float v = ratios[bins[y * DistanceField::kTileCells + x]];
      sum += v;
      best = std::max(best, v);
    }
  }
  return mean_share * sum / static_cast<float>(sub * sub) + (1 - mean_share) * best;
}

std::uint8_t quantized(double nats) {
  return static_cast<std::uint8_t>(
      std::clamp(std::round(nats * kRasterUnitsPerNat), 0.0, kRasterCap));
}

/// Whether all fine cells of a coarse one are of one class, as most are.
bool isUniform(const std::uint8_t* bins, int sub) {
  std::uint32_t differences = 0;
  for (int y = 0; y < sub; ++y) {
    for (int x = 0; x < sub; ++x)
      differences |= static_cast<std::uint32_t>(bins[y * DistanceField::kTileCells + x] ^ bins[0]);
  }
  return differences == 0;
}

/// Ratios as bytes above the lowest one of their channel; the background is what unseen area has.
class RatioBytes {
 public:
  explicit RatioBytes(const WeightedRatios& ratios) : ratios_(ratios) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      const auto& values = ratios.value[c];
      lowest_[c] = *std::min_element(values.begin(), values.end());
      background_.push_back(quantized(-lowest_[c]));
      for (std::size_t bin = 0; bin < values.size(); ++bin)
        of_uniform_[c][bin] = blended(c, values[bin], values[bin]);
    }
  }

  const std::vector<std::uint8_t>& background() const { return background_; }

  /// Writes the cells of a tile; each has `sub` x `sub` of its cells.
  void write(const DistanceField::Tile& tile, int sub, LikelihoodRaster& raster) const {
    constexpr int kSide = DistanceField::kTileCells;
    const int side = kSide / sub;
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const std::uint8_t* bins = tile.bins[c] + (y * kSide + x) * sub;
          const std::uint8_t value =
              isUniform(bins, sub)
                  ? of_uniform_[c][bins[0]]
                  : quantized(blendedRatio(bins, sub, ratios_.value[c], meanShare(c)) - lowest_[c]);
          if (value != background_[c]) raster.set(c, tile.x * side + x, tile.y * side + y, value);
        }
      }
    }
  }

  /// The same of a tile seen from afar: the median stands for the mean, the nearest class for the
  /// highest ratio.
  void write(const PlaneCell& tile, const std::vector<std::uint8_t>& overview, int side,
             LikelihoodRaster& raster) const {
    const std::uint8_t* square = overview.data();
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      const auto& ratios = ratios_.value[c];
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x, ++square) {
          const std::uint8_t value = blended(c, ratios[*square >> 4], ratios[*square & 15]);
          if (value != background_[c]) raster.set(c, tile.x * side + x, tile.y * side + y, value);
        }
      }
    }
  }

 private:
  static float meanShare(std::size_t channel) {
    return isObject(static_cast<BevChannel>(channel)) ? 0.5f : 0.7f;
  }
  std::uint8_t blended(std::size_t channel, float mean, float best) const {
    const float share = meanShare(channel);
    return quantized(share * mean + (1 - share) * best - lowest_[channel]);
  }

  const WeightedRatios& ratios_;
  std::array<float, kBevChannels> lowest_{};
  std::vector<std::uint8_t> background_;
  std::array<std::array<std::uint8_t, kDistanceBins + 1>, kBevChannels> of_uniform_{};
};

/// What the exhaustive search looks at. Of a large map a first look, seen from afar, and what is
/// looked at again; of a small one all.
class Rasters {
 public:
  /// `sub`: cells of the field on a side of one of the raster; `first_sub`: of the first look.
  /// `overview`: of the field; null if it is to be made.
  Rasters(const DistanceField& field, const MapOverview* overview, const WeightedRatios& ratios,
          int sub, int first_sub, int threads)
      : field_(field),
        bytes_(ratios),
        sub_(sub),
        raster_(sub_ * field.cellSize(), bytes_.background()) {
    if (field.tiles().size() >= MapOverview::kFewest && first_sub <= DistanceField::kTileCells) {
      makeFirstLook(overview, first_sub, threads);
      return;
    }
    field.makeAll(threads);
    for (const PlaneCell& tile : field.tiles()) write(tile);
  }

  /// Refers to this object.
  RasterLevels levels(const std::vector<RasterSample>& samples) const {
    RasterLevels levels{{raster_, samples, kYawStep_rad}, std::nullopt};
    if (!first_look_) return levels;
    levels.coarse.emplace(RasterLevel{*first_look_, samples, kYawStep_rad});
    levels.fine.write_first = [this](std::int64_t x, std::int64_t y, std::int64_t side) {
      return writeSquare(x, y, side);
    };
    levels.least_share = kLeastShare;
    levels.clear_share = kClearShare;
    levels.few_cells = kFewCells;
    return levels;
  }

 private:
  void makeFirstLook(const MapOverview* overview, int first_sub, int threads) {
    first_look_.emplace(first_sub * field_.cellSize(), bytes_.background());
    const int side = DistanceField::kTileCells / first_sub;
    const MapOverview made =
        overview && side == MapOverview::kSide ? MapOverview() : overviewOf(field_, side, threads);
    for (const MapOverview::Tile& tile : made.tiles.empty() ? overview->tiles : made.tiles)
      bytes_.write(tile.at, tile.squares, side, *first_look_);
  }

  void write(const PlaneCell& at) const {
    const DistanceField::Tile* tile =
        field_.tileOfCell(at.x * DistanceField::kTileCells, at.y * DistanceField::kTileCells);
    if (tile) bytes_.write(*tile, sub_, raster_);
  }

  std::unique_lock<std::mutex> writeSquare(std::int64_t x, std::int64_t y,
                                           std::int64_t side) const {
    std::unique_lock<std::mutex> lock(mutex_);
    const std::int64_t cells = DistanceField::kTileCells / sub_;
    const auto tileOf = [&](std::int64_t cell) {
      return static_cast<std::int32_t>(
          std::floor(static_cast<double>(cell) / static_cast<double>(cells)));
    };
    for (std::int32_t ty = tileOf(y); ty <= tileOf(y + side - 1); ++ty) {
      for (std::int32_t tx = tileOf(x); tx <= tileOf(x + side - 1); ++tx) {
        if (!std::exchange(written_.at({tx, ty}), std::uint8_t{1})) write({tx, ty});
      }
    }
    return lock;
  }

  const DistanceField& field_;
  const RatioBytes bytes_;
  const int sub_;  ///< cells of the field on a side of one of the raster
  std::optional<LikelihoodRaster> first_look_;
  mutable std::mutex mutex_;
  mutable LikelihoodRaster raster_;
  mutable TilePlane<std::uint8_t> written_;  ///< tiles of the field
};

std::vector<RasterSample> rasterSamples(const std::vector<SurfaceSamples::Sample>& samples) {
  std::vector<RasterSample> result;
  for (const auto& s : samples) result.push_back({s.x, s.y, s.channel});
  return result;
}

double medianHeight(const std::vector<SurfaceSamples::Ground>& ground) {
  std::vector<float> heights;
  for (const SurfaceSamples::Ground& g : ground) heights.push_back(g.z);
  return heights.empty() ? 0 : medianOf(std::move(heights));
}

/// Obstacles without their class, and where the ground was measured: between the rings of a scanner
/// obstacles may stand that it does not show.
BevGrid obstacleView(const BevGrid& view) {
  BevGrid things;
  things.cell_m = view.cell_m;
  things.origin_x = view.origin_x;
  things.origin_y = view.origin_y;
  things.origin_z = view.origin_z;
  things.aerial = view.aerial;
  for (const BevChannel c : kObstacles) things[c] = view[c];
  std::copy_if(view.known.begin(), view.known.end(), std::back_inserter(things.known),
               [](const GroundCell& cell) { return cell.measured; });
  return things;
}

bool isStored(const MapView& map) { return map.stored != nullptr; }

/// The obstacles of a map by columns of it.
class ObstacleIndex {
 public:
  explicit ObstacleIndex(const MapView& map)
      : stored_(map.stored),
        cell_m_(map.grid.cell_m),
        origin_(map.grid.origin_x, map.grid.origin_y, map.grid.origin_z) {
    for (const BevChannel c : kObstacles) {
      for (const BevSample& s : map.grid[c]) {
        const PlaneCell at{columnOf(s.x), columnOf(s.y)};
        const std::size_t number = columns_.numberOf(at, [&] { return Column{at, {}}; });
        columns_[number].view[c].push_back(s);
      }
    }
  }

  /// Those within `radius_m` of a point of the map, in the query frame.
  BevGrid around(const Eigen::Vector2d& centre, double radius_m,
                 const Eigen::Isometry3d& T_query_map) const {
    BevGrid near;
    near.cell_m = cell_m_;
    const Eigen::Vector2d at = centre - origin_.head<2>();
    for (std::int32_t y = columnOf(at.y() - radius_m); y <= columnOf(at.y() + radius_m); ++y) {
      for (std::int32_t x = columnOf(at.x() - radius_m); x <= columnOf(at.x() + radius_m); ++x) {
        inColumn({x, y}, [&](const BevGrid& view) {
          for (const BevChannel c : kObstacles) {
            for (const BevSample& s : view[c]) {
              const Eigen::Vector3d p_map = origin_ + Eigen::Vector3d(s.x, s.y, s.z);
              if ((p_map.head<2>() - centre).squaredNorm() > radius_m * radius_m) continue;
              const Eigen::Vector3f p = (T_query_map * p_map).cast<float>();
              near[c].push_back({p.x(), p.y(), p.z()});
            }
          }
        });
      }
    }
    return near;
  }

 private:
  struct Column {
    PlaneCell key;
    BevGrid view;
  };

  static std::int32_t columnOf(double metres) { return floorToInt(metres / StoredView::kColumn_m); }
  template <class Visit>
  void inColumn(const PlaneCell& column, const Visit& visit) const {
    if (stored_) return visit(*stored_->partOf(column));
    if (const std::int32_t number = columns_.find(column); number >= 0)
      visit(columns_[static_cast<std::size_t>(number)].view);
  }

  std::shared_ptr<const StoredView> stored_;
  double cell_m_;
  Eigen::Vector3d origin_;
  CellTable<Column> columns_;
};

/// What depends on the view-point of the query.
class ViewTables {
 public:
  explicit ViewTables(const LogRatios& log_ratios)
      : ratios(weighted(log_ratios, false)), coarse_ratios(weighted(log_ratios, true)) {}

  const WeightedRatios ratios, coarse_ratios;

  /// Made at the first search. `finer`: with cells half as wide, but the same first look.
  const Rasters& rasters(const DistanceField& field, const MapOverview* overview, int sub,
                         bool finer, int threads) const {
    std::call_once(once_[finer], [&] {
      rasters_[finer].emplace(field, overview, coarse_ratios, finer ? sub / 2 : sub, 2 * sub,
                              threads);
    });
    return *rasters_[finer];
  }

 private:
  mutable std::array<std::once_flag, 2> once_;
  mutable std::array<std::optional<Rasters>, 2> rasters_;
};

class SurfaceField final : public Field {
 public:
  SurfaceField(const MapView& map, const std::vector<Eigen::Vector3d>& trajectory,
               Surroundings surroundings, const PathNull& known, const SearchOptions& options,
               int threads)
      : cell_m_(options.cell_m),
        in_town_(surroundings == Surroundings::town),
        table_(options.likelihoods.empty() ? defaultLikelihoods()
                                           : readLikelihoods(options.likelihoods)),
        threads_(threads),
        aerial_(map.grid.aerial),
        overview_(map.overview),
        obstacles_(map),
        distances_(isStored(map) ? DistanceField(map.grid, map.stored, *map.overview)
                                 : DistanceField(map.grid)),
        origin_(distances_.originX(), distances_.originY(), map.grid.origin_z),
        null_(known) {
    std::vector<Eigen::Vector2d> path;
    for (const Eigen::Vector3d& p : trajectory) path.emplace_back((p - origin_).head<2>());
    null_ = mapNull(map.grid, path, distances_, known, map.stored.get());
  }

  std::unique_ptr<FieldQuery> prepare(const Observation& query) const override;
  std::size_t size() const override { return distances_.tiles().size(); }
  PathNull pathNull() const override { return null_; }

  const DistanceField& distances() const { return distances_; }
  const LikelihoodTable& table() const { return table_; }
  const ObstacleIndex& obstacles() const { return obstacles_; }
  const Eigen::Vector3d& origin() const { return origin_; }
  bool inTown() const { return in_town_; }
  double rasterCell() const { return cellsOfRaster() * distances_.cellSize(); }
  int cellsOfRaster() const { return cellsPerSide(cell_m_, distances_.cellSize()); }
  const Rasters& rasters(const ViewTables& view, bool finer) const {
    return view.rasters(distances_, overview_.get(), cellsOfRaster(), finer, threads_);
  }
  Viewpoint viewpointOf(const SurfaceSamples& query) const {
    return search::viewpointOf(query.aerial, aerial_);
  }
  /// Made at the first query of this view-point.
  const ViewTables& view(Viewpoint viewpoint) const {
    const auto v = static_cast<std::size_t>(viewpoint);
    std::call_once(once_[v], [&] {
      views_[v] = std::make_unique<const ViewTables>(
          logRatios(table_, viewpoint, &null_.counts, kMapNullMix));
    });
    return *views_[v];
  }

 private:
  double cell_m_;
  bool in_town_;
  LikelihoodTable table_;
  int threads_;
  bool aerial_;
  std::shared_ptr<const MapOverview> overview_;
  ObstacleIndex obstacles_;
  DistanceField distances_;
  Eigen::Vector3d origin_;
  PathNull null_;
  mutable std::array<std::once_flag, kViewpoints> once_;
  mutable std::array<std::unique_ptr<const ViewTables>, kViewpoints> views_;
};

double measuredGround_m2(const BevGrid& bev) {
  const auto cells = std::count_if(bev.known.begin(), bev.known.end(),
                                   [](const GroundCell& cell) { return cell.measured; });
  return static_cast<double>(cells) * bev.cell_m * bev.cell_m;
}

class SurfaceQuery final : public FieldQuery {
 public:
  /// `bev`: all of the query; null for a part of one.
  SurfaceQuery(const SurfaceField& field, const BevGrid* bev, SurfaceSamples samples,
               const std::optional<Eigen::Vector3d>& focus)
      : FieldQuery(field.origin(), focus),
        field_(field),
        bev_(bev),
        samples_(std::move(samples)),
        view_(field.view(field.viewpointOf(samples_))),
        score_(field.distances(), view_.ratios, samples_.fine),
        rough_score_(field.distances(), view_.coarse_ratios, samples_.coarse) {
    centre_ << samples_.centre, medianHeight(samples_.ground);
    radius_ = radiusOf(samples_.fine);
  }

  std::size_t size() const override { return field_.empty() ? 0 : samples_.fine.size(); }

  std::unique_ptr<FieldQuery> part(const Eigen::Vector2d& centre, double radius_m) const override {
    return std::make_unique<SurfaceQuery>(field_, nullptr, partOf(samples_, centre, radius_m),
                                          focus_);
  }

  std::vector<Point> points() const override {
    std::vector<Point> points;
    for (const auto& s : samples_.fine)
      points.push_back({samples_.centre + Eigen::Vector2d(s.x, s.y), 1});
    return points;
  }

  RasterLevels rasterLevels() const override { return levelsOf(field_.rasters(view_, false)); }
  std::unique_ptr<RasterLevels> finerLevels() const override {
    if (field_.cellsOfRaster() == 1) return nullptr;
    return std::make_unique<RasterLevels>(levelsOf(field_.rasters(view_, true)));
  }

  PlacePose refineLocally(const PlacePose& pose, RefinementLevel how) const override {
    switch (how) {
      case RefinementLevel::rough:
        return rough_score_.refineLocally(pose, field_.rasterCell() / 2, kYawStep_rad / 2, 1);
      case RefinementLevel::coarse:
        return score_.refineLocally(pose, field_.rasterCell() / 2, kYawStep_rad / 2, 2);
      case RefinementLevel::fine:
        return score_.refineLocally(pose, kStep_m, std::min(kStep_rad, kRimStep_m / radius_), 3);
      default:
        return score_.refineLocally(pose, kPolishStep_m, kPolishStep_rad, 2);
    }
  }

  double scoreAt(const PlacePose& pose) const override { return score_(pose); }

  PlaceHypothesis describeAt(const PlacePose& pose) const override {
    const double height = heightOffset(field_.distances(), samples_, pose);
    return score_.details(pose, inMap(pose, centre_.z() + height + origin_.z()));
  }

  HeightFit fitHeights(const Eigen::Isometry3d& T_map_query, double slope_sigma) const override {
    HeightFit fit = search::fitHeights(
        groundPairs(field_.distances(), samples_.ground, centrePose(T_map_query)),
        groundHeights(slope_sigma));
    fit.height_m += origin_.z();
    return fit;
  }

  std::vector<SampleEvidence> evidence(const Eigen::Isometry3d& T_map_query) const override {
    std::vector<SampleEvidence> evidence = score_.evidence(centrePose(T_map_query));
    for (SampleEvidence& e : evidence) {
      e.query += samples_.centre;
      e.map = (T_map_query * Eigen::Vector3d(e.query.x(), e.query.y(), 0)).head<2>();
    }
    return evidence;
  }

  Visibility visibility(const Eigen::Isometry3d& T_map_query) const override {
    const std::vector<SampleEvidence> here = score_.evidence(centrePose(T_map_query));
    Visibility seen;
    seen.conflict_ratio = conflictRatioOf(here);
    const PartScore obstacles = obstaclesIn(here);
    seen.obstacle_overlap = std::clamp(
        (obstacles.score + kObstaclePrior_nats) / (obstacles.expected + kObstaclePrior_nats), -1.0,
        kMostStanding);
    if (!bev_ || !field_.inTown() || measuredGround_m2(*bev_) < kLooked_m2) return seen;
    std::call_once(things_made_,
                   [&] { things_ = std::make_unique<DistanceField>(obstacleView(*bev_)); });
    const SurfaceSamples samples = surfaceSamples(field_.obstacles().around(
        (T_map_query * centre_).head<2>(), radius_, T_map_query.inverse()));
    // The weights of the verdict were fitted with the table of the air for both mixed pairs.
    const Viewpoint viewpoint =
        field_.viewpointOf(samples_) == Viewpoint::ground ? Viewpoint::ground : Viewpoint::air;
    const WeightedRatios ratios = weighted(logRatios(field_.table(), viewpoint, nullptr, 0), false);
    const PlacePose as_it_is{samples.centre.x() - things_->originX(),
                             samples.centre.y() - things_->originY(), 0, 0};
    const SurfaceScore map_in_query(*things_, ratios, samples.fine);
    const PartScore sum = map_in_query.details(as_it_is, {}).obstacles;
    seen.miss_ratio = conflictRatioOf(map_in_query.evidence(as_it_is));
    seen.map_overlap =
        std::clamp(sum.score / (std::max(0.0, sum.expected) + kMapOverlapPrior_nats), -1.0, 1.0);
    return seen;
  }

 private:
  RasterLevels levelsOf(const Rasters& rasters) const {
    RasterLevels levels = rasters.levels(rasterSamples(samples_.coarse));
    levels.keep_cells = kKeepCells;
    levels.keep_poses = kKeepPoses;
    levels.refine_poses = kRefinePoses;
    return levels;
  }

  const SurfaceField& field_;
  const BevGrid* bev_;
  const SurfaceSamples samples_;
  const ViewTables& view_;
  const SurfaceScore score_, rough_score_;
  mutable std::once_flag things_made_;
  mutable std::unique_ptr<const DistanceField> things_;  ///< what stands in the query
};

std::unique_ptr<FieldQuery> SurfaceField::prepare(const Observation& query) const {
  SurfaceSamples samples;
  if (query.bev) samples = surfaceSamples(*query.bev);
  return std::make_unique<SurfaceQuery>(*this, query.bev, std::move(samples), query.focus);
}

}  // namespace

std::unique_ptr<const Field> makeSurfaceField(const MapView& map,
                                              const std::vector<Eigen::Vector3d>& trajectory,
                                              Surroundings surroundings, const PathNull& known,
                                              const SearchOptions& options, int threads) {
  return std::make_unique<SurfaceField>(map, trajectory, surroundings, known, options, threads);
}

}  // namespace xview::search
