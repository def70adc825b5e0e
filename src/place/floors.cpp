// SPDX-License-Identifier: BSD-3-Clause
#include "place/floors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

namespace xview {
namespace {

// In metres of the world: people are as high in any place.
constexpr int kFlat = 5;                ///< side of a column over the height of its cells
constexpr int kKnee = 3, kBody = 15;    ///< cells above a floor where a person stands
constexpr std::size_t kThin = 2;        ///< cells of one surface, at most
constexpr double kLeastOfPlace = 0.15;  ///< width of the widest floor over that of the place
constexpr double kLeastOfWidest = 0.3;  ///< width of a floor over that of the widest
constexpr double kLeastWalls = 0.1;     ///< columns beside a floor with walls, over its own

}  // namespace

void HeightCounts::add(double z) {
  ++counts_[std::lround(std::floor(z / bin_))];
  ++size_;
}

int HeightCounts::at(long bin) const {
  const auto found = counts_.find(bin);
  return found == counts_.end() ? 0 : found->second;
}

std::vector<std::pair<int, double>> HeightCounts::ranked() const {
  std::vector<std::pair<int, double>> all;
  for (const auto& [bin, count] : counts_)
    all.emplace_back(at(bin - 1) + count + at(bin + 1), (static_cast<double>(bin) + 0.5) * bin_);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  return all;
}

double HeightCounts::emptiest(double low, double high) const {
  long least = std::lround(std::floor(low / bin_));
  for (long bin = least + 1; static_cast<double>(bin) * bin_ < high; ++bin) {
    if (at(bin) <= at(least)) least = bin;
  }
  return static_cast<double>(least) * bin_;
}

void FloorFinder::add(const Eigen::Vector3d& upright) {
  const Eigen::Vector3d flat(upright.x(), upright.y(), kFlat * upright.z());
  const ClassCell cell = cellOf(flat, kFlat * kFloorBin_m * per_metre_, 0);
  cells_.numberOf(cell, [&] { return Occupied{cell}; });
}

/// What a person may stand on: nothing above up to his height. A thin surface with a room below it
/// may be a ceiling, whose floor above was not seen.
std::vector<ClassCell> FloorFinder::standable(const std::vector<ClassCell>& sorted) const {
  std::vector<ClassCell> found;
  const auto isBelow = [](const ClassCell& a, const ClassCell& b, int most) {
    return a.x == b.x && a.y == b.y && b.z <= a.z + most;
  };
  for (std::size_t i = 0; i < sorted.size();) {
    std::size_t end = i + 1;  // of cells without a gap
    while (end < sorted.size() && isBelow(sorted[end - 1], sorted[end], 1)) ++end;
    const bool has_room = end == sorted.size() || !isBelow(sorted[end - 1], sorted[end], kBody);
    const bool is_first =
        i == 0 || sorted[i - 1].x != sorted[i].x || sorted[i - 1].y != sorted[i].y;
    const bool is_ceiling =
        end - i <= kThin && !is_first && !isBelow(sorted[i - 1], sorted[i], kBody);
    if (has_room && !is_ceiling) found.push_back(sorted[end - 1]);
    i = end;
  }
  return found;
}

std::vector<double> FloorFinder::heights() const {
  using Square = std::pair<int, int>;
  std::vector<ClassCell> cells;
  for (const Occupied& occupied : cells_.entries()) cells.push_back(occupied.key);
  std::sort(cells.begin(), cells.end(), [](const ClassCell& a, const ClassCell& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  CellTable<Occupied> free;
  for (const ClassCell& cell : standable(cells))
    free.numberOf(cell, [&] { return Occupied{cell}; });
  const auto isFree = [&](const ClassCell& cell, int x, int y) {
    for (int z = -1; z <= 1; ++z) {
      if (free.find({cell.x + x, cell.y + y, cell.z + z}) >= 0) return true;
    }
    return false;
  };
  /// As a part of two by two columns.
  const auto isWide = [&](const ClassCell& cell) {
    for (const int x : {-1, 1}) {
      for (const int y : {-1, 1}) {
        if (isFree(cell, x, 0) && isFree(cell, 0, y) && isFree(cell, x, y)) return true;
      }
    }
    return false;
  };
  const double height = kFloorBin_m * per_metre_;
  std::map<int, std::set<Square>> wide;
  HeightCounts counts(height);
  for (const Occupied& occupied : free.entries()) {
    const ClassCell& cell = occupied.key;
    if (!isWide(cell)) continue;
    counts.add((cell.z + 0.5) * height);
    wide[cell.z].insert({cell.x, cell.y});
  }
  /// Columns with something between two heights.
  const auto columnsIn = [&](int low, int high) {
    std::set<Square> columns;
    for (const ClassCell& cell : cells) {
      if (cell.z >= low && cell.z <= high) columns.insert({cell.x, cell.y});
    }
    return columns;
  };
  const auto isShare = [](std::size_t part, double share, std::size_t of) {
    return static_cast<double>(part) >= share * static_cast<double>(of);
  };
  struct Floor {
    double z;
    std::size_t squares;
    std::set<Square> columns;  ///< of its storey, beside its squares
  };
  constexpr int kAny = std::numeric_limits<int>::max();
  const std::size_t width = columnsIn(-kAny, kAny).size();
  std::vector<Floor> floors;
  for (const auto& ranked : counts.ranked()) {
    const double z = ranked.second;
    const auto isNear = [&](const Floor& floor) {
      return std::abs(floor.z - z) < kLowestStorey_m * per_metre_;
    };
    if (std::any_of(floors.begin(), floors.end(), isNear)) continue;
    const int at = floorToInt(z / height);
    std::set<Square> squares;
    for (int i = at - 1; i <= at + 1; ++i) squares.insert(wide[i].begin(), wide[i].end());
    if (floors.empty() ? !isShare(squares.size(), kLeastOfPlace, width)
                       : !isShare(squares.size(), kLeastOfWidest, floors[0].squares))
      break;
    const auto isAboveOrBelow = [&](const Floor& floor) {
      std::size_t shared = 0;
      for (const Square& square : squares) shared += floor.columns.count(square);
      return isShare(shared, kStackedShare, squares.size());
    };
    const auto isBeside = [&](const Square& column) {
      for (int i = 0; i < 9; ++i) {
        if (squares.count({column.first + i % 3 - 1, column.second + i / 3 - 1}) > 0) return true;
      }
      return false;
    };
    const auto besideIn = [&](int low, int high) {
      std::set<Square> beside;
      for (const Square& column : columnsIn(low, high)) {
        if (isBeside(column)) beside.insert(column);
      }
      return beside;
    };
    if ((floors.empty() || std::any_of(floors.begin(), floors.end(), isAboveOrBelow)) &&
        isShare(besideIn(at + kKnee, at + kBody).size(), kLeastWalls, squares.size()))
      floors.push_back({z, squares.size(), besideIn(at, at + kBody)});
  }
  std::vector<double> heights;
  for (const Floor& floor : floors) heights.push_back(floor.z);
  std::sort(heights.begin(), heights.end());
  return heights;
}

}  // namespace xview
