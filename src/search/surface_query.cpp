// SPDX-License-Identifier: BSD-3-Clause
#include "search/surface_query.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace xview::search {
namespace {

constexpr double kSurfaceWeight = 0.3;  ///< evidence of a surface sample per 2 m, in ratios
constexpr double kObjectWeight = 2;     ///< evidence of an object
constexpr double kGroundBlock_m = 2;    ///< heights of the ground, one per block
/// Things that stand or do not stand at a place together. Larger blocks hide things behind others.
constexpr double kThingsBlock_m = 4;
constexpr double kConflictPrior_nats = 15;  ///< at even odds, as a few things say little

/// Classes that fill areas in BEV grid; facades of whole blocks of houses are seen as areas, too.
bool fillsArea(BevChannel c) { return isArea(c) || c == BevChannel::building; }

/// Side of the blocks that a sample stands for [m]; 0 = all samples are kept.
double blockOf(BevChannel c, bool coarse) {
  if (isObject(c)) return 0;
  return (fillsArea(c) ? 4.0 : 3.0) * (coarse ? 2 : 1);
}

/// One sample per block: the nearest to the centre of the block.
std::vector<BevSample> onePerBlock(const std::vector<BevSample>& samples, double block_m) {
  struct Kept {
    std::size_t sample;
    double distance;
  };
  std::map<std::pair<std::int64_t, std::int64_t>, Kept> blocks;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double bx = std::floor(samples[i].x / block_m), by = std::floor(samples[i].y / block_m);
    const double d =
        std::hypot(samples[i].x - (bx + 0.5) * block_m, samples[i].y - (by + 0.5) * block_m);
    const auto [it, is_new] = blocks.try_emplace(
        {static_cast<std::int64_t>(by), static_cast<std::int64_t>(bx)}, Kept{i, d});
    if (!is_new && d < it->second.distance) it->second = {i, d};
  }
  std::vector<BevSample> result;
  for (const auto& [block, kept] : blocks) result.push_back(samples[kept.sample]);
  return result;
}

std::vector<SurfaceSamples::Sample> gather(const BevGrid& view, bool coarse,
                                           const Eigen::Vector2d& centre) {
  std::vector<SurfaceSamples::Sample> result;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const auto channel = static_cast<BevChannel>(c);
    const double block = blockOf(channel, coarse);
    for (const BevSample& s : block > 0 ? onePerBlock(view.samples[c], block) : view.samples[c]) {
      result.push_back({static_cast<float>(view.origin_x + s.x - centre.x()),
                        static_cast<float>(view.origin_y + s.y - centre.y()),
                        static_cast<std::uint8_t>(c), static_cast<float>(view.origin_z + s.z)});
    }
  }
  return result;
}

/// Upright surfaces, and anything that stands there. Roads and verges of one town resemble those of
/// another; walls, hedges and crowns do so less.
bool stands(BevChannel c) { return !isArea(c) && !isObject(c) && !isBorder(c); }

constexpr int kMostMoves = 8;          ///< per level of the refinement
constexpr double kMostReach_m = 1000;  ///< of a window of tiles

/// Maps points about the query centre to cells of the field.
struct CellTransform {
  CellTransform(const DistanceField& field, double px, double py, double yaw)
      : c(static_cast<float>(std::cos(yaw) / field.cellSize())),
        s(static_cast<float>(std::sin(yaw) / field.cellSize())),
        cell_x(static_cast<std::int32_t>(std::floor(px / field.cellSize()))),
        cell_y(static_cast<std::int32_t>(std::floor(py / field.cellSize()))),
        x(static_cast<float>(px / field.cellSize() - cell_x)),
        y(static_cast<float>(py / field.cellSize() - cell_y)) {}
  std::int32_t cellX(float qx, float qy) const { return cell_x + floorToInt(x + c * qx - s * qy); }
  std::int32_t cellY(float qx, float qy) const { return cell_y + floorToInt(y + s * qx + c * qy); }

  static std::int32_t floorToInt(float v) {
    const auto i = static_cast<std::int32_t>(v);
    return i - (v < static_cast<float>(i));
  }

  float c, s;
  std::int32_t cell_x, cell_y;
  float x, y;
};

using Planes = std::array<const std::uint8_t*, kBevChannels>;

/// The classes of a tile that was never seen.
const Planes& unknownPlanes() {
  static constexpr auto kCells =
      static_cast<std::size_t>(DistanceField::kTileCells * DistanceField::kTileCells);
  static const std::vector<std::uint8_t> unknown(kCells, kUnknownBin);
  static const Planes planes = [] {
    Planes all;
    all.fill(unknown.data());
    return all;
  }();
  return planes;
}

