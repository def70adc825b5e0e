// SPDX-License-Identifier: BSD-3-Clause
#include "graph/bev_cells.h"

#include <algorithm>
#include <cmath>

#include "xview/graph/bev_grid.h"

namespace xview::graph {
namespace {

constexpr float kMinHeight_m =
    0.25f;  ///< upright classes below this are labels spilt on the ground
constexpr float kLowFrom = 0.3f, kObstacleFrom = 0.4f, kLowTo = 2.0f, kHighFrom = 2.5f;
constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::none);

/// The voxels of each cell.
Grouped groupByCell(const PlanVoxels& voxels, CellIndex& index) {
  std::vector<std::int32_t> cell_of(voxels.size());
  for (std::size_t i = 0; i < voxels.size(); ++i)
    cell_of[i] = index.findOrAdd(floorToInt(voxels[i].x / kPlanCell_m),
                                 floorToInt(voxels[i].y / kPlanCell_m));
  return Grouped(cell_of, index.size());
}

/// Gathers the votes of one cell after the other.
class CellSorter {
 public:
  explicit CellSorter(const GroundRule& rule) : gate_m_(static_cast<float>(rule.gate_m)) {}

  void start(float ground_height) {
    floor_ = {};
    floor_.height = ground_height;
    height_sum_ = 0;
    is_upright_ = false;
    upright_ = {};
    standing_.fill({});
  }

  void add(const PlanVoxel& v) {
    floor_.total += v.votes;
    const float height = v.z - floor_.height;
    if (!isGround(v.kind())) {
      addObstacle(v, height);
      if (height >= kMinHeight_m) addStanding(v, height);
    } else if (std::abs(height) < gate_m_) {
      floor_.votes[static_cast<std::size_t>(v.kind())] += v.votes;
      height_sum_ += v.votes * v.z;
    } else if (height > 0) {
      addObstacle(v, height);  // e.g. a crown labelled as terrain
    }
  }

  void finish(PlanCells& cells) {
    const float ground_votes = floor_.ground();
    if (ground_votes > kMinVotes) floor_.height = height_sum_ / ground_votes;
    cells.floor.push_back(floor_);
    cells.upright_of.push_back(is_upright_ ? static_cast<std::int32_t>(cells.upright.size()) : -1);
    if (!is_upright_) return;
    cells.upright.push_back(upright_);
    for (const Standing& s : standing_) {
      if (s.votes > 0) cells.standing.push_back(s);
    }
  }

 private:
  void addObstacle(const PlanVoxel& v, float height) {
    is_upright_ = true;
    if (height > kObstacleFrom && height < kLowTo) upright_.obstacle_low += v.votes;
    if (height > kHighFrom) upright_.obstacle_high += v.votes;
  }

  void addStanding(const PlanVoxel& v, float height) {
    Standing& s = standing_[static_cast<std::size_t>(v.kind())];
    s.kind = v.kind();
    s.bottom = s.votes > 0 ? std::min(s.bottom, height) : height;
    s.top = s.votes > 0 ? std::max(s.top, height) : height;
    s.votes += v.votes;
    s.near_votes += v.near_votes;
    s.sum_x += v.votes * v.x;
    s.sum_y += v.votes * v.y;
    if (height > kLowFrom && height < kLowTo) s.low += v.votes;
    if (height > kHighFrom) s.high += v.votes;
  }

  float gate_m_;
  FloorCell floor_;
  float height_sum_ = 0;
  bool is_upright_ = false;
  UprightCell upright_;
  std::array<Standing, kKinds> standing_;
};

}  // namespace

const Standing& UprightCell::of(Kind kind) const {
  static const Standing kNothing;
  for (const Standing* s = first; s != last; ++s) {
    if (s->kind == kind) return *s;
  }
  return kNothing;
}

float UprightCell::ofThingsBesidePosts() const {
  return of(Kind::building).votes + of(Kind::fence).votes + of(Kind::vegetation).votes +
         of(Kind::vehicle).votes;
}

bool UprightCell::holds(Kind kind, double min_share) const {
  float total = 0;
  for (const Standing* s = first; s != last; ++s) total += s->votes;
  const float votes = of(kind).votes;
  return votes >= kMinVotes && votes >= min_share * total;
}

PlanSample PlanCells::middleOf(std::size_t i) const {
  constexpr auto kSide = static_cast<float>(kPlanCell_m);
  const CellIndex::Cell c = cell(i);
  return {(static_cast<float>(c.x) + 0.5f) * kSide, (static_cast<float>(c.y) + 0.5f) * kSide,
          floor[i].height};
}

PlanCells sortIntoCells(const PlanVoxels& voxels, const HeightLattice& ground,
                        const GroundRule& rule) {
  constexpr std::size_t kAhead = 16;  // voxels of a cell lie far apart in memory
  PlanCells cells;
  const Grouped groups = groupByCell(voxels, cells.index);
  CellSorter sorter(rule);
  std::vector<std::size_t> first_standing;
  for (std::size_t c = 0; c < cells.index.size(); ++c) {
    const CellIndex::Cell cell = cells.cell(c);
    sorter.start(ground.heightAt(static_cast<float>((cell.x + 0.5) * kPlanCell_m),
                                 static_cast<float>((cell.y + 0.5) * kPlanCell_m)));
    for (std::size_t k = groups.starts[c]; k < groups.starts[c + 1]; ++k) {
      if (k + kAhead < groups.order.size()) __builtin_prefetch(&voxels[groups.order[k + kAhead]]);
      sorter.add(voxels[groups.order[k]]);
    }
    const std::size_t before = cells.standing.size();
    sorter.finish(cells);
    if (cells.upright_of[c] >= 0) first_standing.push_back(before);
  }
  first_standing.push_back(cells.standing.size());
  for (std::size_t u = 0; u < cells.upright.size(); ++u) {
    cells.upright[u].first = cells.standing.data() + first_standing[u];
    cells.upright[u].last = cells.standing.data() + first_standing[u + 1];
  }
  return cells;
}

ValueGrid::ValueGrid(const PlanCells& cells, const std::function<float(const UprightCell&)>& value)
    : cells_(&cells), values_(cells.size(), 0.f) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (const UprightCell* cell = cells.uprightOf(i)) values_[i] = value(*cell);
  }
}

ValueGrid ValueGrid::boxSum(int reach) const {
  ValueGrid sums = *this;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (values_[i] <= 0) continue;
    float& sum = sums.values_[i] = 0;
    cells_->index.forAround(i, reach, [&](std::int32_t j) { sum += values_[j]; });
  }
  return sums;
}

float ValueGrid::at(CellIndex::Cell cell) const {
  const std::int32_t i = cells_->index.find(cell.x, cell.y);
  return i < 0 ? 0.f : values_[static_cast<std::size_t>(i)];
}

bool ValueGrid::isMaximum(std::size_t i, int reach) const {
  const CellIndex::Cell c = cells_->cell(i);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const float other = at({c.x + dx, c.y + dy});
      const bool before = dy < 0 || (dy == 0 && dx < 0);
      if (other > values_[i] || (other == values_[i] && before)) return false;
    }
  }
  return true;
}

}  // namespace xview::graph
