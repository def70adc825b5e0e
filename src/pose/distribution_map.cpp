// SPDX-License-Identifier: BSD-3-Clause
#include "pose/distribution_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>

#include "distribution_cells.h"
#include "pose/refine.h"

namespace xview::pose {
namespace {

constexpr std::uint32_t kFirstOtherGroup = static_cast<std::uint32_t>(Kind::none) + 1;
/// Variance of the common error of the points of one view of a surface over the variance of their
/// mean.
constexpr float kCommonNoise = 4;
/// Of what cells of ground tell within their surface: mostly how far it was seen.
constexpr float kWithinGround = 0.1f;
constexpr int kWidest = 3;    ///< cells around it that a cell of a sparse map represents
constexpr int kTileBits = 5;  ///< width of a tile in cells, as a power of two

/// The poses that a map was seen from, on a grid, to ask which of them saw a place best.
class Viewpoints {
 public:
  explicit Viewpoints(const std::vector<Eigen::Isometry3d>& T_map_sensor) {
    for (const Eigen::Isometry3d& T : T_map_sensor) {
      if (T.matrix().allFinite()) grid_[squareOf(T.translation())].push_back(T);
    }
  }

  /// Unit vector from p to the nearest pose that has p in view; zero if there is none within some
  /// 50 m.
  Eigen::Vector3f directionFrom(const Eigen::Vector3d& p) const {
    const auto [x, y] = squareOf(p);
    const Eigen::Isometry3d* nearest = nullptr;
    double nearest_squared = INFINITY;
    for (std::int64_t dy = -kSquaresAround; dy <= kSquaresAround; ++dy) {
      for (std::int64_t dx = -kSquaresAround; dx <= kSquaresAround; ++dx) {
        const auto square = grid_.find({x + dx, y + dy});
        if (square == grid_.end()) continue;
        for (const Eigen::Isometry3d& T : square->second) {
          const double squared = (p - T.translation()).squaredNorm();
          if (squared >= nearest_squared || !hasInView(T, p)) continue;
          nearest_squared = squared;
          nearest = &T;
        }
      }
    }
    if (!nearest || nearest_squared == 0) return Eigen::Vector3f::Zero();
    return ((nearest->translation() - p) / std::sqrt(nearest_squared)).cast<float>();
  }

 private:
  static constexpr double kSquare_m = 25;
  static constexpr std::int64_t kSquaresAround = 2;
  using Square = std::pair<std::int64_t, std::int64_t>;

  static Square squareOf(const Eigen::Vector3d& p) {
    return {static_cast<std::int64_t>(std::floor(p.x() / kSquare_m)),
            static_cast<std::int64_t>(std::floor(p.y() / kSquare_m))};
  }

  /// Cameras look along their z axis; where it points up it is that of a LiDAR, which sees all
  /// around.
  static bool hasInView(const Eigen::Isometry3d& T_map_sensor, const Eigen::Vector3d& p) {
    constexpr double kUp = 0.7;
    constexpr double kHalfView = 0.64;  // cosine of 50 degrees
    const Eigen::Vector3d axis = T_map_sensor.linear().col(2);
    const Eigen::Vector3d ray = p - T_map_sensor.translation();
    return axis.z() > kUp || axis.dot(ray) > kHalfView * ray.norm();
  }