/// The tiles around a point in rows, so that a cell needs no search.
class TileWindow {
 public:
  /// All cells that are at most `reach_m` away.
  TileWindow(const DistanceField& field, double x, double y, double reach_m)
      : first_x_(tileOf(x - reach_m, field)),
        first_y_(tileOf(y - reach_m, field)),
        width_(tileOf(x + reach_m, field) - first_x_ + 1) {
    const std::int32_t last_y = tileOf(y + reach_m, field);
    for (std::int32_t ty = first_y_; ty <= last_y; ++ty) {
      for (std::int32_t tx = first_x_; tx < first_x_ + width_; ++tx) {
        const DistanceField::Tile* tile =
            field.tileOfCell(tx * DistanceField::kTileCells, ty * DistanceField::kTileCells);
        tiles_.push_back(tile ? &tile->bins : &unknownPlanes());
      }
    }
  }
  std::uint8_t bin(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
    const Planes& planes =
        *tiles_[static_cast<std::size_t>(((cy >> 6) - first_y_) * width_ + (cx >> 6) - first_x_)];
    return planes[channel][DistanceField::cellInTile(cx, cy)];
  }

 private:
  static std::int32_t tileOf(double metres, const DistanceField& field) {
    return static_cast<std::int32_t>(std::floor(metres / field.cellSize())) >> 6;
  }
  std::int32_t first_x_, first_y_, width_;
  std::vector<const Planes*> tiles_;
};

template <class Score>
PlacePose refineBy(const Score& score, PlacePose pose, double step_m, double step_rad, int levels) {
  static constexpr double kMoves[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                          {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  pose.score = score(pose);
  for (int level = 0; level < levels; ++level, step_m /= 2, step_rad /= 2) {
    int back = -1;  // the move that undoes the last one, which is known to be worse
    for (int move = 0; move < kMostMoves; ++move) {
      PlacePose best = pose;
      int taken = -1;
      for (int i = 0; i < 6; ++i) {
        if (i == back) continue;
        const auto& m = kMoves[i];
        PlacePose next{pose.x + m[0] * step_m, pose.y + m[1] * step_m, pose.yaw + m[2] * step_rad,
                       0};
        next.score = score(next);
        if (next.score <= best.score) continue;
        best = next;
        taken = i;
      }
      if (taken < 0) break;
      back = taken ^ 1;
      pose = best;
    }
  }
  return pose;
}

}  // namespace

double radiusOf(const std::vector<SurfaceSamples::Sample>& samples) {
  double radius = 0;
  for (const auto& s : samples) radius = std::max(radius, std::hypot(double{s.x}, double{s.y}));
  return radius;
}

SurfaceSamples surfaceSamples(const BevGrid& view) {
  SurfaceSamples query;
  query.aerial = view.aerial;
  const auto about_zero = gather(view, false, Eigen::Vector2d::Zero());
  if (about_zero.empty()) return query;
  for (const auto& s : about_zero) query.centre += Eigen::Vector2d(s.x, s.y);
  query.centre /= static_cast<double>(about_zero.size());
  query.fine = gather(view, false, query.centre);
  query.coarse = gather(view, true, query.centre);
  for (const BevChannel c : {BevChannel::road, BevChannel::sidewalk, BevChannel::terrain}) {
    for (const BevSample& s : onePerBlock(view[c], kGroundBlock_m)) {
      query.ground.push_back({static_cast<float>(view.origin_x + s.x - query.centre.x()),
                              static_cast<float>(view.origin_y + s.y - query.centre.y()),
                              static_cast<float>(view.origin_z + s.z)});
    }
  }
  return query;
}

SurfaceSamples partOf(const SurfaceSamples& samples, const Eigen::Vector2d& centre,
                      double radius_m) {
  SurfaceSamples part;
  part.centre = centre;
  part.aerial = samples.aerial;
  const Eigen::Vector2d offset = centre - samples.centre;
  const auto shifted = [&](auto sample) {
    sample.x -= static_cast<float>(offset.x());
    sample.y -= static_cast<float>(offset.y());
    return sample;
  };
  const auto takeNear = [&](const std::vector<SurfaceSamples::Sample>& from,
                            std::vector<SurfaceSamples::Sample>& to) {
    for (const SurfaceSamples::Sample& s : from) {
      if ((Eigen::Vector2d(s.x, s.y) - offset).squaredNorm() <= radius_m * radius_m)
        to.push_back(shifted(s));
    }
  };
  takeNear(samples.fine, part.fine);
  takeNear(samples.coarse, part.coarse);
  for (const SurfaceSamples::Ground& g : samples.ground) part.ground.push_back(shifted(g));
  return part;
}

double sampleWeight(BevChannel channel, bool coarse) {
  if (isObject(channel)) return kObjectWeight;
  const double side = blockOf(channel, coarse) / 2;
  return kSurfaceWeight * (fillsArea(channel) ? side * side : side);
}

SurfaceScore::SurfaceScore(const DistanceField& field, const WeightedRatios& ratios,
                           const std::vector<SurfaceSamples::Sample>& samples)
    : field_(field), ratios_(ratios), samples_(samples), radius_m_(radiusOf(samples)) {
  for (const SurfaceSamples::Sample& q : samples) {
    if (lanes_.empty() || lanes_.back().count == Lanes::kCount) lanes_.emplace_back();
    Lanes& lanes = lanes_.back();
    lanes.x[lanes.count] = q.x;
    lanes.y[lanes.count] = q.y;
    lanes.channel[lanes.count++] = q.channel;
  }
}

/// `where`: DistanceField or a TileWindow that holds all cells.
template <class Cells>
double SurfaceScore::scoreIn(const Cells& where, const PlacePose& pose) const {
  const CellTransform to_cell(field_, pose.x, pose.y, pose.yaw);
  std::array<std::int32_t, Lanes::kCount> cx, cy;
  double score = 0;
  for (const Lanes& lanes : lanes_) {
    for (std::size_t i = 0; i < Lanes::kCount; ++i) {
      cx[i] = to_cell.cellX(lanes.x[i], lanes.y[i]);
      cy[i] = to_cell.cellY(lanes.x[i], lanes.y[i]);
    }
    for (std::size_t i = 0; i < lanes.count; ++i)
      score += ratios_.value[lanes.channel[i]][where.bin(lanes.channel[i], cx[i], cy[i])];
  }
  return score;
}

double SurfaceScore::operator()(const PlacePose& pose) const { return scoreIn(field_, pose); }

PlacePose SurfaceScore::refineLocally(PlacePose pose, double step_m, double step_rad,
                                      int levels) const {
  // Steps are halved, so all levels go less far than twice the first.
  const double reach_m = radius_m_ + (2 * kMostMoves + 1) * step_m + 1;
  if (reach_m > kMostReach_m) return refineBy(*this, pose, step_m, step_rad, levels);
  const TileWindow window(field_, pose.x, pose.y, reach_m);
  return refineBy([&](const PlacePose& p) { return scoreIn(window, p); }, pose, step_m, step_rad,
                  levels);
}

std::vector<std::uint8_t> SurfaceScore::distanceBins(const PlacePose& pose) const {
  const CellTransform to_cell(field_, pose.x, pose.y, pose.yaw);
  std::vector<std::uint8_t> bins;
  for (const SurfaceSamples::Sample& q : samples_)
    bins.push_back(field_.bin(q.channel, to_cell.cellX(q.x, q.y), to_cell.cellY(q.x, q.y)));
  return bins;
}

PlaceHypothesis SurfaceScore::details(const PlacePose& pose, PlaceHypothesis h) const {
  constexpr std::uint8_t kMatchedBins = 3;  // nearer than 1 m
  const std::vector<std::uint8_t> bins = distanceBins(pose);
  std::size_t known = 0;
  h.of_surfaces = true;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const SurfaceSamples::Sample& q = samples_[i];
    const std::uint8_t bin = bins[i];
    if (bin == kUnknownBin) continue;
    ++known;
    const auto channel = static_cast<BevChannel>(q.channel);
    const float expected = ratios_.expected[q.channel];
    h.expected += expected;
    if (stands(channel)) {
      h.obstacles.score += ratios_.value[q.channel][bin];
      h.obstacles.expected += expected;
    }
    h.matched += isObject(channel) && bin < kMatchedBins;
  }
  h.map_coverage =
      samples_.empty() ? 0 : static_cast<double>(known) / static_cast<double>(samples_.size());
  return h;
}

