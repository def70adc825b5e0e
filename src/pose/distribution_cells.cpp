// SPDX-License-Identifier: BSD-3-Clause
#include "distribution_cells.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>
#include <utility>

#include "xview/types/median.h"

namespace xview {
namespace {

constexpr std::uint32_t kFirstOtherGroup = static_cast<std::uint32_t>(Kind::none) + 1;
constexpr std::uint32_t kFewestPoints = 4;  ///< of a distribution
constexpr int kTileBits = 5;                ///< a tile is so many cells wide, as a power of two

/// Looks at a surface err as a whole by more than what their mean spreads, by about so much.
constexpr float kCommonNoise = 4;

/// Distributions in the making, with the sums of squares about their means.
class GrowingDistributions {
 public:
  void add(const CellKey& key, const Eigen::Vector3f& p) {
    Distribution& d = table_.findOrAdd(key);
    const auto index = static_cast<std::size_t>(&d - table_.distributions().data());
    if (squares_.size() <= index) squares_.resize(index + 1, Eigen::Matrix3f::Zero());
    // Welford's update keeps single precision good far from the origin.
    const Eigen::Vector3f before = p - d.mean;
    d.mean += before / static_cast<float>(++d.points);
    squares_[index] += before * (p - d.mean).transpose();
  }
  std::size_t size() const { return squares_.size(); }
  Eigen::Matrix3f covariance(std::size_t i) const {
    return squares_[i] / static_cast<float>(table_.distributions()[i].points);
  }
  DistributionTable& table() { return table_; }
  const Distribution& operator[](std::size_t i) const { return table_.distributions()[i]; }