  std::map<Square, std::vector<Eigen::Isometry3d>> grid_;
};

}  // namespace

std::uint32_t matchingGroup(const LabelSet& labels, std::uint32_t label) {
  const Role role = labels.role(label);
  if (role == Role::ignored || role == Role::dynamic) return kNoGroup;
  const Kind kind = labels.kind(label);
  if (kind == Kind::lane_marking) return static_cast<std::uint32_t>(Kind::road);
  return tellsShape(kind) ? static_cast<std::uint32_t>(kind) : kFirstOtherGroup + label;
}

Kind kindOfGroup(std::uint32_t group) {
  return group < kFirstOtherGroup ? static_cast<Kind>(group) : Kind::none;
}

namespace {

using CloudPoints = pcl::PointCloud<Point>;

/// The points [first, last) of a cloud.
struct Run {
  std::uint32_t first, last;
};

Run allOf(const CloudPoints& points) { return {0, static_cast<std::uint32_t>(points.size())}; }

/// Calls visit(position, cell, index) for the points that take part.
template <class Visit>
void forPoints(const CloudPoints& points, const Run& run, const LabelSet& labels, float side,
               Visit&& visit) {
  std::uint32_t label = 0, group = matchingGroup(labels, 0);
  for (std::uint32_t i = run.first; i < run.last; ++i) {
    const Point& point = points[i];
    if (point.label != label) {
      label = point.label;
      group = matchingGroup(labels, label);
    }
    const Eigen::Vector3f p = point.getVector3fMap();
    if (group != kNoGroup && p.allFinite()) visit(p, cellOf(p, group, side), i);
  }
}

/// Fewer than half of the points lie in cells that make a distribution.
bool isSparse(const std::vector<Cell>& cells) {
  std::size_t all = 0, taking_part = 0;
  for (const Cell& cell : cells) {
    all += cell.points;
    if (cell.points >= kFewestPoints) taking_part += cell.points;
  }
  return 2 * taking_part < all;
}

/// Measures the noise of points that come in parts.
class NoiseSample {
 public:
  NoiseSample(std::size_t points, const LabelSet& labels, double cell_m)
      : labels_(labels),
        cell_m_(cell_m),
        stride_(static_cast<std::int32_t>(1 + points / kSampledPoints)) {}
  void add(const CloudPoints& points) {
    forPoints(points, allOf(points), labels_, static_cast<float>(cell_m_),
              [&](const Eigen::Vector3f& p, const CellKey& cell, std::uint32_t) {
                if ((cell.x + 7 * cell.y) % stride_ == 0) cellIn(cells_, cell).add(p);
              });
  }
  SurfaceNoise noise() const {
    return {cell_m_, medianThickness(cells_.entries()), isSparse(cells_.entries())};
  }

 private:
  static constexpr std::size_t kSampledPoints = 100000;
  const LabelSet& labels_;
  const double cell_m_;
  const std::int32_t stride_;
  Cells cells_;
};

}  // namespace

SurfaceNoise measureNoise(const LabelledCloud& map, const LabelSet& labels,
                          const RefineOptions& options) {
  NoiseSample sample(map.size(), labels, options.cell_m);
  sample.add(map.points);
  return sample.noise();
}

class DistributionMap::Tiles {
 public:
  Tiles(const MapPoints& map, const RefineOptions& options)
      : map_(map.cloud),
        stored_(map.stored),
        labels_(map.labels),
        views_(map.viewpoints),
        side_(static_cast<float>(options.cell_m)) {
    sortIntoTiles();
    if (stored_) addStoredTiles();
    const bool is_known = map.noise && map.noise->cell_m == options.cell_m;
    const SurfaceNoise noise = is_known ? *map.noise : noiseOfAll(options.cell_m);
    noise_m_ = kCommonNoise * static_cast<float>(noise.thickness_m);
    is_sparse_ = noise.is_sparse;
    const double roughness_m = options.model.roughness_m;
    variance_ = static_cast<float>(roughness_m * roughness_m) + noise_m_ * noise_m_;
  }