std::vector<SampleEvidence> SurfaceScore::evidence(const PlacePose& pose) const {
  const std::vector<std::uint8_t> bins = distanceBins(pose);
  std::vector<SampleEvidence> evidence;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const SurfaceSamples::Sample& q = samples_[i];
    SampleEvidence e;
    e.channel = static_cast<BevChannel>(q.channel);
    e.query = {q.x, q.y};
    e.known = bins[i] != kUnknownBin;
    e.nats = ratios_.value[q.channel][bins[i]];
    e.expected = e.known ? ratios_.expected[q.channel] : 0;
    evidence.push_back(e);
  }
  return evidence;
}

PartScore obstaclesIn(const std::vector<SampleEvidence>& evidence) {
  PartScore sum;
  for (const SampleEvidence& e : evidence) {
    if (!e.known || std::count(kObstacles.begin(), kObstacles.end(), e.channel) == 0) continue;
    sum.score += e.nats;
    sum.expected += std::max(0.0, e.expected);
  }
  return sum;
}

double conflictRatioOf(const std::vector<SampleEvidence>& evidence) {
  std::map<std::pair<std::int64_t, std::int64_t>, PartScore> blocks;
  for (const SampleEvidence& e : evidence) {
    if (!e.known || !(stands(e.channel) || isObject(e.channel))) continue;
    PartScore& block =
        blocks[{static_cast<std::int64_t>(std::floor(e.query.y() / kThingsBlock_m)),
                static_cast<std::int64_t>(std::floor(e.query.x() / kThingsBlock_m))}];
    block.score += e.nats;
    block.expected += std::max(0.0, e.expected);
  }
  double against = kConflictThreshold * kConflictPrior_nats, all = kConflictPrior_nats;
  for (const auto& [where, block] : blocks) {
    if (block.score < 0) against += block.expected;
    all += block.expected;
  }
  return against / all;
}

}  // namespace xview::search
