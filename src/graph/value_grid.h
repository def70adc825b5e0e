// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "graph/plan_cells.h"

namespace xview {

using CellValue = std::function<float(const UprightCell&)>;

/// A value per cell of a view, 0 where nothing stands. The cells must outlive it.
class ValueGrid {
 public:
  ValueGrid(const PlanCells& cells, const CellValue& value);
  /// Sum over the square of half size `reach` around each cell with a value; 0 elsewhere.
  ValueGrid boxSum(int reach) const;
  /// Sum over the square of half size `reach` around any cell.
  float sumAround(CellIndex::Cell cell, int reach) const;
  float at(std::int32_t x, std::int32_t y) const;
  float operator[](std::size_t i) const { return values_[i]; }
  /// Largest within `reach` cells; of equal ones the first in (y, x) order.
  bool isMaximum(std::size_t i, int reach) const;

 private:
  const PlanCells* cells_;
  std::vector<float> values_;
};

}  // namespace xview
