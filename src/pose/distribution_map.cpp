// SPDX-License-Identifier: BSD-3-Clause
#include "xview/pose/distribution_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>

#include "xview/pose/refine.h"
#include "xview/types/cells.h"
#include "xview/types/median.h"

namespace xview::pose {
namespace {

constexpr std::uint32_t kFirstOtherGroup = static_cast<std::uint32_t>(Kind::none) + 1;
constexpr std::uint32_t kFewestPoints = 4;  ///< of a distribution
/// Looks at a surface err as a whole by more than what their mean spreads, by about so much.
constexpr float kCommonNoise = 4;
/// Of what cells of ground tell within their surface: mostly how far it was seen.
constexpr float kWithinGround = 0.1f;
constexpr int kWidest = 3;    ///< a cell of a sparse map speaks for so many cells around it
constexpr int kTileBits = 5;  ///< a tile is so many cells wide, as a power of two

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

/// A cell of a group; cells are counted from the origin of the map.
struct CellKey {
  std::int32_t x, y, z;
  std::uint32_t group;

  bool operator==(const CellKey& o) const {
    return x == o.x && y == o.y && z == o.z && group == o.group;
  }
  /// Cells in a row of eight along x lie next to one another in a hash table: neighbours share its
  /// cache lines.
  std::uint64_t hash() const {
    constexpr int kRowBits = 3;
    std::uint64_t h = static_cast<std::uint32_t>(x >> kRowBits) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(z) * 0x94D049BB133111EBull;
    h = (h ^ (h >> 30)) + group * 0xD1342543DE82EF95ull;
    h ^= h >> 32;
    return (h << kRowBits) | static_cast<std::uint64_t>(x & ((1 << kRowBits) - 1));
  }
};

CellKey cellOf(const Eigen::Vector3f& p, std::uint32_t group, float side) {
  return {floorToInt(p.x() / side), floorToInt(p.y() / side), floorToInt(p.z() / side), group};
}

/// A distribution; while points are still added, `information` is the sum of squares about the
/// mean.
struct Cell {
  CellKey key;
  Distribution distribution{};
  std::uint32_t points = 0;

  /// Welford's update keeps single precision good far from the origin.
  void add(const Eigen::Vector3f& p) {
    const Eigen::Vector3f before = p - distribution.mean;
    distribution.mean += before / static_cast<float>(++points);
    distribution.information += before * (p - distribution.mean).transpose();
  }
  void add(const Cell& other) {
    const auto n = static_cast<float>(points), m = static_cast<float>(other.points);
    const Eigen::Vector3f between = other.distribution.mean - distribution.mean;
    distribution.mean += m / (n + m) * between;
    distribution.information +=
        other.distribution.information + n * m / (n + m) * between * between.transpose();
    points += other.points;
  }
  Eigen::Matrix3f covariance() const {
    return distribution.information / static_cast<float>(points);
  }
};

using Cells = CellTable<Cell, std::vector<Cell>>;

Cell& cellIn(Cells& cells, const CellKey& key) {
  return cells[cells.numberOf(key, [&] { return Cell{key}; })];
}

/// The cells of a tile. Most that are asked for are empty: one bit per cell tells, with groups and
/// heights folded.
class TileTable {
 public:
  explicit TileTable(Cells cells) : cells_(std::move(cells)) {
    for (const Cell& cell : cells_.entries()) {
      if (cell.points < kFewestPoints) continue;
      const std::uint32_t bit = bitOf(cell.key);
      marks_[bit >> 6] |= std::uint64_t{1} << (bit & 63);
      const std::uint32_t place = bit & kPlaceMask;
      held_[place >> 6] |= std::uint64_t{1} << (place & 63);
    }
  }
  /// Of any group; heights that are 16 cells apart are taken for one.
  bool holdsAnything(const CellKey& key) const {
    const std::uint32_t place = bitOf(key) & kPlaceMask;
    return (held_[place >> 6] >> (place & 63)) & 1;
  }
  /// Null if there are too few points.
  const Distribution* find(const CellKey& key) const {
    const std::uint32_t bit = bitOf(key);
    if (!((marks_[bit >> 6] >> (bit & 63)) & 1)) return nullptr;
    const std::int32_t number = cells_.find(key);
    if (number < 0) return nullptr;
    const Cell& cell = cells_[static_cast<std::size_t>(number)];
    return cell.points >= kFewestPoints ? &cell.distribution : nullptr;
  }
  std::size_t size() const { return cells_.size(); }
  template <class Visit>
  void forAll(const Visit& visit) const {
    for (const Cell& cell : cells_.entries()) {
      if (cell.points >= kFewestPoints) visit(cell.distribution, cell.key.group);
    }
  }

 private:
  /// Neighbours have different bits, and so have most groups.
  static std::uint32_t bitOf(const CellKey& k) {
    return (static_cast<std::uint32_t>(k.x) & 31) | (static_cast<std::uint32_t>(k.y) & 31) << 5 |
           (static_cast<std::uint32_t>(k.z) & 15) << 10 | (k.group & 7) << 14;
  }

