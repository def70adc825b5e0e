// SPDX-License-Identifier: BSD-3-Clause
#include "place/bev_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "place/bev_cells.h"

namespace xview {
namespace {

constexpr double kAerialShare = 0.5;  ///< of the weights that come from the air make a view aerial
/// Of the cells of buildings that lie amid a roof make a view aerial; from what height, and how
/// thick.
constexpr double kRoofShare = 0.5;
constexpr float kRoof_m = 2, kRoofThickness_m = 1;
constexpr int kFewestRoofs = 100;  ///< cells: 25 m2

using FloorClass = std::int8_t;  ///< one of kRoad, kSidewalk, kTerrain, kNoFloor
constexpr FloorClass kNoFloor = -1, kSidewalk = 1;
constexpr std::array<BevChannel, 3> kAreas = {BevChannel::road, BevChannel::sidewalk,
                                              BevChannel::terrain};
constexpr float kMarkingShare = 0.4f;  ///< of the ground weights of a cell that is a lane marking

/// The majority ground class of a cell; lane markings count as road.
FloorClass floorClass(const FloorCell& cell) {
  const std::array<float, 3> weights = {cell.weight_sum[0] + cell.weight_sum[3], cell.weight_sum[1],
                                        cell.weight_sum[2]};
  const auto best = std::max_element(weights.begin(), weights.end());
  const bool clear = *best > 0 && cell.ground() >= kMinWeight && *best >= kMinShare * cell.ground();
  return clear ? static_cast<FloorClass>(best - weights.begin()) : kNoFloor;
}

/// The majority of the 3x3 neighbourhood of a cell with a class: labels of a network flicker at the
/// scale of a cell.
FloorClass majorityAround(const BevCells& cells, const std::vector<FloorClass>& classes,
                          std::size_t i) {
  if (classes[i] == kNoFloor) return kNoFloor;
  std::array<int, 3> count{};
  cells.index.forAround(i, 1, [&](std::int32_t j) {
    if (classes[j] != kNoFloor) ++count[classes[j]];
  });
  const auto best = std::max_element(count.begin(), count.end());
  return *best > count[classes[i]] ? static_cast<FloorClass>(best - count.begin()) : classes[i];
}

BevChannel borderChannel(FloorClass a, FloorClass b) {
  const auto [low, high] = std::minmax(a, b);
  if (low == kSidewalk) return BevChannel::border_sidewalk_terrain;
  return high == kSidewalk ? BevChannel::border_road_sidewalk : BevChannel::border_road_terrain;
}

/// Road, sidewalk, terrain and lane markings, and the borders between the first three.
void addFloor(const BevCells& cells, BevGrid& view) {
  constexpr auto kHalf = static_cast<float>(kBevCell_m) / 2;
  std::vector<FloorClass> raw, classes;
  for (const FloorCell& cell : cells.floor) raw.push_back(floorClass(cell));
  for (std::size_t i = 0; i < raw.size(); ++i) classes.push_back(majorityAround(cells, raw, i));
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i] == kNoFloor) continue;
    const FloorCell& cell = cells.floor[i];
    const PlaneCell c = cells.cell(i);
    const BevSample middle = cells.middleOf(i);
    view[kAreas[classes[i]]].push_back(middle);
    if (cell.weight_sum[3] > kMarkingShare * cell.ground())
      view[BevChannel::lane_marking].push_back(middle);
    const auto addBorder = [&](std::int32_t j, float x, float y) {
      if (j < 0 || classes[j] == kNoFloor || classes[j] == classes[i]) return;
      view[borderChannel(classes[i], classes[j])].push_back({x, y, middle.z});
    };
    addBorder(cells.index.find(c.x + 1, c.y), middle.x + kHalf, middle.y);
    addBorder(cells.index.find(c.x, c.y + 1), middle.x, middle.y + kHalf);
  }
}

