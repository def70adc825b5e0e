// SPDX-License-Identifier: BSD-3-Clause
#include "place/point_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/cells.h"
#include "place/bev_grid.h"

namespace xview {
namespace {

constexpr double kCell_m = 1.5;
constexpr float kGood_m = 0.1f;     ///< known well enough anywhere
constexpr float kWorse = 1.5f;      ///< times as uncertain as the best ones is too uncertain
constexpr std::uint32_t kBest = 8;  ///< number of the best points; a few may be accurate by mistake

constexpr float kOnGround_m = 0.2F;  ///< nothing stands that is nearer to the ground than this

/// Steps of the standard deviation, a sixth each: 0.1 m to 1.5 m, everything above in the last one.
constexpr int kSteps = 18;
constexpr float kStep = 1.1666f;

int stepOf(float sigma_m) {
  int step = 0;
  for (float limit = kGood_m; sigma_m > limit && step + 1 < kSteps; limit *= kStep) ++step;
  return step;
}

float upperEnd(int step) { return kGood_m * std::pow(kStep, static_cast<float>(step)); }

/// How many points of each step a cell has.
struct SigmaCounts {
  ClassCell key;
  std::array<std::uint32_t, kSteps> counts{};

  /// Up to this uncertainty points are kept.
  float limit() const {
    int step = 0;
    for (std::uint32_t seen = counts[0]; seen < kBest && step + 1 < kSteps;) seen += counts[++step];
    return step + 1 < kSteps ? kWorse * upperEnd(step) : INFINITY;
  }
};

constexpr double kBlockSide = 3;  ///< [voxels]
constexpr std::uint32_t kStoodThere =
    100;  ///< points in a voxel: more than a sensor on the move sees
/// Voxels of a block that are occupied: 9 of a plane, 6 to 9 of scanners and exact cameras, 13 to
/// 19 of stereo cameras (each class counted).
constexpr float kSharp = 10, kScattered = 13;
constexpr float kLines = 4;  ///< or fewer, if there are gaps between what a scanner measured

/// Voxels of a cloud by blocks.
class Blocks {
 public:
  Blocks(const LabelledCloud& voxels, const std::vector<std::uint32_t>& points, double block_m)
      : block_of_(voxels.size()) {
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const ClassCell cell = cellOf(voxels.position(i), block_m, 0);
      block_of_[i] = blocks_.numberOf(cell, [&] { return Block{cell}; });
      ++blocks_[block_of_[i]].occupied;
      blocks_[block_of_[i]].points += std::min(points[i], kStoodThere);
    }
  }

  /// Points around a voxel.
  float around(std::size_t voxel) const {
    return static_cast<float>(blocks_[block_of_[voxel]].points);
  }
  /// Occupied voxels in the block of the median voxel.
  float thickness() const { return ofMedian(&Block::occupied); }
  /// Points in the block of the median point.
  float usual() const { return ofMedian(&Block::points); }

 private:
  struct Block {
    ClassCell key;
    std::uint32_t occupied = 0, points = 0;
  };

  float ofMedian(std::uint32_t Block::*count) const {
    std::vector<std::uint32_t> counts;
    for (std::size_t i = 0; i < blocks_.size(); ++i) counts.push_back(blocks_[i].*count);
    std::sort(counts.begin(), counts.end());
    const auto all = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
    std::size_t up_to = 0, block = 0;
    while (2 * (up_to += counts[block]) < all) ++block;
    return static_cast<float>(counts[block]);
  }

  CellTable<Block> blocks_;
  std::vector<std::size_t> block_of_;
};

}  // namespace

float rangeOf(const PreprocessedFrame& frame, std::size_t i) {
  if (frame.sensor == Sensor::cloud) return 0;
  const Eigen::Vector3f sensor =
      (frame.T_odom_sensor.translation() - frame.cloud.origin).cast<float>();
  return (frame.cloud.points[i].getVector3fMap() - sensor).norm();
}