  static constexpr std::uint32_t kPlaceMask = (1u << 14) - 1;  ///< a bit but for its group

  Cells cells_;
  std::vector<std::uint64_t> marks_ = std::vector<std::uint64_t>((1u << 17) / 64, 0);
  std::vector<std::uint64_t> held_ = std::vector<std::uint64_t>((kPlaceMask + 1) / 64, 0);
};

/// Information of a distribution about a position, less that of a cell of this side filled evenly,
/// and so much of it within its surface.
Eigen::Matrix3f surplusInformation(const Eigen::Matrix3f& covariance, float side, float variance,
                                   float within) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(0.5f *
                                                            (covariance + covariance.transpose()));
  const float even = 1 / (side * side / 12 + variance);
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f) + variance;
  Eigen::Vector3f information = (spread.inverse() - even).max(0.f);
  information.tail<2>() *= within;
  return axes.eigenvectors() * information.asDiagonal() * axes.eigenvectors().transpose();
}

/// What the points of the cells around say of a cell that has few itself. One beam over a surface,
/// a level line, tells no more than its direction.
bool tellsShape(const Cell& cell) {
  constexpr std::uint32_t kEnough = 8;
  constexpr float kWidthOfLine = 0.3f, kLevel = 0.5f;
  if (cell.points < kEnough) return false;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;
  axes.computeDirect(cell.covariance());
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f).sqrt();
  return spread(1) > kWidthOfLine * spread(2) || std::abs(axes.eigenvectors()(2, 2)) > kLevel;
}

/// The mean of a cell, laid on the surface that the points around it form.
Eigen::Vector3f laidOn(const Cell& around, const Eigen::Vector3f& mean) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(around.covariance());
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f);
  const Eigen::Array3f own = spread / std::max(1e-9f, spread(2));
  const Eigen::Array3f away = axes.eigenvectors().transpose() * (mean - around.distribution.mean);
  return around.distribution.mean + axes.eigenvectors() * (own * away).matrix();
}

/// Median spread across the surfaces [m].
float medianThickness(const std::vector<Cell>& cells) {
  constexpr std::uint32_t kFewest = 8;
  std::vector<float> variances;
  for (const Cell& cell : cells) {
    if (cell.points < kFewest) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
    solver.computeDirect(cell.covariance(), Eigen::EigenvaluesOnly);
    variances.push_back(std::max(0.0F, solver.eigenvalues()[0]));
  }
  if (variances.empty()) return 0;
  return std::sqrt(medianOf(std::move(variances)));
}

}  // namespace

std::uint32_t matchingGroup(const LabelSet& labels, std::uint32_t label) {
  const Role role = labels.role(label);
  if (role == Role::ignored || role == Role::dynamic) return kNoGroup;
  const Kind kind = labels.kind(label);
  if (kind == Kind::lane_marking) return static_cast<std::uint32_t>(Kind::road);
  if (kind == Kind::other_object || kind == Kind::other_surface) return kFirstOtherGroup + label;
  return static_cast<std::uint32_t>(kind);
}

Kind kindOfGroup(std::uint32_t group) {
  return group < kFirstOtherGroup ? static_cast<Kind>(group) : Kind::none;
}

class DistributionMap::Tiles {
 public:
  Tiles(const LabelledCloud& map, const LabelSet& labels,
        const std::vector<Eigen::Isometry3d>& viewpoints, const RefineOptions& options)
      : map_(map), labels_(labels), views_(viewpoints), side_(static_cast<float>(options.cell_m)) {
    sortIntoTiles();
    noise_m_ = kCommonNoise * typicalThickness();
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

  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate_m) const {
    constexpr float kRounding_m = 1e-3f;  // by which a mean may lie outside of its cell
    const CellKey own = cellOf(p, group, side_);
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
    float best_squared = gate_m * gate_m;
    const auto look = [&](std::int32_t dx, std::int32_t dy, std::int32_t dz) {
      const CellKey key{own.x + dx, own.y + dy, own.z + dz, group};
      const TileKey tile = tileOf(key);
      const TileTable* table = tile == own_tile ? own_table : tableAt(tile);
      const Distribution* d = table ? table->find(key) : nullptr;
      if (!d) return;
      const float squared = (d->mean - p).squaredNorm();
      if (squared >= best_squared) return;
      best_squared = squared;
      best = d;
    };
    // The own cell mostly has it; then few of the others can have a nearer one.
    look(0, 0, 0);
    for (std::int32_t dz = -1; dz <= 1; ++dz) {
      const float z = squaredWay(2, dz);
      if (z >= best_squared) continue;
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        const float zy = z + squaredWay(1, dy);
        if (zy >= best_squared) continue;
        for (std::int32_t dx = -1; dx <= 1; ++dx) {
          const bool is_own = dx == 0 && dy == 0 && dz == 0;
          if (!is_own && zy + squaredWay(0, dx) < best_squared) look(dx, dy, dz);
        }
      }
    }
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
  /// A column of the map, so many cells wide that none lies in two.
  struct TileKey {
    std::int32_t x, y;
    bool operator==(const TileKey& o) const { return x == o.x && y == o.y; }
    std::uint64_t hash() const {
      std::uint64_t h = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15ull;
      h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(y) * 0xBF58476D1CE4E5B9ull;
      return h ^ (h >> 29);
    }
  };
  /// The points [first, last) of the cloud.
  struct Run {
    std::uint32_t first, last;
  };
  struct Tile {
    explicit Tile(const TileKey& tile) : key(tile) {}
    ~Tile() { delete table.load(); }
    const TileKey key;
    std::vector<Run> runs;
    mutable std::atomic<const TileTable*> table{nullptr};  ///< null: not made yet
  };
  struct TileEntry {
    TileKey key;
    std::unique_ptr<Tile> tile;
  };