 private:
  DistributionTable table_;
  std::vector<Eigen::Matrix3f> squares_;
};

/// Of what cells of ground tell within their surface: mostly how far it was seen.
constexpr float kWithinGround = 0.1f;

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

/// Median spread across the surfaces [m].
float medianThickness(const GrowingDistributions& sample) {
  constexpr std::uint32_t kFewest = 8;
  std::vector<float> variances;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (sample[i].points < kFewest) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
    solver.computeDirect(sample.covariance(i), Eigen::EigenvaluesOnly);
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

Kind kindOf(std::uint32_t group) {
  return group < kFirstOtherGroup ? static_cast<Kind>(group) : Kind::none;
}

DistributionCells::DistributionCells(const LabelledCloud& map, const LabelSet& labels,
                                     const std::vector<Eigen::Isometry3d>& viewpoints,
                                     const RefineOptions& options)
    : map_(map), labels_(labels), views_(viewpoints), side_(static_cast<float>(options.cell_m)) {
  sortIntoTiles();
  noise_ = kCommonNoise * typicalThickness();
  variance_ = static_cast<float>(options.roughness_m * options.roughness_m) + noise_ * noise_;
}

DistributionCells::~DistributionCells() = default;

/// Calls visit(position, cell, index) for the points that take part.
template <class Visit>
void DistributionCells::forPoints(const Run& run, Visit&& visit) const {
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

void DistributionCells::sortIntoTiles() {
  Tile* tile = nullptr;  // of the point before
  const auto put = [&](const Eigen::Vector3f&, const CellKey& key, std::uint32_t i) {
    const std::int32_t x = key.x >> kTileBits, y = key.y >> kTileBits;
    if (!tile || tile->x != x || tile->y != y) tile = &findOrAddTile(x, y);
    if (tile->runs.empty() || tile->runs.back().last != i)
      tile->runs.push_back({i, i + 1});
    else
      tile->runs.back().last = i + 1;
  };
  forPoints({0, static_cast<std::uint32_t>(map_.size())}, put);
}

/// How thick surfaces are in the map. It is the noise of what the map was made of, and that of a
/// query will be alike. Of large maps some cells are asked, spread evenly.
float DistributionCells::typicalThickness() const {
  constexpr std::size_t kSampledPoints = 100000;
  const auto stride = static_cast<std::int32_t>(1 + map_.size() / kSampledPoints);
  GrowingDistributions sample;
  const auto take = [&](const Eigen::Vector3f& p, const CellKey& key, std::uint32_t) {
    if ((key.x + 7 * key.y) % stride == 0) sample.add(key, p);
  };
  forPoints({0, static_cast<std::uint32_t>(map_.size())}, take);
  return medianThickness(sample);
}

/// Where a tile is, or where it would be put.
std::size_t DistributionCells::slotOf(std::int32_t x, std::int32_t y) const {
  const std::size_t mask = slots_.size() - 1;
  std::uint64_t h = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15ull;
  h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(y) * 0xBF58476D1CE4E5B9ull;
  std::size_t slot = (h ^ (h >> 29)) & mask;
  while (slots_[slot] >= 0 && (tiles_[slots_[slot]].x != x || tiles_[slots_[slot]].y != y))
    slot = (slot + 1) & mask;
  return slot;
}

DistributionCells::Tile& DistributionCells::findOrAddTile(std::int32_t x, std::int32_t y) {
  if (2 * tiles_.size() >= slots_.size()) {
    slots_.assign(2 * slots_.size(), -1);
    for (std::size_t i = 0; i < tiles_.size(); ++i)
      slots_[slotOf(tiles_[i].x, tiles_[i].y)] = static_cast<std::int32_t>(i);
  }
  std::int32_t& slot = slots_[slotOf(x, y)];
  if (slot < 0) {
    slot = static_cast<std::int32_t>(tiles_.size());
    tiles_.emplace_back(x, y);
  }
  return tiles_[slot];
}

DistributionTable DistributionCells::makeTable(const Tile& tile) const {
  GrowingDistributions growing;
  for (const Run& run : tile.runs)
    forPoints(run, [&](const Eigen::Vector3f& p, const CellKey& key, std::uint32_t) {
      growing.add(key, p);
    });
  for (std::size_t i = 0; i < growing.size(); ++i) {
    Distribution& d = growing.table().distributions()[i];
    const float within = isGround(kindOf(d.key.group)) ? kWithinGround : 1;
    d.information = surplusInformation(growing.covariance(i), side_, variance_, within);
    d.view = views_.directionFrom(map_.origin + d.mean.cast<double>());
  }
  growing.table().mark(kFewestPoints);
  return std::move(growing.table());
}

const DistributionTable& DistributionCells::tableOf(const Tile& tile) const {
  const DistributionTable* known = tile.table.load(std::memory_order_acquire);
  if (known) return *known;
  auto made = std::make_unique<const DistributionTable>(makeTable(tile));
  // If another thread was faster, its table is the same.
  if (!tile.table.compare_exchange_strong(known, made.get())) return *known;
  return *made.release();
}

const DistributionTable* DistributionCells::tableAt(std::int32_t x, std::int32_t y) const {
  const std::int32_t slot = slots_[slotOf(x, y)];
  return slot < 0 ? nullptr : &tableOf(tiles_[slot]);
}

const Distribution* DistributionCells::nearest(const Eigen::Vector3f& p, std::uint32_t group,
                                               float gate) const {
  constexpr float kRounding_m = 1e-3f;  // by which a mean may lie outside of its cell
  const CellKey own = cellOf(p, group, side_);
  const Eigen::Vector3f corner = side_ * Eigen::Vector3f(own.x, own.y, own.z);
  const auto squaredWay = [&](int axis, std::int32_t step) {
    if (step == 0) return 0.0f;
    const float inside = p[axis] - corner[axis];
    const float way = std::max(0.0f, (step < 0 ? inside : side_ - inside) - kRounding_m);
    return way * way;
  };
  const std::int32_t own_x = own.x >> kTileBits, own_y = own.y >> kTileBits;
  const DistributionTable* own_table = tableAt(own_x, own_y);
  const Distribution* best = nullptr;
  float best_squared = gate * gate;
  const auto look = [&](std::int32_t dx, std::int32_t dy, std::int32_t dz) {
    const CellKey key{own.x + dx, own.y + dy, own.z + dz, group};
    const std::int32_t x = key.x >> kTileBits, y = key.y >> kTileBits;
    const DistributionTable* table = x == own_x && y == own_y ? own_table : tableAt(x, y);
    const Distribution* d = table && table->mayBeMarked(key) ? table->find(key) : nullptr;
    if (!d || d->points < kFewestPoints) return;
    const float squared = (d->mean - p).squaredNorm();
    if (squared < best_squared) {
      best_squared = squared;
      best = d;
    }
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

std::size_t DistributionCells::size() const {
  std::size_t sum = 0;
  for (const Tile& tile : tiles_) sum += tableOf(tile).distributions().size();
  return sum;
}

}  // namespace xview
