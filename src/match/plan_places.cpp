// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/plan_places.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "match/ground_fit.h"
#include "match/map_null.h"
#include "match/plan_blocks.h"
#include "match/plan_score.h"
#include "match/wide_query.h"
#include "xview/match/raster_search.h"
#include "xview/types/parallel.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

constexpr double kRasterUnitsPerNat = 4;
constexpr double kRasterCap = 255;
constexpr float kSameRefined_m = 1.5f, kSameRefined_rad = 0.05f;

/// From so many tiles of 32 m on, the exhaustive search begins with cells of twice the size.
constexpr std::size_t kLargeMapTiles = 400;

/// What depends on the view-point of the query.
struct ViewIndex {
  WeightedRatios ratios;
  LikelihoodRaster raster;
  std::optional<LikelihoodRaster> first_look;  ///< large maps only
};

WeightedRatios weighted(const LogRatios& ratios, const PlaceOptions& options, bool coarse) {
  WeightedRatios result;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto channel = static_cast<Channel>(c);
    const double weight = (isObject(channel) ? options.object_weight : options.surface_weight) *
                          blockWeight(channel, coarse ? coarseBlock(channel) : fineBlock(channel));
    for (int b = 0; b <= kDistanceBins; ++b)
      result.value[c][b] = static_cast<float>(weight) * ratios.value[c][b];
    result.expected[c] = static_cast<float>(weight) * ratios.expected[c];
  }
  return result;
}

/// Fine cells per side of a coarse one: a power of two, so that tiles hold whole coarse cells.
int cellsPerSide(double coarse_cell_m, double fine_cell_m) {
  int sub = 1;
  while (sub < PlanField::kTileCells && sub * 1.5 < coarse_cell_m / fine_cell_m) sub *= 2;
  return sub;
}

