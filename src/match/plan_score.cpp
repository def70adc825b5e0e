// SPDX-License-Identifier: BSD-3-Clause
#include "match/plan_score.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

/// Upright surfaces, and anything that stands there. Roads and verges of one town resemble those of
/// another; walls, hedges and crowns do so less.
bool stands(Channel c) {
  return !isArea(c) && !isObject(c) &&
         (c < Channel::border_road_sidewalk || c > Channel::border_road_terrain);
}

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

}  // namespace

double PlanScore::operator()(double x, double y, double yaw) const {
  const CellTransform to_cell(field_, x, y, yaw);
  double score = 0;
  for (const PlanQuery::Sample& q : samples_) {
    score += ratios_.value[q.channel]
                          [field_.bin(q.channel, to_cell.cellX(q.x, q.y), to_cell.cellY(q.x, q.y))];
  }
  return score;
}

PlacePose PlanScore::climb(PlacePose pose, double step_m, double step_rad, int levels) const {
  static constexpr double kMoves[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                          {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  constexpr int kMostMoves = 8;
  pose.score = (*this)(pose.x, pose.y, pose.yaw);
  for (int level = 0; level < levels; ++level, step_m /= 2, step_rad /= 2) {
    for (int move = 0; move < kMostMoves; ++move) {
      PlacePose best = pose;
      for (const auto& m : kMoves) {
        PlacePose next{pose.x + m[0] * step_m, pose.y + m[1] * step_m, pose.yaw + m[2] * step_rad,
                       0};
        next.score = (*this)(next.x, next.y, next.yaw);
        if (next.score > best.score) best = next;
      }
      if (best.score <= pose.score) break;
      pose = best;
    }
  }
  return pose;
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
    if (stands(static_cast<Channel>(q.channel))) {
      details.standing_score += ratios.value[q.channel][bin];
      details.standing_expected += ratios.expected[q.channel];
    }
    if (!isObject(static_cast<Channel>(q.channel))) continue;
    ++details.objects;
    details.objects_matched += bin < kMatchedBins;
  }
  details.known_share =
      samples.empty() ? 0 : static_cast<double>(known) / static_cast<double>(samples.size());
  return details;
}

double medianHeightOffset(const PlanField& field, const std::vector<PlanQuery::Ground>& ground,
                          const PlacePose& pose) {
  const CellTransform to_cell(field, pose.x, pose.y, pose.yaw);
  std::vector<float> offsets;
  for (const PlanQuery::Ground& q : ground) {
    const std::int32_t cx = to_cell.cellX(q.x, q.y), cy = to_cell.cellY(q.x, q.y);
    const PlanField::Tile* tile = field.tileOfCell(cx, cy);
    if (!tile) continue;
    const float height = tile->ground[PlanField::cellInTile(cx, cy)];
    if (!std::isnan(height)) offsets.push_back(height - q.z);
  }
  if (offsets.empty()) return 0;
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

}  // namespace xview
