// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "base/cells.h"

namespace xview {

/// From one storey to the next, at least, in metres of the world.
constexpr double kLowestStorey_m = 1.8;
/// Share of what is walked on, or of a floor, that lies above something of the same kind, at least.
constexpr double kStackedShare = 0.15;
constexpr double kFloorBin_m = 0.1;  ///< of heights of floors

/// How often each height occurs, by bin.
class HeightCounts {
 public:
  explicit HeightCounts(double bin) : bin_(bin) {}
  void add(double z);
  std::size_t size() const { return size_; }
  /// Heights around which most are first, with their numbers; of equal ones the lowest.
  std::vector<std::pair<int, double>> ranked() const;
  /// Where fewest are between two heights; of equal ones the highest.
  double emptiest(double low, double high) const;

 private:
  int at(long bin) const;

  double bin_;
  std::map<long, int> counts_;
  std::size_t size_ = 0;
};

/// Finds floors that lie above one another: wide surfaces with nothing over them up to the height
/// of a person, among walls. Ceilings and roofs have no walls on them, tables and shelves are
/// narrow.
class FloorFinder {
 public:
  /// `per_metre`: lengths of the points over metres of the world.
  explicit FloorFinder(double per_metre) : per_metre_(per_metre) {}
  void add(const Eigen::Vector3d& upright);
  /// From below; one or none if nothing lies above one another.
  std::vector<double> heights() const;

 private:
  struct Occupied {
    ClassCell key;  ///< wide and low
  };
  std::vector<ClassCell> standable(const std::vector<ClassCell>& sorted) const;

  double per_metre_;
  CellTable<Occupied> cells_;
};

}  // namespace xview