/// Mean and maximum of the fine cells in a coarse one, blended: a surface that only touches the
/// cell still counts.
float blendedRatio(const std::uint8_t* bins, int sub,
                   const std::array<float, kDistanceBins + 1>& ratios, float mean_share) {
  float sum = 0, best = ratios[bins[0]];
  for (int y = 0; y < sub; ++y) {
    for (int x = 0; x < sub; ++x) {
      const float v = ratios[bins[y * PlanField::kTileCells + x]];
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

/// Ratios as bytes above the lowest one of their channel; the background is what unseen area has.
LikelihoodRaster makeRaster(const PlanField& field, const WeightedRatios& ratios, double cell_m) {
  const int sub = cellsPerSide(cell_m, field.cellSize());
  std::vector<float> lowest;
  std::vector<std::uint8_t> background;
  for (const auto& values : ratios.value) {
    lowest.push_back(*std::min_element(values.begin(), values.end()));
    background.push_back(quantized(-lowest.back()));
  }
  LikelihoodRaster raster(sub * field.cellSize(), background);
  for (const PlanField::Tile& tile : field.tiles()) {
    const std::int32_t first_x = tile.x * (PlanField::kTileCells / sub),
                       first_y = tile.y * (PlanField::kTileCells / sub);
    for (std::size_t c = 0; c < kChannels; ++c) {
      const float mean_share = isObject(static_cast<Channel>(c)) ? 0.5f : 0.7f;
      for (int y = 0; y < PlanField::kTileCells / sub; ++y) {
        for (int x = 0; x < PlanField::kTileCells / sub; ++x) {
          const std::uint8_t* bins = tile.bins[c] + y * sub * PlanField::kTileCells + x * sub;
          const std::uint8_t value =
              quantized(blendedRatio(bins, sub, ratios.value[c], mean_share) - lowest[c]);
          if (value != background[c]) raster.set(c, first_x + x, first_y + y, value);
        }
      }
    }
  }
  return raster;
}

std::vector<RasterSample> rasterSamples(const std::vector<PlanQuery::Sample>& samples) {
  std::vector<RasterSample> result;
  for (const auto& s : samples) result.push_back({s.x, s.y, s.channel});
  return result;
}

}  // namespace

struct PlanPlaces::Index {
  Index(const PlanView& map, const std::vector<Eigen::Vector3d>& trajectory,
        const LikelihoodTable& likelihoods, const PlaceOptions& place_options, int threads)
      : options(place_options), table(likelihoods), field(map, threads), origin_z(map.origin_z) {
    std::vector<Eigen::Vector2d> path;
    for (const Eigen::Vector3d& p : trajectory)
      path.emplace_back(p.x() - map.origin_x, p.y() - map.origin_y);
    null = mapNull(map, path, field);
  }

  const ViewIndex& view(Viewpoint viewpoint) const {
    const auto v = static_cast<std::size_t>(viewpoint);
    std::call_once(once[v], [&] {
      const LogRatios ratios = logRatios(table, viewpoint, &null, options.map_null_mix);
      const WeightedRatios coarse = weighted(ratios, options, true);
      views[v] = std::make_unique<ViewIndex>(
          ViewIndex{weighted(ratios, options, false),
                    makeRaster(field, coarse, options.coarse_cell_m), std::nullopt});
      if (field.tiles().size() >= kLargeMapTiles)
        views[v]->first_look = makeRaster(field, coarse, 2 * options.coarse_cell_m);
    });
    return *views[v];
  }

  RasterSearchOptions searchOptions(const PlacePrior& prior_of_centre, int threads) const {
    RasterSearchOptions search;
    search.max_yaw_step_rad = options.max_yaw_step_deg * M_PI / 180;
    search.keep_cells = static_cast<std::size_t>(options.keep_cells);
    search.keep_poses = static_cast<std::size_t>(options.keep_poses);
    search.threads = threads;
    search.centre_prior = prior_of_centre;
    if (search.centre_prior.near) {
      search.centre_prior.near->x -= field.originX();
      search.centre_prior.near->y -= field.originY();
    }
    return search;
  }

  PlaceOptions options;
  LikelihoodTable table;
  PlanField field;
  double origin_z;
  MapNull null;
  mutable std::array<std::once_flag, 2> once;
  mutable std::array<std::unique_ptr<ViewIndex>, 2> views;
};

namespace {

/// Pose of the query centre in plan coordinates -> pose of the query frame in map coordinates, and
/// back.
PlacePose toFrame(const PlacePose& centre_pose, const PlanQuery& query, const PlanField& field) {
  const Eigen::Vector2d t =
      Eigen::Vector2d(centre_pose.x + field.originX(), centre_pose.y + field.originY()) -
      Eigen::Rotation2Dd(centre_pose.yaw) * query.centre;
  return {t.x(), t.y(), angleDifference(centre_pose.yaw, 0), centre_pose.score};
}

PlacePose toCentre(const PlacePose& frame_pose, const PlanQuery& query, const PlanField& field) {
  const Eigen::Vector2d t =
      Eigen::Vector2d(frame_pose.x - field.originX(), frame_pose.y - field.originY()) +
      Eigen::Rotation2Dd(frame_pose.yaw) * query.centre;
  return {t.x(), t.y(), frame_pose.yaw, frame_pose.score};
}

PlanHypothesis hypothesisAt(const PlacePose& centre_pose, const PlanQuery& query,
                            const PlanField& field, const WeightedRatios& ratios,
                            double map_origin_z) {
  PlanHypothesis h;
  h.pose = toFrame(centre_pose, query, field);
  h.z = map_origin_z + heightOffset(field, query, centre_pose);
  const ScoreDetails details = scoreDetails(field, ratios, query.fine, centre_pose);
  h.expected = details.expected;
  h.known_share = details.known_share;
  h.standing = details.standing;
  h.sides = details.sides;
  h.objects = details.objects;
  h.objects_matched = details.objects_matched;
  return h;
}

bool byScore(const PlacePose& a, const PlacePose& b) {
  if (a.score != b.score) return a.score > b.score;
  if (a.y != b.y) return a.y < b.y;
  return a.x != b.x ? a.x < b.x : a.yaw < b.yaw;
}

/// The best poses, each unlike the ones before it.
std::vector<PlacePose> distinct(std::vector<PlacePose> poses, std::size_t count) {
  std::sort(poses.begin(), poses.end(), byScore);
  std::vector<PlacePose> kept;
  for (const PlacePose& p : poses) {
    if (kept.size() >= count) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PlacePose& k) {
      return std::hypot(k.x - p.x, k.y - p.y) < kSameRefined_m &&
             std::abs(angleDifference(k.yaw, p.yaw)) < kSameRefined_rad;
    });
    if (!known) kept.push_back(p);
  }
  return kept;
}

/// The first pose of each place.
std::vector<PlacePose> differentPlaces(const std::vector<PlacePose>& poses) {
  std::vector<PlacePose> places;
  for (const PlacePose& p : poses) {
    const auto same = [&](const PlacePose& other) { return samePlace(other, p); };
    if (std::none_of(places.begin(), places.end(), same)) places.push_back(p);
  }
  return places;
}

void climbAll(const PlanScore& score, double step_m, double step_rad, int levels, int threads,
              std::vector<PlacePose>& poses) {
  parallelFor(poses.size(), threads,
              [&](std::size_t i) { poses[i] = score.climb(poses[i], step_m, step_rad, levels); });
}

/// The best poses of the centre of some samples by the exhaustive search, climbed.
std::vector<PlacePose> posesOf(const ViewIndex& view, const std::vector<PlanQuery::Sample>& coarse,
                               const PlanScore& score, const RasterSearchOptions& options,
                               int refine_poses) {
  const std::vector<RasterSample> samples = rasterSamples(coarse);
  std::vector<PlacePose> poses =
      view.first_look
          ? searchRaster(*view.first_look, samples,
                         FineLevel{view.raster, samples, options.max_yaw_step_rad}, options)
          : searchRaster(view.raster, samples, options);
  climbAll(score, view.raster.cellSize() / 2, options.max_yaw_step_rad / 2, 2, options.threads,
           poses);
  poses = distinct(std::move(poses), static_cast<std::size_t>(refine_poses));
  climbAll(score, 0.5, 0.012, 3, options.threads, poses);
  return poses;
}

/// The same of a query that is too wide for the exhaustive search, by its densest part and ever
/// more around that.
std::vector<PlacePose> posesOfWide(const PlanField& field, const ViewIndex& view,
                                   const PlanQuery& query, const PlanScore& score,
                                   RasterSearchOptions options, int refine_poses) {
  constexpr double kStep_m = 0.5;
  const QueryPart densest = densestPart(query.fine, kPart_m);
  options.centre_prior = priorOfPart(options.centre_prior, densest);
  std::vector<PlacePose> poses =
      posesOf(view, partAround(query.coarse, densest.offset, kPart_m).samples,
              PlanScore(field, view.ratios, densest.samples), options, refine_poses);
  const double all_m = radiusOf(query.fine) + densest.offset.norm();
  for (double radius_m = kPart_m; radius_m < all_m;) {
    radius_m *= 1.5;
    const QueryPart part = partAround(query.fine, densest.offset, radius_m);
    climbAll(PlanScore(field, view.ratios, part.samples), kStep_m, kStep_m / radius_m, 3,
             options.threads, poses);
  }
  for (PlacePose& pose : poses) {  // of the centre of the query instead of that of its part
    const Eigen::Vector2d back = Eigen::Rotation2Dd(pose.yaw) * densest.offset;
    pose.x -= back.x();
    pose.y -= back.y();
    pose.score = score(pose.x, pose.y, pose.yaw);
  }
  return poses;
}

}  // namespace