  static TileKey tileOf(const CellKey& cell) { return {cell.x >> kTileBits, cell.y >> kTileBits}; }

  /// Calls visit(position, cell, index) for the points that take part.
  template <class Visit>
  void forPoints(const Run& run, Visit&& visit) const {
    std::uint32_t label = 0, group = matchingGroup(labels_, 0);
    for (std::uint32_t i = run.first; i < run.last; ++i) {
      const Point& point = map_.points[i];
      if (point.label != label) {
        label = point.label;
        group = matchingGroup(labels_, label);
      }
      const Eigen::Vector3f p = point.getVector3fMap();
      if (group != kNoGroup && p.allFinite()) visit(p, cellOf(p, group, side_), i);
    }
  }
  Run allPoints() const { return {0, static_cast<std::uint32_t>(map_.size())}; }

  void sortIntoTiles() {
    Tile* tile = nullptr;  // of the point before
    forPoints(allPoints(), [&](const Eigen::Vector3f&, const CellKey& cell, std::uint32_t i) {
      const TileKey key = tileOf(cell);
      if (!tile || !(tile->key == key)) {
        const std::size_t number = tiles_.numberOf(key, [&] {
          return TileEntry{key, std::make_unique<Tile>(key)};
        });
        tile = tiles_[number].tile.get();
      }
      if (tile->runs.empty() || tile->runs.back().last != i)
        tile->runs.push_back({i, i + 1});
      else
        tile->runs.back().last = i + 1;
    });
  }

  /// Fewer than half of the points lie in cells that make a distribution.
  static bool isSparse(const std::vector<Cell>& cells) {
    std::size_t all = 0, taking_part = 0;
    for (const Cell& cell : cells) {
      all += cell.points;
      if (cell.points >= kFewestPoints) taking_part += cell.points;
    }
    return 2 * taking_part < all;
  }

  /// How thick surfaces are in the map. It is the noise of what the map was made of, and that of a
  /// query will be alike. Of large maps some cells are asked, spread evenly.
  float typicalThickness() {
    constexpr std::size_t kSampledPoints = 100000;
    const auto stride = static_cast<std::int32_t>(1 + map_.size() / kSampledPoints);
    Cells sample;
    forPoints(allPoints(), [&](const Eigen::Vector3f& p, const CellKey& cell, std::uint32_t) {
      if ((cell.x + 7 * cell.y) % stride == 0) cellIn(sample, cell).add(p);
    });
    is_sparse_ = isSparse(sample.entries());
    return medianThickness(sample.entries());
  }

  void addPoints(const Tile& tile, Cells& cells) const {
    for (const Run& run : tile.runs)
      forPoints(run, [&](const Eigen::Vector3f& p, const CellKey& cell, std::uint32_t) {
        cellIn(cells, cell).add(p);
      });
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
  const LabelSet labels_;
  const Viewpoints views_;
  const float side_;        ///< of a cell [m]
  float noise_m_ = 0;       ///< by which looks at one surface err as a whole
  bool is_sparse_ = false;  ///< cells ask their neighbours
  float variance_ = 0;      ///< added to every distribution [m^2]
  CellTable<TileEntry, std::vector<TileEntry>> tiles_;
};

DistributionMap::DistributionMap(const LabelledCloud& map, const LabelSet& labels,
                                 const std::vector<Eigen::Isometry3d>& viewpoints,
                                 const RefineOptions& options)
    : tiles_(std::make_unique<Tiles>(map, labels, viewpoints, options)) {}

DistributionMap::DistributionMap(LabelledCloud&& map, const LabelSet& labels,
                                 const std::vector<Eigen::Isometry3d>& viewpoints,
                                 const RefineOptions& options)
    : kept_(std::make_unique<const LabelledCloud>(std::move(map))),
      tiles_(std::make_unique<Tiles>(*kept_, labels, viewpoints, options)) {}

DistributionMap::~DistributionMap() = default;
DistributionMap::DistributionMap(DistributionMap&&) noexcept = default;

const Eigen::Vector3d& DistributionMap::origin() const { return tiles_->origin(); }
double DistributionMap::noise_m() const { return tiles_->noise_m(); }
std::size_t DistributionMap::size() const { return tiles_->size(); }

const Distribution* DistributionMap::nearest(const Eigen::Vector3f& p, std::uint32_t group,
                                             float gate_m) const {
  return tiles_->nearest(p, group, gate_m);
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