std::size_t appendKnownPoints(const LabelledCloud& addition, double max_sigma_m, std::uint32_t view,
                              LabelledCloud& cloud) {
  const Eigen::Vector3f shift = (addition.origin - cloud.origin).cast<float>();
  const std::size_t before = cloud.size();
  for (Point point : addition.points) {
    if (!(double{point.sigma} <= max_sigma_m)) continue;
    point.getVector3fMap() += shift;
    point.instance = 0;  // numbers of two of them need not agree
    point.view = view;
    cloud.points.push_back(point);
  }
  return cloud.size() - before;
}

std::vector<bool> bestMeasured(const LabelledCloud& cloud) {
  std::vector<bool> kept(cloud.size(), true);
  if (std::all_of(cloud.points.begin(), cloud.points.end(),
                  [](const Point& p) { return p.sigma <= kGood_m; }))
    return kept;
  CellTable<SigmaCounts> cells;
  std::vector<std::size_t> numbers(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const ClassCell cell = cellOf(cloud.position(i), kCell_m, cloud.points[i].label);
    numbers[i] = cells.numberOf(cell, [&] { return SigmaCounts{cell}; });
    ++cells[numbers[i]].counts[static_cast<std::size_t>(stepOf(cloud.points[i].sigma))];
  }
  std::vector<float> limits;
  for (std::size_t i = 0; i < cells.size(); ++i) limits.push_back(cells[i].limit());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    kept[i] = cloud.points[i].sigma <= std::max(kGood_m, limits[numbers[i]]);
  return kept;
}

void keepBestMeasured(LabelledCloud& cloud) {
  const std::vector<bool> keep = bestMeasured(cloud);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (keep[i]) cloud.points[kept++] = cloud.points[i];
  }
  cloud.points.resize(kept);
}

void dropContradicted(const BevGrid& bev, const LabelSet& labels, LabelledCloud& cloud) {
  const Eigen::Vector3d origin(bev.origin_x, bev.origin_y, bev.origin_z);
  const Eigen::Matrix3f R = bev.alignment.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = (bev.alignment * cloud.origin - origin).cast<float>();
  ClassCell last{};  // neighbours mostly lie in one cell
  const GroundCell* ground = bev.knownCell(last.x, last.y);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Kind kind = labels.kind(cloud.points[i].label);
    const Eigen::Vector3f p = R * cloud.points[i].getVector3fMap() + t;
    const ClassCell cell = cellOf({p.x(), p.y(), 0}, bev.cell_m, 0);
    if (!(cell == last)) ground = bev.knownCell(cell.x, cell.y);
    last = cell;
    if (kind != Kind::none && ground && ground->measured) {
      const float height_m = p.z() - ground->z;
      if (isGround(kind) ? height_m > kGroundGate_m : std::abs(height_m) < kOnGround_m) continue;
    }
    cloud.points[kept++] = cloud.points[i];
  }
  cloud.points.resize(kept);
}

bool isSparse(const LabelledCloud& voxels, const std::vector<std::uint32_t>& points,
              double voxel_m) {
  const auto single = std::count(points.begin(), points.end(), 1U);
  if (2 * static_cast<std::size_t>(single) <= points.size()) return false;
  return Blocks(voxels, points, kBlockSide * voxel_m).thickness() <= kLines;
}

std::vector<float> densityWeights(const LabelledCloud& voxels,
                                  const std::vector<std::uint32_t>& points, double voxel_m) {
  std::vector<float> weights(voxels.size(), 1);
  if (voxels.empty()) return weights;
  const Blocks blocks(voxels, points, kBlockSide * voxel_m);
  const float scattered =
      std::clamp((blocks.thickness() - kSharp) / (kScattered - kSharp), 0.f, 1.f);
  if (scattered == 0) return weights;
  const float full = blocks.usual();
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = std::pow(std::min(1.f, blocks.around(i) / full), 2 * scattered);
  return weights;
}

}  // namespace xview