PlanPlaces::PlanPlaces(const PlanView& map, const std::vector<Eigen::Vector3d>& trajectory,
                       const LikelihoodTable& table, const PlaceOptions& options, int threads)
    : index_(std::make_unique<Index>(map, trajectory, table, options, threads)) {}
PlanPlaces::~PlanPlaces() = default;

bool PlanPlaces::empty() const { return index_->field.tiles().empty(); }

std::vector<PlanHypothesis> PlanPlaces::search(const PlanQuery& query,
                                               const PlacePrior& prior_of_centre,
                                               int threads) const {
  if (empty() || query.empty()) return {};
  const Index& index = *index_;
  const ViewIndex& view = index.view(query.viewpoint);
  const PlanScore score(index.field, view.ratios, query.fine);
  const RasterSearchOptions options = index.searchOptions(prior_of_centre, threads);
  std::vector<PlacePose> poses =
      radiusOf(query.fine) > kWidest_m
          ? posesOfWide(index.field, view, query, score, options, index.options.refine_poses)
          : posesOf(view, query.coarse, score, options, index.options.refine_poses);
  std::sort(poses.begin(), poses.end(), byScore);
  poses = differentPlaces(poses);
  if (!poses.empty()) poses[0] = score.climb(poses[0], 0.125, 0.003, 2);
  std::vector<PlanHypothesis> places;
  for (const PlacePose& p : poses) {
    places.push_back(hypothesisAt(p, query, index.field, view.ratios, index.origin_z));
  }
  return places;
}

