// SPDX-License-Identifier: BSD-3-Clause
#include "place/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "base/cells.h"
#include "base/median.h"
#include "place/ground_field.h"

namespace xview {
namespace {

using Cell = std::pair<std::int32_t, std::int32_t>;

constexpr float kColumn_m = 0.5F;

/// Most points of a class above one cell, heights above the ground [m]. The outermost may be of
/// another class, and a column of one or two points says nothing.
struct Column {
  double low = 0, high = 0;
  bool isFlat() const { return high - low < 0.35 && std::abs(low) < 0.5; }
};
using Columns = std::map<Cell, Column>;

/// Points of any class in a range of heights above one cell.
std::size_t countBetween(const std::vector<float>& sorted, float low, float high) {
  return static_cast<std::size_t>(std::upper_bound(sorted.begin(), sorted.end(), high) -
                                  std::lower_bound(sorted.begin(), sorted.end(), low));
}

std::map<std::uint32_t, Columns> columnsOf(const pcl::PointCloud<Point>& points) {
  constexpr std::size_t kFewestPoints = 3;
  constexpr float kAround_m = 0.25F;
  const GroundField ground(points);
  std::map<std::pair<std::uint32_t, Cell>, std::vector<float>> heights;
  std::map<Cell, std::vector<float>> of_all;
  for (const Point& p : points) {
    const Cell cell{floorToInt(p.x / kColumn_m), floorToInt(p.y / kColumn_m)};
    heights[{p.label, cell}].push_back(p.z);
    of_all[cell].push_back(p.z);
  }
  for (auto& [cell, z] : of_all) std::sort(z.begin(), z.end());
  std::map<std::uint32_t, Columns> classes;
  for (auto& [key, z] : heights) {
    if (z.size() < kFewestPoints) continue;
    const auto& [label, cell] = key;
    const float low = quantileOf(z, 0.1), high = quantileOf(z, 0.9);
    if (2 * z.size() < countBetween(of_all[cell], low - kAround_m, high + kAround_m)) continue;
    const float floor = ground.heightAt((static_cast<float>(cell.first) + 0.5F) * kColumn_m,
                                        (static_cast<float>(cell.second) + 0.5F) * kColumn_m);
    classes[label][cell] = {low - floor, high - floor};
  }
  return classes;
}

/// Columns that touch one another.
struct Piece {
  std::size_t columns = 0;
  double length_m = 0;  ///< longer side of its box
  double height_m = 0;  ///< of its top above the ground
};

std::vector<Piece> piecesOf(const Columns& columns) {
  CellIndex index;
  for (const auto& [cell, column] : columns) index.findOrAdd(cell.first, cell.second);
  std::vector<Piece> pieces;
  for (const auto& members : connectedCells(index, [](std::int32_t) { return true; })) {
    Piece piece{members.size()};
    Eigen::AlignedBox2i box;
    for (const std::int32_t member : members) {
      const auto [x, y] = index.cells()[member];
      piece.height_m = std::max(piece.height_m, columns.at({x, y}).high);
      box.extend(Eigen::Vector2i(x, y));
    }
    piece.length_m = kColumn_m * (box.sizes().maxCoeff() + 1);
    pieces.push_back(piece);
  }
  return pieces;
}

/// Median over the columns of what each piece is.
template <class Value>
double medianOver(const std::vector<Piece>& pieces, Value&& value) {
  std::vector<double> values;
  for (const Piece& piece : pieces) values.insert(values.end(), piece.columns, value(piece));
  return medianOf(std::move(values));
}

template <class Test>
double shareOf(const Columns& columns, Test&& test) {
  const auto count = std::count_if(columns.begin(), columns.end(),
                                   [&](const auto& entry) { return test(entry.second); });
  return static_cast<double>(count) / static_cast<double>(columns.size());
}

bool isGround(const Columns& columns) {
  return shareOf(columns, [](const Column& c) { return c.isFlat(); }) >= 0.75;
}

/// Pieces of a street's furniture and cars are shorter than this [m].
constexpr double kLongestObject_m = 6.5;

std::pair<Role, Kind> runningOn(const Columns& columns) {
  const auto reaching = [&](double height_m) {
    return shareOf(columns, [&](const Column& c) { return c.high > height_m; }) >= 0.5;
  };
  return {Role::surface, reaching(2.5)   ? Kind::building
                         : reaching(0.7) ? Kind::fence
                                         : Kind::vegetation};
}

std::pair<Role, Kind> standingAlone(const std::vector<Piece>& pieces) {
  const double length = medianOver(pieces, [](const Piece& p) { return p.length_m; });
  const double height = medianOver(pieces, [](const Piece& p) { return p.height_m; });
  if (length <= 2 && height >= 1.5) return {Role::object, Kind::pole};
  if (length >= 2.5 && height >= 1 && height <= 2.7) return {Role::dynamic, Kind::vehicle};
  if (length >= 2.5 && height >= 4) return {Role::object, Kind::vegetation};  // a tree
  return {Role::object, Kind::other_object};
}

std::pair<Role, Kind> shapeOf(const Columns& columns, const ClassInfo& info, bool has_names) {
  const std::vector<Piece> pieces = piecesOf(columns);
  std::size_t long_ones = 0;
  for (const Piece& piece : pieces)
    long_ones += piece.length_m > kLongestObject_m ? piece.columns : 0;
  if (2 * long_ones >= columns.size()) return runningOn(columns);
  return has_names ? std::pair(info.role, info.kind) : standingAlone(pieces);
}

/// Which ground is which cannot be told, nor need it be as long as they differ: by area.
std::map<std::uint32_t, Kind> groundKinds(const std::map<std::uint32_t, Columns>& classes,
                                          const LabelSet& labels) {
  std::vector<Kind> free{Kind::road, Kind::terrain, Kind::sidewalk, Kind::lane_marking};
  for (const auto& [id, info] : labels.classes()) {
    const auto taken = std::find(free.begin(), free.end(), info.kind);
    if (taken != free.end() && free.size() > 1) free.erase(taken);
  }
  std::vector<std::pair<std::size_t, std::uint32_t>> by_area;
  for (const auto& [label, columns] : classes) {
    if (isGround(columns)) by_area.emplace_back(columns.size(), label);
  }
  std::sort(by_area.rbegin(), by_area.rend());
  std::map<std::uint32_t, Kind> kinds;
  for (std::size_t i = 0; i < by_area.size(); ++i)
    kinds[by_area[i].second] = free[std::min(i, free.size() - 1)];
  return kinds;
}

bool hasGround(const LabelSet& labels) {
  const auto& classes = labels.classes();
  return std::any_of(classes.begin(), classes.end(),
                     [](const auto& entry) { return xview::isGround(entry.second.kind); });
}

/// What nothing more will be told of.
LabelSet withoutUnknown(LabelSet labels) {
  const std::map<std::uint32_t, ClassInfo> classes = labels.classes();
  for (auto [id, info] : classes) {
    info.unknown = false;
    labels.add(info);
  }
  return labels;
}

}  // namespace

LabelSet rolesByShape(const LabelSet& given, const LabelledCloud& cloud) {
  const LabelSet labels = withoutUnknown(given);
  constexpr std::size_t kFewestColumns = 4;  // 1 m² of a class in the whole recording
  pcl::PointCloud<Point> finite;
  std::copy_if(cloud.points.begin(), cloud.points.end(), std::back_inserter(finite.points),
               [](const Point& p) { return p.getVector3fMap().allFinite(); });
  std::map<std::uint32_t, Columns> classes = columnsOf(finite);
  for (auto entry = classes.begin(); entry != classes.end();) {
    const ClassInfo* info = given.find(entry->first);
    const bool may_tell = info && info->unknown && entry->second.size() >= kFewestColumns;
    entry = may_tell ? std::next(entry) : classes.erase(entry);
  }
  const std::map<std::uint32_t, Kind> ground = groundKinds(classes, labels);
  if (ground.empty() && !hasGround(labels)) return labels;
  LabelSet result = labels;
  for (const auto& [label, columns] : classes) {
    ClassInfo info = *labels.find(label);
    const auto flat = ground.find(label);
    std::tie(info.role, info.kind) = flat != ground.end()
                                         ? std::pair(Role::surface, flat->second)
                                         : shapeOf(columns, info, !labels.isGeneric());
    result.add(info);
  }
  return result;
}

}  // namespace xview