  const Eigen::Vector3d& origin() const { return map_.origin; }
  double noise_m() const { return noise_m_; }
  std::size_t size() const {
    std::size_t sum = 0;
    for (const TileEntry& entry : tiles_.entries()) sum += tableOf(*entry.tile).size();
    return sum;
  }

  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate_m,
                              Nearest& last) const {
    constexpr float kRounding_m = 1e-3f;  // by which a mean may lie outside of its cell
    const CellKey own = cellOf(p, group, side_);
    if (tells(last, p, own, gate_m)) return last.is;
    const TileKey own_tile = tileOf(own);
    const TileTable* own_table = tableAt(own_tile);
    const Eigen::Vector3f corner = side_ * Eigen::Vector3f(own.x, own.y, own.z);
    const auto squaredWay = [&](int axis, std::int32_t step) {
      if (step == 0) return 0.0f;
      const float inside = p[axis] - corner[axis];
      const float way = std::max(0.0f, (step < 0 ? inside : side_ - inside) - kRounding_m);
      return way * way;
    };
    const Distribution* best = nullptr;
    float best_squared = gate_m * gate_m, next_squared = best_squared;
    const auto look = [&](std::int32_t dx, std::int32_t dy, std::int32_t dz) {
      const CellKey key{own.x + dx, own.y + dy, own.z + dz, group};
      const TileKey tile = tileOf(key);
      const TileTable* table = tile == own_tile ? own_table : tableAt(tile);
      const Distribution* d = table ? table->find(key) : nullptr;
      if (!d) return;
      const float squared = (d->mean - p).squaredNorm();
      if (squared >= best_squared) {
        next_squared = std::min(next_squared, squared);
        return;
      }
      if (best) next_squared = std::min(next_squared, best_squared);
      best_squared = squared;
      best = d;
    };
    const auto isTooFar = [&](float squared) {
      if (squared < best_squared) return false;
      next_squared = std::min(next_squared, squared);
      return true;
    };
    // The own cell mostly has it; then few of the others can have a nearer one.
    look(0, 0, 0);
    for (std::int32_t dz = -1; dz <= 1; ++dz) {
      const float z = squaredWay(2, dz);
      if (isTooFar(z)) continue;
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        const float zy = z + squaredWay(1, dy);
        if (isTooFar(zy)) continue;
        for (std::int32_t dx = -1; dx <= 1; ++dx) {
          const bool is_own = dx == 0 && dy == 0 && dz == 0;
          if (!is_own && !isTooFar(zy + squaredWay(0, dx))) look(dx, dy, dz);
        }
      }
    }
    last = {best, p, std::sqrt(next_squared)};
    return best;
  }

  template <class Visit>
  void forAround(const Eigen::Vector3d& centre, double radius_m, const Visit& visit) const {
    const Eigen::Vector3f p = (centre - map_.origin).cast<float>();
    const Eigen::Vector3f reach = Eigen::Vector3f::Constant(static_cast<float>(radius_m));
    const TileKey low = tileOf(cellOf(p - reach, kNoGroup, side_)),
                  high = tileOf(cellOf(p + reach, kNoGroup, side_));
    for (TileKey key = low; key.y <= high.y; ++key.y) {
      for (key.x = low.x; key.x <= high.x; ++key.x) {
        if (const TileTable* table = tableAt(key)) table->forAll(visit);
      }
    }
  }

  bool holdsAnything(const Eigen::Vector3f& p) const {
    const CellKey own = cellOf(p, kNoGroup, side_);
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dx = -1; dx <= 1; ++dx) {
        CellKey key{own.x + dx, own.y + dy, 0, kNoGroup};
        const TileTable* table = tableAt(tileOf(key));
        if (!table) continue;
        for (key.z = own.z - 1; key.z <= own.z + 1; ++key.z) {
          if (table->holdsAnything(key)) return true;
        }
      }
    }
    return false;
  }

 private:
  /// Whether the nearest one is that of the last question for sure: the same cells are asked, and
  /// the point moved less than another one would have to come nearer. Means of widened cells lie
  /// anywhere.
  bool tells(const Nearest& last, const Eigen::Vector3f& p, const CellKey& own,
             float gate_m) const {
    constexpr float kRounding_m = 1e-4f;
    const float moved_m = (p - last.from).norm() + kRounding_m;
    if (is_sparse_ || !(moved_m < last.others_m)) return false;
    if (!(cellOf(last.from, own.group, side_) == own)) return false;
    const float others_m = last.others_m - moved_m;
    if (!last.is) return others_m >= gate_m;
    const float distance_m = (last.is->mean - p).norm() + kRounding_m;
    return distance_m < others_m && distance_m < gate_m;
  }

  /// A column of the map, wide enough in cells that none lies in two.
  using TileKey = PlaneCell;
  struct Tile {
    explicit Tile(const TileKey& tile) : key(tile) {}
    ~Tile() { delete table.load(); }
    const TileKey key;
    std::vector<Run> runs;
    std::vector<PlaneCell> columns;  ///< of the stored cloud that may have points in the tile
    mutable std::atomic<const TileTable*> table{nullptr};  ///< null: not made yet
  };
  struct TileEntry {
    TileKey key;
    std::unique_ptr<Tile> tile;
  };

  static TileKey tileOf(const CellKey& cell) { return {cell.x >> kTileBits, cell.y >> kTileBits}; }

  Tile& tileFor(const TileKey& key) {
    return *tiles_[tiles_.numberOf(key, [&] {
              return TileEntry{key, std::make_unique<Tile>(key)};
            })].tile;
  }

  void sortIntoTiles() {
    Tile* tile = nullptr;  // of the point before
    forPoints(map_.points, allOf(map_.points), labels_, side_,
              [&](const Eigen::Vector3f&, const CellKey& cell, std::uint32_t i) {
                const TileKey key = tileOf(cell);
                if (!tile || !(tile->key == key)) tile = &tileFor(key);
                if (tile->runs.empty() || tile->runs.back().last != i)
                  tile->runs.push_back({i, i + 1});
                else
                  tile->runs.back().last = i + 1;
              });
  }

  void addStoredTiles() {
    constexpr float kRounding_m = 0.05F;  // of coordinates in single precision
    constexpr auto kSide_m = static_cast<float>(StoredCloud::kColumn_m);
    for (const PlaneCell& column : stored_->columns()) {
      const Eigen::Vector3f corner(kSide_m * static_cast<float>(column.x),
                                   kSide_m * static_cast<float>(column.y), 0);
      const TileKey low = tileOf(cellOf(corner.array() - kRounding_m, kNoGroup, side_)),
                    high = tileOf(cellOf(corner.array() + kSide_m + kRounding_m, kNoGroup, side_));
      for (TileKey key = low; key.y <= high.y; ++key.y) {
        for (key.x = low.x; key.x <= high.x; ++key.x) tileFor(key).columns.push_back(column);
      }
    }
  }

  SurfaceNoise noiseOfAll(double cell_m) const {
    NoiseSample sample(map_.size() + (stored_ ? stored_->size() : 0), labels_, cell_m);
    sample.add(map_.points);
    if (stored_) {
      for (const PlaneCell& column : stored_->columns())
        sample.add(stored_->pointsOf(column)->points);
    }
    return sample.noise();
  }

  void addPoints(const Tile& tile, Cells& cells) const {
    const auto add = [&](const Eigen::Vector3f& p, const CellKey& cell, std::uint32_t) {
      if (tileOf(cell) == tile.key) cellIn(cells, cell).add(p);
    };
    for (const Run& run : tile.runs) forPoints(map_.points, run, labels_, side_, add);
    for (const PlaneCell& column : tile.columns) {
      const std::shared_ptr<const LabelledCloud> stored = stored_->pointsOf(column);
      forPoints(stored->points, allOf(stored->points), labels_, side_, add);
    }
  }

  TileTable makeTable(const Tile& tile) const {
    Cells cells, around;
    addPoints(tile, cells);
    if (is_sparse_) {
      for (int i = 0; i < 9; ++i) {
        const Tile* other = tileAt({tile.key.x + i % 3 - 1, tile.key.y + i / 3 - 1});
        if (other) addPoints(*other, around);
      }
    }
    for (Cell& cell : cells.entries()) {
      float side = side_;
      if (is_sparse_ && cell.points < kFewestPoints) side = widen(around, cell);
      Distribution& d = cell.distribution;
      const float within = isGround(kindOfGroup(cell.key.group)) ? kWithinGround : 1;
      d.information = surplusInformation(cell.covariance(), side, variance_, within);
      d.view = views_.directionFrom(map_.origin + d.mean.cast<double>());
    }
    return TileTable(std::move(cells));
  }

  /// Gives a cell the points of the cells around it, as far as it takes to tell their shape.
  /// Returns the side of what it speaks for then.
  float widen(const Cells& all, Cell& cell) const {
    for (int reach = 1; reach <= kWidest; ++reach) {
      Cell wide{cell.key};
      for (int dz = -reach; dz <= reach; ++dz)
        for (int dy = -reach; dy <= reach; ++dy)
          for (int dx = -reach; dx <= reach; ++dx) {
            const CellKey& k = cell.key;
            const std::int32_t other = all.find({k.x + dx, k.y + dy, k.z + dz, k.group});
            if (other >= 0) wide.add(all[static_cast<std::size_t>(other)]);
          }
      if (!tellsShape(wide)) continue;
      wide.distribution.mean = laidOn(wide, cell.distribution.mean);
      cell = wide;
      return static_cast<float>(2 * reach + 1) * side_;
    }
    return side_;
  }

  const TileTable& tableOf(const Tile& tile) const {
    const TileTable* known = tile.table.load(std::memory_order_acquire);
    if (known) return *known;
    auto made = std::make_unique<const TileTable>(makeTable(tile));
    // If another thread was faster, its table is the same.
    if (!tile.table.compare_exchange_strong(known, made.get())) return *known;
    return *made.release();
  }

  const Tile* tileAt(const TileKey& key) const {
    const std::int32_t number = tiles_.find(key);
    return number < 0 ? nullptr : tiles_[static_cast<std::size_t>(number)].tile.get();
  }
  /// Null: no points.
  const TileTable* tableAt(const TileKey& key) const {
    const Tile* tile = tileAt(key);
    return tile ? &tableOf(*tile) : nullptr;
  }

  const LabelledCloud& map_;
  const StoredCloud* stored_;
  const LabelSet labels_;
  const Viewpoints views_;
  const float side_;        ///< of a cell [m]
  float noise_m_ = 0;       ///< by which looks at one surface err as a whole
  bool is_sparse_ = false;  ///< cells ask their neighbours
  float variance_ = 0;      ///< added to every distribution [m^2]
  CellTable<TileEntry> tiles_;
};

