// SPDX-License-Identifier: BSD-3-Clause
#include "graph/value_grid.h"

namespace xview {

ValueGrid::ValueGrid(const PlanCells& cells, const CellValue& value)
    : cells_(&cells), values_(cells.index.size(), 0.f) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (const UprightCell* cell = cells.uprightOf(i)) values_[i] = value(*cell);
  }
}

ValueGrid ValueGrid::boxSum(int reach) const {
  ValueGrid sums = *this;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (values_[i] > 0) sums.values_[i] = sumAround(cells_->index.cells()[i], reach);
  }
  return sums;
}

float ValueGrid::sumAround(CellIndex::Cell cell, int reach) const {
  float sum = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) sum += at(cell.x + dx, cell.y + dy);
  }
  return sum;
}

float ValueGrid::at(std::int32_t x, std::int32_t y) const {
  const std::int32_t i = cells_->index.find(x, y);
  return i < 0 ? 0.f : values_[static_cast<std::size_t>(i)];
}

bool ValueGrid::isMaximum(std::size_t i, int reach) const {
  const CellIndex::Cell c = cells_->index.cells()[i];
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const float other = at(c.x + dx, c.y + dy);
      const bool before = dy < 0 || (dy == 0 && dx < 0);
      if (other > values_[i] || (other == values_[i] && before)) return false;
    }
  }
  return true;
}

}  // namespace xview
