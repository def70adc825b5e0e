// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "distribution_cells.h"
#include "viewpoints.h"
#include "xview/pose/refine.h"

namespace xview {
namespace {

constexpr std::uint32_t kFirstOtherGroup = static_cast<std::uint32_t>(Kind::none) + 1;
constexpr std::uint32_t kFewestPoints = 4;  ///< of a distribution

/// Cells in a row of so many lie next to one another in the hash table: neighbours share its cache
/// lines.
constexpr int kRowBits = 3;

std::uint64_t rowHash(const CellKey& k) {
  std::uint64_t h = static_cast<std::uint32_t>(k.x >> kRowBits) * 0x9E3779B97F4A7C15ull;
  h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(k.y) * 0xBF58476D1CE4E5B9ull;
  h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(k.z) * 0x94D049BB133111EBull;
  h = (h ^ (h >> 30)) + k.group * 0xD1342543DE82EF95ull;
  return h ^ (h >> 32);
}

std::uint64_t hashOf(const CellKey& k) {
  return (rowHash(k) << kRowBits) | static_cast<std::uint64_t>(k.x & ((1 << kRowBits) - 1));
}

std::uint32_t tagOf(std::uint64_t hash) { return static_cast<std::uint32_t>(hash >> 32); }

/// Information of a distribution about a position, less that of a cell of this side filled evenly.
Eigen::Matrix3f surplusInformation(const Eigen::Matrix3f& covariance, float side, float variance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(0.5f *
                                                            (covariance + covariance.transpose()));
  const float even = 1 / (side * side / 12 + variance);
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f) + variance;
  const Eigen::Vector3f information = (spread.inverse() - even).max(0.f);
  return axes.eigenvectors() * information.asDiagonal() * axes.eigenvectors().transpose();
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

std::size_t DistributionCells::slotOf(const CellKey& key) const {
  const std::size_t mask = slots_.size() - 1;
  const std::uint64_t h = hashOf(key);
  const std::uint32_t tag = tagOf(h);
  std::size_t slot = h & mask;
  while (slots_[slot].distribution >= 0 &&
         (slots_[slot].tag != tag || !(distributions_[slots_[slot].distribution].key == key))) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

Distribution& DistributionCells::findOrAdd(const Eigen::Vector3f& p, std::uint32_t group) {
  if (2 * distributions_.size() >= slots_.size()) {
    slots_.assign(2 * slots_.size(), {});
    for (std::size_t i = 0; i < distributions_.size(); ++i) {
      const CellKey& known = distributions_[i].key;
      slots_[slotOf(known)] = {static_cast<std::int32_t>(i), tagOf(hashOf(known))};
    }
  }
  const CellKey key = keyOf(p, group);
  Slot& slot = slots_[slotOf(key)];
  if (slot.distribution < 0) {
    slot = {static_cast<std::int32_t>(distributions_.size()), tagOf(hashOf(key))};
    distributions_.emplace_back();
    distributions_.back().key = key;
  }
  return distributions_[slot.distribution];
}

const Distribution* DistributionCells::nearest(const Eigen::Vector3f& p, std::uint32_t group,
                                               float gate) const {
  constexpr float kRounding_m = 1e-3f;  // by which a mean may lie outside of its cell
  const CellKey own = keyOf(p, group);
  const Eigen::Vector3f corner = side_ * Eigen::Vector3f(own.x, own.y, own.z);
  const auto squaredWay = [&](int axis, std::int32_t step) {
    if (step == 0) return 0.0f;
    const float inside = p[axis] - corner[axis];
    const float way = std::max(0.0f, (step < 0 ? inside : side_ - inside) - kRounding_m);
    return way * way;
  };
  const Distribution* best = nullptr;
  float best_squared = gate * gate;
  const auto look = [&](std::int32_t dx, std::int32_t dy, std::int32_t dz) {
    const std::int32_t i = slots_[slotOf({own.x + dx, own.y + dy, own.z + dz, group})].distribution;
    if (i < 0 || distributions_[i].points < kFewestPoints) return;
    const float squared = (distributions_[i].mean - p).squaredNorm();
    if (squared < best_squared) {
      best_squared = squared;
      best = &distributions_[i];
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

namespace {

/// Looks at a surface err as a whole by more than what their mean spreads, by about so much.
constexpr float kCommonNoise = 4;

/// How thick surfaces are in the map: the median spread across them [m]. It is the noise of what
/// the map was made of, and that of a query will be alike.
float typicalThickness(const std::vector<Distribution>& distributions,
                       const std::vector<Eigen::Matrix3f>& squares) {
  constexpr std::size_t kSamples = 4000;
  constexpr std::uint32_t kFewest = 8;
  const std::size_t step = 1 + squares.size() / kSamples;
  std::vector<float> variances;
  for (std::size_t i = 0; i < squares.size(); i += step) {
    if (distributions[i].points < kFewest) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
    solver.computeDirect(squares[i] / static_cast<float>(distributions[i].points),
                         Eigen::EigenvaluesOnly);
    variances.push_back(std::max(0.0F, solver.eigenvalues()[0]));
  }
  if (variances.empty()) return 0;
  const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
  std::nth_element(variances.begin(), middle, variances.end());
  return std::sqrt(*middle);
}

}  // namespace

DistributionMap::DistributionMap(const LabelledCloud& map, const LabelSet& labels,
                                 const std::vector<Eigen::Isometry3d>& viewpoints,
                                 const RefineOptions& options) {
  auto cells = std::make_unique<DistributionCells>(map.origin, options.cell_m);
  std::vector<Eigen::Matrix3f> squares;
  for (const pcl::PointXYZL& point : map.points) {
    const std::uint32_t group = matchingGroup(labels, point.label);
    const Eigen::Vector3f p = point.getVector3fMap();
    if (group == kNoGroup || !p.allFinite()) continue;
    Distribution& d = cells->findOrAdd(p, group);
    const auto index = static_cast<std::size_t>(&d - cells->distributions().data());
    if (squares.size() <= index) squares.resize(index + 1, Eigen::Matrix3f::Zero());
    // Welford's update keeps single precision good far from the origin.
    const Eigen::Vector3f before = p - d.mean;
    d.mean += before / static_cast<float>(++d.points);
    squares[index] += before * (p - d.mean).transpose();
  }
  const float common = kCommonNoise * typicalThickness(cells->distributions(), squares);
  const auto variance =
      static_cast<float>(options.roughness_m * options.roughness_m) + common * common;
  const Viewpoints views(viewpoints);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    Distribution& d = cells->distributions()[i];
    d.information =
        surplusInformation(squares[i] / static_cast<float>(d.points), cells->side(), variance);
    d.view = views.directionFrom(map.origin + d.mean.cast<double>());
  }
  cells_ = std::move(cells);
}
DistributionMap::~DistributionMap() = default;
DistributionMap::DistributionMap(DistributionMap&&) noexcept = default;
std::size_t DistributionMap::size() const { return cells_->distributions().size(); }

}  // namespace xview
