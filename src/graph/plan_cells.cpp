// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace xview {
namespace {

constexpr float kLowFrom = 0.3f, kObstacleFrom = 0.4f, kLowTo = 2.0f, kHighFrom = 2.5f;

UprightCell& uprightCell(PlanCells& cells, std::int32_t cell) {
  std::int32_t& number = cells.upright_of[cell];
  if (number < 0) {
    number = static_cast<std::int32_t>(cells.upright.size());
    cells.upright.emplace_back();
  }
  return cells.upright[number];
}

void addObstacle(UprightCell& cell, float height, float votes) {
  if (height > kObstacleFrom && height < kLowTo) cell.obstacle_low += votes;
  if (height > kHighFrom) cell.obstacle_high += votes;
}

void addUpright(UprightCell& cell, const PlanVoxel& v, float height) {
  const auto k = static_cast<std::size_t>(v.kind);
  if (isPoleLike(v.kind)) cell.near_votes[k - static_cast<std::size_t>(Kind::pole)] += v.near_votes;
  cell.bottom[k] = cell.votes[k] > 0 ? std::min(cell.bottom[k], height) : height;
  cell.top[k] = cell.votes[k] > 0 ? std::max(cell.top[k], height) : height;
  cell.votes[k] += v.votes;
  cell.sum_x[k] += v.votes * v.x;
  cell.sum_y[k] += v.votes * v.y;
  if (height > kLowFrom && height < kLowTo) cell.low[k] += v.votes;
  if (height > kHighFrom) cell.high[k] += v.votes;
}

}  // namespace

float UprightCell::total() const { return std::accumulate(votes.begin(), votes.end(), 0.f); }

bool UprightCell::holds(Kind kind, double min_votes, double min_share) const {
  return of(kind) >= min_votes && of(kind) >= min_share * total();
}

PlanSample UprightCell::centre(Kind kind) const {
  const auto k = static_cast<std::size_t>(kind);
  return {sum_x[k] / votes[k], sum_y[k] / votes[k], 0};
}

PlanCells sortIntoCells(const std::vector<PlanVoxel>& voxels, const GroundSurface& ground, const GroundRule& rule,
                        const PlanOptions& options) {
  PlanCells cells;
  const double inverse_cell = 1.0 / options.cell_m;
  const auto gate = static_cast<float>(rule.gate_m), min_height = static_cast<float>(options.min_height_m);
  std::vector<float> height_sum;
  for (const PlanVoxel& v : voxels) {
    const std::int32_t cell = cells.index.findOrAdd(static_cast<std::int32_t>(std::floor(v.x * inverse_cell)),
                                                    static_cast<std::int32_t>(std::floor(v.y * inverse_cell)));
    if (cells.floor.size() <= static_cast<std::size_t>(cell)) {
      cells.floor.emplace_back();
      cells.upright_of.push_back(-1);
      height_sum.push_back(0);
      const double side = options.cell_m;
      const CellIndex::Cell c = cells.index.cells()[cell];
      cells.floor[cell].height =
          ground.heightAt(static_cast<float>((c.x + 0.5) * side), static_cast<float>((c.y + 0.5) * side));
    }
    FloorCell& floor = cells.floor[cell];
    floor.total += v.votes;
    const float height = v.z - floor.height;
    if (isGround(v.kind)) {
      if (std::abs(height) < gate) {
        floor.votes[static_cast<std::size_t>(v.kind)] += v.votes;
        height_sum[cell] += v.votes * v.z;
      } else if (height > 0) {
        addObstacle(uprightCell(cells, cell), height, v.votes);  // e.g. a crown labelled as terrain
      }
      continue;
    }
    UprightCell& upright = uprightCell(cells, cell);
    addObstacle(upright, height, v.votes);
    if (v.kind != Kind::none && height >= min_height) addUpright(upright, v, height);
  }
  for (std::size_t i = 0; i < cells.floor.size(); ++i) {
    const float votes = cells.floor[i].ground();
    if (votes > options.min_votes) cells.floor[i].height = height_sum[i] / votes;
  }
  return cells;
}

}  // namespace xview