void addObstacleCell(const ObstacleCell& cell, float height, BevGrid& view) {
  const auto put = [&](BevChannel channel, Kind kind) {
    const ClassColumn& s = cell.of(kind);
    view[channel].push_back({s.sum_x / s.weight_sum, s.sum_y / s.weight_sum, height});
  };
  if (cell.holds(Kind::building, kMinShare)) {
    put(BevChannel::building, Kind::building);
    if (cell.of(Kind::building).low >= 0.5f * kMinWeight)
      put(BevChannel::wall_foot, Kind::building);
  }
  if (cell.holds(Kind::fence, kMinShare)) put(BevChannel::fence, Kind::fence);
  if (cell.holds(Kind::vegetation, kMinShare)) {
    const ClassColumn& plants = cell.of(Kind::vegetation);
    if (plants.low >= kMinWeight) put(BevChannel::low_vegetation, Kind::vegetation);
    if (plants.high >= kMinWeight) put(BevChannel::canopy, Kind::vegetation);
  }
  if (cell.holds(Kind::vehicle, kMinShare)) put(BevChannel::vehicle_surface, Kind::vehicle);
  if (cell.holds(Kind::other_surface, kMinShare))
    put(BevChannel::other_surface, Kind::other_surface);
}

void addObstacleCells(const BevCells& cells, BevGrid& view) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const ObstacleCell* cell = cells.obstacleCellOf(i);
    if (!cell) continue;
    const BevSample middle = cells.middleOf(i);
    if (cell->obstacle_low >= kMinWeight) view[BevChannel::obstacle_low].push_back(middle);
    if (cell->obstacle_high >= kMinWeight) view[BevChannel::obstacle_high].push_back(middle);
    addObstacleCell(*cell, middle.z, view);
  }
}

void addKnown(const BevCells& cells, BevGrid& view) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const FloorCell& floor = cells.floor[i];
    if (floor.total < kMinWeight) continue;
    view.known.push_back(
        {cells.cell(i).x, cells.cell(i).y, floor.height, floor.ground() > kMinWeight});
  }
}

/// Whether areas of roofs are most of what is seen of buildings: who looks from the ground sees
/// lines of walls, and the floor below whatever hangs over it.
bool showsRoofs(const BevCells& cells) {
  // Flat, high and with nothing below it: a piece of a roof, or the top of a wall.
  std::vector<bool> is_flat(cells.size());
  int roofs = 0, all = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const ObstacleCell* cell = cells.obstacleCellOf(i);
    if (!cell || !cell->holds(Kind::building, kMinShare)) continue;
    ++all;
    const ClassColumn& s = cell->of(Kind::building);
    is_flat[i] =
        s.bottom > kRoof_m && s.top - s.bottom < kRoofThickness_m && !(cells.floor[i].ground() > 0);
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!is_flat[i]) continue;
    int around = 0;
    cells.index.forAround(i, 1, [&](std::int32_t j) { around += is_flat[j]; });
    roofs += around == 9;
  }
  return roofs >= kFewestRoofs && roofs >= kRoofShare * all;
}

/// False for points that are no numbers, or so far away that their cells have no number.
bool isSomewhere(const Eigen::Vector3d& p) {
  constexpr double kFarthest_m = 1e8;
  return std::abs(p.x()) < kFarthest_m && std::abs(p.y()) < kFarthest_m &&
         std::abs(p.z()) < kFarthest_m;
}

/// A labelled point and what it counts.
struct BevPoint {
  VoxelKey key;
  float x, y, z;  ///< relative to the origin of the grid [m]
  float weight;
  bool near;  ///< measured near enough for thin objects
};

/// Adds weights to their voxels; what one of them needs is asked for some weights ahead.
void sum(const std::vector<BevPoint>& weights, CellTable<BevVoxel, BevVoxels>& voxels) {
  constexpr std::size_t kSlotAhead = 16, kVoxelAhead = 8;
  voxels.reserve(voxels.size() + weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (i + kSlotAhead < weights.size()) voxels.prefetchSlot(weights[i + kSlotAhead].key);
    if (i + kVoxelAhead < weights.size()) voxels.prefetchEntry(weights[i + kVoxelAhead].key);
    const BevPoint& vote = weights[i];
    BevVoxel& voxel = voxels[voxels.numberOf(
        vote.key, [&] { return BevVoxel{vote.key, vote.x, vote.y, vote.z, 0, 0}; })];
    voxel.weight_sum += vote.weight;
    if (vote.near) voxel.near_weight += vote.weight;
    const float share = vote.weight / voxel.weight_sum;
    voxel.x += share * (vote.x - voxel.x);
    voxel.y += share * (vote.y - voxel.y);
    voxel.z += share * (vote.z - voxel.z);
  }
}

}  // namespace