PlanHypothesis PlanPlaces::verify(const PlanQuery& query, const PlacePose& proposed) const {
  const ViewIndex& view = index_->view(query.viewpoint);
  const PlanScore score(index_->field, view.ratios, query.fine);
  const PlacePose best = score.climb(toCentre(proposed, query, index_->field), 1.0, 0.024, 4);
  return hypothesisAt(best, query, index_->field, view.ratios, index_->origin_z);
}

PlanHypothesis PlanPlaces::describe(const PlanQuery& query, const PlacePose& pose) const {
  PlacePose centre = toCentre(pose, query, index_->field);
  centre.score = score(query, pose);
  return hypothesisAt(centre, query, index_->field, index_->view(query.viewpoint).ratios,
                      index_->origin_z);
}

double PlanPlaces::score(const PlanQuery& query, const PlacePose& pose) const {
  const ViewIndex& view = index_->view(query.viewpoint);
  const PlacePose centre = toCentre(pose, query, index_->field);
  return PlanScore(index_->field, view.ratios, query.fine)(centre.x, centre.y, centre.yaw);
}

std::vector<SampleEvidence> PlanPlaces::evidence(const PlanQuery& query,
                                                 const PlacePose& pose) const {
  const WeightedRatios& ratios = index_->view(query.viewpoint).ratios;
  const std::vector<std::uint8_t> bins =
      distanceBins(index_->field, query.fine, toCentre(pose, query, index_->field));
  const Eigen::Rotation2Dd turn(pose.yaw);
  std::vector<SampleEvidence> evidence;
  for (std::size_t i = 0; i < query.fine.size(); ++i) {
    const PlanQuery::Sample& q = query.fine[i];
    SampleEvidence e;
    e.channel = static_cast<Channel>(q.channel);
    e.query = query.centre + Eigen::Vector2d(q.x, q.y);
    e.map = turn * e.query + Eigen::Vector2d(pose.x, pose.y);
    e.distance_bin = bins[i];
    e.nats = ratios.value[q.channel][bins[i]];
    e.expected = bins[i] == kUnknownBin ? 0 : ratios.expected[q.channel];
    evidence.push_back(e);
  }
  return evidence;
}

GroundFit PlanPlaces::fitGround(const PlanQuery& query, const PlacePose& pose,
                                double slope_sigma) const {
  GroundFit fit = xview::fitGround(index_->field, query.ground,
                                   toCentre(pose, query, index_->field), slope_sigma);
  fit.height_m += index_->origin_z;
  return fit;
}

std::size_t PlanPlaces::bytes() const {
  std::size_t total = index_->field.bytes();
  for (const auto& view : index_->views) {
    if (view) total += view->raster.bytes() + (view->first_look ? view->first_look->bytes() : 0);
  }
  return total;
}

}  // namespace xview
