// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/best_looks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace xview {
namespace {

constexpr double kCell_m = 1.5;
constexpr float kGood_m = 0.1f;  ///< known well enough anywhere
constexpr float kWorse = 1.5f;   ///< times as uncertain as the best ones is too uncertain
constexpr std::uint32_t kBest =
    8;  ///< so many points are the best ones; a few may be known well by mistake

/// Steps of the standard deviation, a sixth each: 0.1 m to 1.5 m, everything above in the last one.
constexpr int kSteps = 18;
constexpr float kStep = 1.1666f;

int stepOf(float sigma_m) {
  int step = 0;
  for (float limit = kGood_m; sigma_m > limit && step + 1 < kSteps; limit *= kStep) ++step;
  return step;
}

float upperEnd(int step) { return kGood_m * std::pow(kStep, static_cast<float>(step)); }

struct Cell {
  std::int64_t x, y, z;
  std::uint32_t label;
  bool operator==(const Cell& o) const {
    return x == o.x && y == o.y && z == o.z && label == o.label;
  }
  std::uint64_t hash() const {
    std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint64_t>(y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint64_t>(z) * 0x94D049BB133111EBull;
    h = (h ^ (h >> 30)) + label * 0xD1342543DE82EF95ull;
    return h ^ (h >> 32);
  }
};

Cell cellOf(const LabelledCloud& cloud, std::size_t i) {
  const Eigen::Vector3d p = cloud.position(i) / kCell_m;
  return {static_cast<std::int64_t>(std::floor(p.x())),
          static_cast<std::int64_t>(std::floor(p.y())),
          static_cast<std::int64_t>(std::floor(p.z())), cloud.points[i].label};
}

/// How many points of each step a cell has.
class Looks {
 public:
  /// Number of the cell, which is made if it is new.
  std::uint32_t numberOf(const Cell& cell) {
    if (2 * cells_.size() >= slots_.size()) grow();
    const std::size_t slot = slotOf(cell);
    if (slots_[slot] == 0) {
      cells_.push_back(cell);
      counts_.push_back({});
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
    }
    return slots_[slot] - 1;
  }
  void count(std::uint32_t number, float sigma_m) { ++counts_[number][stepOf(sigma_m)]; }

  /// Per cell, what is kept.
  std::vector<float> limits() const {
    std::vector<float> limits;
    for (const auto& counts : counts_) {
      int step = 0;
      for (std::uint32_t seen = counts[0]; seen < kBest && step + 1 < kSteps;)
        seen += counts[++step];
      limits.push_back(step + 1 < kSteps ? kWorse * upperEnd(step) : INFINITY);
    }
    return limits;
  }

 private:
  std::size_t slotOf(const Cell& cell) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = cell.hash() & mask;
    while (slots_[slot] != 0 && !(cells_[slots_[slot] - 1] == cell)) slot = (slot + 1) & mask;
    return slot;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), 0);
    for (std::size_t i = 0; i < cells_.size(); ++i)
      slots_[slotOf(cells_[i])] = static_cast<std::uint32_t>(i + 1);
  }

  std::vector<std::uint32_t> slots_ =
      std::vector<std::uint32_t>(1024, 0);  ///< 1 + number, 0 = free
  std::vector<Cell> cells_;
  std::vector<std::array<std::uint32_t, kSteps>> counts_;
};

}  // namespace

std::vector<bool> bestLooks(const LabelledCloud& cloud) {
  std::vector<bool> kept(cloud.size(), true);
  if (std::all_of(cloud.points.begin(), cloud.points.end(),
                  [](const Point& p) { return p.sigma <= kGood_m; }))
    return kept;
  Looks looks;
  std::vector<std::uint32_t> numbers(cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    numbers[i] = looks.numberOf(cellOf(cloud, i));
    looks.count(numbers[i], cloud.points[i].sigma);
  }
  const std::vector<float> limits = looks.limits();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    kept[i] = cloud.points[i].sigma <= std::max(kGood_m, limits[numbers[i]]);
  return kept;
}

}  // namespace xview