VoxelKey voxelOf(const Eigen::Vector3d& p, Kind kind) {
  const auto index = [](double coordinate) {
    const double q = coordinate * (1.0 / kBevVoxel_m);
    const auto toward_zero = static_cast<std::int64_t>(q);
    return toward_zero - (q < static_cast<double>(toward_zero));
  };
  const auto ix = static_cast<std::uint64_t>(index(p.x()) + (1 << 20)) & 0x1FFFFF;
  const auto iy = static_cast<std::uint64_t>(index(p.y()) + (1 << 20)) & 0x1FFFFF;
  const auto iz = static_cast<std::uint64_t>(index(p.z()) + (1 << 17)) & 0x3FFFF;
  return {(ix << 43) | (iy << 22) | (iz << 4) | static_cast<std::uint64_t>(kind)};
}

struct BevGridBuilder::State {
  explicit State(const LabelSet& set) : labels(set) {}

  /// Whole multiples of 128 cells, so that two views of one frame share their cells.
  void setOrigin(const Eigen::Vector3d& first_point) {
    constexpr double kGrid_m = 128 * kBevCell_m;
    origin = (first_point / kGrid_m).array().floor() * kGrid_m;
    has_origin = true;
  }

  LabelSet labels;
  CellTable<BevVoxel, BevVoxels> voxels;  ///< sums of weights per voxel and kind
  std::vector<BevPoint> cast;             ///< of the frame that is being added
  bool has_origin = false;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double weight_sum = 0, aerial_weight = 0;
};

BevGridBuilder::BevGridBuilder(const LabelSet& labels) : state_(std::make_unique<State>(labels)) {}
BevGridBuilder::~BevGridBuilder() = default;

void BevGridBuilder::add(const LabelledCloud& cloud, const std::vector<float>& weights,
                         const std::vector<bool>& near, const Eigen::Isometry3d& T_bev_cloud,
                         bool aerial) {
  State& s = *state_;
  const Eigen::Matrix3d R = T_bev_cloud.linear();
  const Eigen::Vector3d t = T_bev_cloud * cloud.origin;
  s.cast.clear();
  s.cast.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Kind kind = s.labels.kind(cloud.points[i].label);
    if (kind == Kind::none || !(weights[i] > 0)) continue;
    const Eigen::Vector3d p_bev = R * cloud.points[i].getVector3fMap().cast<double>().eval() + t;
    if (!isSomewhere(p_bev)) continue;
    if (!s.has_origin) s.setOrigin(p_bev);
    const Eigen::Vector3d p = p_bev - s.origin;
    const Eigen::Vector3f q = p.cast<float>();
    s.cast.push_back({voxelOf(p, kind), q.x(), q.y(), q.z(), weights[i], near.empty() || near[i]});
    s.weight_sum += weights[i];
    if (aerial) s.aerial_weight += weights[i];
  }
  sum(s.cast, s.voxels);
}

BevGrid BevGridBuilder::build(bool tells_by_roofs) const {
  const State& s = *state_;
  BevGrid view;
  view.cell_m = kBevCell_m;
  view.origin_x = s.origin.x();
  view.origin_y = s.origin.y();
  view.origin_z = s.origin.z();
  view.aerial = s.weight_sum > 0 && s.aerial_weight >= kAerialShare * s.weight_sum;
  const BevVoxels& voxels = s.voxels.entries();
  if (voxels.empty()) return view;
  const auto cellsOf = [&] {
    const GroundRule rule = groundRule(view.aerial);
    return sortIntoCells(voxels, groundSurface(voxels, rule), rule);
  };
  std::optional<BevCells> sorted(cellsOf());
  if (tells_by_roofs && !view.aerial && showsRoofs(*sorted)) {
    view.aerial = true;
    sorted.emplace(cellsOf());
  }
  const BevCells& cells = *sorted;
  addFloor(cells, view);
  addObstacleCells(cells, view);
  findPosts(cells, view);
  findBevObjects(cells, view);
  addKnown(cells, view);
  // Whatever the order of the frames was.
  for (auto& channel : view.samples) std::sort(channel.begin(), channel.end(), InRowOrder());
  std::sort(view.known.begin(), view.known.end(), InRowOrder());
  return view;
}

}  // namespace xview
