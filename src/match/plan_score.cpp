// SPDX-License-Identifier: BSD-3-Clause
#include "match/plan_score.h"

#include <algorithm>
#include <cmath>

#include "match/wide_query.h"

namespace xview {
namespace {

/// Upright surfaces, and anything that stands there. Roads and verges of one town resemble those of
/// another; walls, hedges and crowns do so less.
bool stands(Channel c) {
  return !isArea(c) && !isObject(c) &&
         (c < Channel::border_road_sidewalk || c > Channel::border_road_terrain);
}

void add(const PlanPart& sample, PlanPart& part) {
  part.score += sample.score;
  part.expected += sample.expected;
}

constexpr int kMostMoves = 8;          ///< per level of a climb
constexpr double kMostReach_m = 1000;  ///< of a window of tiles

/// Maps points about the query centre to cells of the field.
struct CellTransform {
  CellTransform(const PlanField& field, double px, double py, double yaw)
      : c(static_cast<float>(std::cos(yaw) / field.cellSize())),
        s(static_cast<float>(std::sin(yaw) / field.cellSize())),
        cell_x(std::floor(px / field.cellSize())),
        cell_y(std::floor(py / field.cellSize())),
        x(static_cast<float>(px / field.cellSize() - cell_x)),
        y(static_cast<float>(py / field.cellSize() - cell_y)) {}
  std::int32_t cellX(float qx, float qy) const {
    return base(cell_x) + floorToInt(x + c * qx - s * qy);
  }
  std::int32_t cellY(float qx, float qy) const {
    return base(cell_y) + floorToInt(y + s * qx + c * qy);
  }

  static std::int32_t base(double cell) { return static_cast<std::int32_t>(cell); }
  static std::int32_t floorToInt(float v) {
    const auto i = static_cast<std::int32_t>(v);
    return i - (v < static_cast<float>(i));
  }

  float c, s;
  double cell_x, cell_y;
  float x, y;
};

using Planes = std::array<const std::uint8_t*, kChannels>;

/// The classes of a tile that was never seen.
const Planes& unknownPlanes() {
  static constexpr auto kCells =
      static_cast<std::size_t>(PlanField::kTileCells * PlanField::kTileCells);
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
  TileWindow(const PlanField& field, double x, double y, double reach_m)
      : first_x_(tileOf(x - reach_m, field)),
        first_y_(tileOf(y - reach_m, field)),
        width_(tileOf(x + reach_m, field) - first_x_ + 1) {
    const std::int32_t last_y = tileOf(y + reach_m, field);
    for (std::int32_t ty = first_y_; ty <= last_y; ++ty) {
      for (std::int32_t tx = first_x_; tx < first_x_ + width_; ++tx) {
        const PlanField::Tile* tile =
            field.tileOfCell(tx * PlanField::kTileCells, ty * PlanField::kTileCells);
        tiles_.push_back(tile ? &tile->bins : &unknownPlanes());
      }
    }
  }
  std::uint8_t bin(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
    const Planes& planes =
        *tiles_[static_cast<std::size_t>(((cy >> 6) - first_y_) * width_ + (cx >> 6) - first_x_)];
    return planes[channel][PlanField::cellInTile(cx, cy)];
  }

 private:
  static std::int32_t tileOf(double metres, const PlanField& field) {
    return static_cast<std::int32_t>(std::floor(metres / field.cellSize())) >> 6;
  }
  std::int32_t first_x_, first_y_, width_;
  std::vector<const Planes*> tiles_;
};

/// `where`: PlanField or a TileWindow that holds all cells.
template <class Cells>
double scoreIn(const Cells& where, const PlanField& field, const WeightedRatios& ratios,
               const std::vector<PlanQuery::Sample>& samples, const PlacePose& pose) {
  const CellTransform to_cell(field, pose.x, pose.y, pose.yaw);
  double score = 0;
  for (const PlanQuery::Sample& q : samples) {
    score += ratios.value[q.channel]
                         [where.bin(q.channel, to_cell.cellX(q.x, q.y), to_cell.cellY(q.x, q.y))];
  }
  return score;
}

template <class Score>
PlacePose climbBy(const Score& score, PlacePose pose, double step_m, double step_rad, int levels) {
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

PlanScore::PlanScore(const PlanField& field, const WeightedRatios& ratios,
                     const std::vector<PlanQuery::Sample>& samples)
    : field_(field), ratios_(ratios), samples_(samples), radius_m_(radiusOf(samples)) {}

double PlanScore::operator()(double x, double y, double yaw) const {
  return scoreIn(field_, field_, ratios_, samples_, {x, y, yaw, 0});
}

PlacePose PlanScore::climb(PlacePose pose, double step_m, double step_rad, int levels) const {
  // Steps are halved, so all levels go less far than twice the first.
  const double reach_m = radius_m_ + (2 * kMostMoves + 1) * step_m + 1;
  if (reach_m > kMostReach_m) {
    return climbBy([&](const PlacePose& p) { return (*this)(p.x, p.y, p.yaw); }, pose, step_m,
                   step_rad, levels);
  }
  const TileWindow window(field_, pose.x, pose.y, reach_m);
  return climbBy([&](const PlacePose& p) { return scoreIn(window, field_, ratios_, samples_, p); },
                 pose, step_m, step_rad, levels);
}

std::vector<std::uint8_t> distanceBins(const PlanField& field,
                                       const std::vector<PlanQuery::Sample>& samples,
                                       const PlacePose& pose) {
  const CellTransform to_cell(field, pose.x, pose.y, pose.yaw);
  std::vector<std::uint8_t> bins;
  for (const PlanQuery::Sample& q : samples)
    bins.push_back(field.bin(q.channel, to_cell.cellX(q.x, q.y), to_cell.cellY(q.x, q.y)));
  return bins;
}

ScoreDetails scoreDetails(const PlanField& field, const WeightedRatios& ratios,
                          const std::vector<PlanQuery::Sample>& samples, const PlacePose& pose) {
  constexpr std::uint8_t kMatchedBins = 3;  // nearer than 1 m
  ScoreDetails details;
  const std::vector<std::uint8_t> bins = distanceBins(field, samples, pose);
  std::size_t known = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const PlanQuery::Sample& q = samples[i];
    const std::uint8_t bin = bins[i];
    if (bin == kUnknownBin) continue;
    ++known;
    details.expected += ratios.expected[q.channel];
    const PlanPart sample{ratios.value[q.channel][bin], ratios.expected[q.channel]};
    if (stands(static_cast<Channel>(q.channel))) add(sample, details.standing);
    if (q.side != WaySide::none) add(sample, details.sides[q.side == WaySide::right]);
    if (!isObject(static_cast<Channel>(q.channel))) continue;
    ++details.objects;
    details.objects_matched += bin < kMatchedBins;
  }
  details.known_share =
      samples.empty() ? 0 : static_cast<double>(known) / static_cast<double>(samples.size());
  return details;
}

}  // namespace xview
