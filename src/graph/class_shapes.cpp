// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/class_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "xview/types/cells.h"
#include "xview/types/median.h"
#include "xview/types/parallel.h"

namespace xview::graph {
namespace {

using Cell = std::pair<std::int64_t, std::int64_t>;

constexpr double kColumn_m = 0.5, kGroundCell_m = 2;

Cell cellOf(double x, double y, double side_m) {
  return {static_cast<std::int64_t>(std::floor(x / side_m)),
          static_cast<std::int64_t>(std::floor(y / side_m))};
}

template <class Take>
void forEachPoint(const std::vector<LabelledCloud>& clouds, Take&& take) {
  for (const LabelledCloud& cloud : clouds) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d p = cloud.position(i);
      if (p.allFinite()) take(p, cloud.points[i].label);
    }
  }
}

/// Height of the ground: what lies lowest, no steeper than a steep street, so that walls, cars and
/// roofs stand on it.
class Ground {
 public:
  explicit Ground(const std::vector<LabelledCloud>& clouds) {
    std::map<Cell, std::vector<float>> heights;
    forEachPoint(clouds, [&](const Eigen::Vector3d& p, std::uint32_t) {
      heights[cellOf(p.x(), p.y(), kGroundCell_m)].push_back(static_cast<float>(p.z()));
    });
    for (auto& [cell, z] : heights) {
      lowest_[cell] = quantileOf(z, 0.05);  // what is below may be noise
    }
  }

  double at(double x, double y) const {
    constexpr int kReach = 3;
    constexpr double kSteepest = 0.3;
    const Cell here = cellOf(x, y, kGroundCell_m);
    double height = std::numeric_limits<double>::infinity();
    for (int dy = -kReach; dy <= kReach; ++dy) {
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const auto found = lowest_.find({here.first + dx, here.second + dy});
        if (found == lowest_.end()) continue;
        height = std::min(height, found->second + kSteepest * kGroundCell_m * std::hypot(dx, dy));
      }
    }
    return height;
  }

 private:
  std::map<Cell, double> lowest_;
};

/// Most points of a class above one cell, heights above the ground [m]. The outermost may be of
/// another class, and a column of one or two points says nothing.
struct Column {
  double low = 0, high = 0;
  bool isFlat() const { return high - low < 0.35 && std::abs(low) < 0.5; }
};
using Columns = std::map<Cell, Column>;

std::map<std::uint32_t, Columns> columnsOf(const std::vector<LabelledCloud>& clouds) {
  constexpr std::size_t kFewestPoints = 3;
  const Ground ground(clouds);
  std::map<std::pair<std::uint32_t, Cell>, std::vector<double>> heights;
  forEachPoint(clouds, [&](const Eigen::Vector3d& p, std::uint32_t label) {
    heights[{label, cellOf(p.x(), p.y(), kColumn_m)}].push_back(p.z());
  });
  std::map<std::uint32_t, Columns> classes;
  for (auto& [key, z] : heights) {
    if (z.size() < kFewestPoints) continue;
    const auto& [label, cell] = key;
    const double floor = ground.at((static_cast<double>(cell.first) + 0.5) * kColumn_m,
                                   (static_cast<double>(cell.second) + 0.5) * kColumn_m);
    classes[label][cell] = {quantileOf(z, 0.1) - floor, quantileOf(z, 0.9) - floor};
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
  for (const auto& [cell, column] : columns)
    index.findOrAdd(static_cast<std::int32_t>(cell.first), static_cast<std::int32_t>(cell.second));
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
constexpr double kLongestThing_m = 6.5;

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

std::pair<Role, Kind> shapeOf(const Columns& columns) {
  const std::vector<Piece> pieces = piecesOf(columns);
  std::size_t long_ones = 0;
  for (const Piece& piece : pieces)
    long_ones += piece.length_m > kLongestThing_m ? piece.columns : 0;
  return 2 * long_ones >= columns.size() ? runningOn(columns) : standingAlone(pieces);
}

/// Which ground is which cannot be told, nor need it be as long as they differ: by area.
std::map<std::uint32_t, Kind> groundKinds(const std::map<std::uint32_t, Columns>& classes) {
  std::vector<std::pair<std::size_t, std::uint32_t>> by_area;
  for (const auto& [label, columns] : classes) {
    if (isGround(columns)) by_area.emplace_back(columns.size(), label);
  }
  std::sort(by_area.rbegin(), by_area.rend());
  constexpr Kind kKinds[] = {Kind::road, Kind::terrain, Kind::sidewalk, Kind::lane_marking};
  std::map<std::uint32_t, Kind> kinds;
  for (std::size_t i = 0; i < by_area.size(); ++i)
    kinds[by_area[i].second] = kKinds[std::min<std::size_t>(i, 3)];
  return kinds;
}

/// The same frames under other classes.
class Reclassified final : public ForwardingSource {
 public:
  Reclassified(std::unique_ptr<FrameSource> source, LabelSet labels)
      : ForwardingSource(*source), source_(std::move(source)), labels_(std::move(labels)) {}

  const LabelSet& labels() const override { return labels_; }

 private:
  std::unique_ptr<FrameSource> source_;
  LabelSet labels_;
};

std::vector<LabelledCloud> cloudsOver(const FrameSource& source, const LiftOptions& options,
                                      int threads) {
  constexpr std::size_t kFrames = 60;
  constexpr double kVoxel_m = 0.25;
  std::vector<LabelledCloud> clouds(std::min(kFrames, source.size()));
  parallelFor(clouds.size(), threads, [&](std::size_t i) {
    const Frame frame = source.read(i * source.size() / clouds.size());
    clouds[i] = thinByVoxel(lift(frame, source.labels(), options), kVoxel_m);
  });
  return clouds;
}

}  // namespace

LabelSet rolesByShape(const LabelSet& unnamed, const std::vector<LabelledCloud>& clouds) {
  constexpr std::size_t kFewestColumns = 4;  // 1 m² of a class in the whole recording
  std::map<std::uint32_t, Columns> classes = columnsOf(clouds);
  for (auto entry = classes.begin(); entry != classes.end();) {
    const bool tells =
        entry->second.size() >= kFewestColumns && unnamed.role(entry->first) != Role::ignored;
    entry = tells ? std::next(entry) : classes.erase(entry);
  }
  const std::map<std::uint32_t, Kind> ground = groundKinds(classes);
  if (ground.empty()) return unnamed;
  LabelSet result = unnamed;
  for (const auto& [label, columns] : classes) {
    ClassInfo info = *unnamed.find(label);
    const auto flat = ground.find(label);
    std::tie(info.role, info.kind) =
        flat != ground.end() ? std::pair(Role::surface, flat->second) : shapeOf(columns);
    result.add(info);
  }
  return result;
}

std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const LiftOptions& options, int threads) {
  if (!source->labels().isGeneric()) return source;
  LabelSet labels = rolesByShape(source->labels(), cloudsOver(*source, options, threads));
  return std::make_unique<Reclassified>(std::move(source), std::move(labels));
}

}  // namespace xview::graph