DistributionMap::DistributionMap(const MapPoints& map, const RefineOptions& options)
    : tiles_(std::make_unique<Tiles>(map, options)) {}

DistributionMap::DistributionMap(LabelledCloud&& map, const LabelSet& labels,
                                 const std::vector<Eigen::Isometry3d>& viewpoints,
                                 const RefineOptions& options)
    : kept_(std::make_unique<const LabelledCloud>(std::move(map))),
      tiles_(std::make_unique<Tiles>(MapPoints{*kept_, labels, viewpoints}, options)) {}

DistributionMap::~DistributionMap() = default;
DistributionMap::DistributionMap(DistributionMap&&) noexcept = default;

const Eigen::Vector3d& DistributionMap::origin() const { return tiles_->origin(); }
double DistributionMap::noise_m() const { return tiles_->noise_m(); }
std::size_t DistributionMap::size() const { return tiles_->size(); }

const Distribution* DistributionMap::nearest(const Eigen::Vector3f& p, std::uint32_t group,
                                             float gate_m) const {
  Nearest nothing;
  return tiles_->nearest(p, group, gate_m, nothing);
}

const Distribution* DistributionMap::nearest(const Eigen::Vector3f& p, std::uint32_t group,
                                             float gate_m, Nearest& last) const {
  return tiles_->nearest(p, group, gate_m, last);
}

void DistributionMap::forAround(
    const Eigen::Vector3d& centre, double radius_m,
    const std::function<void(const Distribution&, std::uint32_t)>& visit) const {
  tiles_->forAround(centre, radius_m, visit);
}

bool DistributionMap::holdsAnything(const Eigen::Vector3f& p) const {
  return tiles_->holdsAnything(p);
}

}  // namespace xview::pose
