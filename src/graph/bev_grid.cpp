// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/bev_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "graph/bev_cells.h"

namespace xview::graph {
namespace {

constexpr double kAerialShare = 0.5;  ///< of the votes that come from the air make a view aerial

using FloorClass = std::int8_t;  ///< one of kRoad, kSidewalk, kTerrain, kNoFloor
constexpr FloorClass kNoFloor = -1, kSidewalk = 1;
constexpr std::array<Channel, 3> kAreas = {Channel::road, Channel::sidewalk, Channel::terrain};
constexpr float kMarkingShare = 0.4f;  ///< of the ground votes of a cell that is a lane marking

/// The majority ground class of a cell; lane markings count as road.
FloorClass floorClass(const FloorCell& cell) {
  const std::array<float, 3> votes = {cell.votes[0] + cell.votes[3], cell.votes[1], cell.votes[2]};
  const auto best = std::max_element(votes.begin(), votes.end());
  const bool clear = *best > 0 && cell.ground() >= kMinVotes && *best >= kMinShare * cell.ground();
  return clear ? static_cast<FloorClass>(best - votes.begin()) : kNoFloor;
}

/// The majority of the 3x3 neighbourhood of a cell with a class: labels of a network flicker at the
/// scale of a cell.
FloorClass majorityAround(const PlanCells& cells, const std::vector<FloorClass>& classes,
                          std::size_t i) {
  if (classes[i] == kNoFloor) return kNoFloor;
  std::array<int, 3> count{};
  cells.index.forAround(i, 1, [&](std::int32_t j) {
    if (classes[j] != kNoFloor) ++count[classes[j]];
  });
  const auto best = std::max_element(count.begin(), count.end());
  return *best > count[classes[i]] ? static_cast<FloorClass>(best - count.begin()) : classes[i];
}

Channel borderChannel(FloorClass a, FloorClass b) {
  const auto [low, high] = std::minmax(a, b);
  if (low == kSidewalk) return Channel::border_sidewalk_terrain;
  return high == kSidewalk ? Channel::border_road_sidewalk : Channel::border_road_terrain;
}

/// Road, sidewalk, terrain and lane markings, and the borders between the first three.
void addFloor(const PlanCells& cells, PlanView& view) {
  constexpr auto kHalf = static_cast<float>(kPlanCell_m) / 2;
  std::vector<FloorClass> raw, classes;
  for (const FloorCell& cell : cells.floor) raw.push_back(floorClass(cell));
  for (std::size_t i = 0; i < raw.size(); ++i) classes.push_back(majorityAround(cells, raw, i));
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i] == kNoFloor) continue;
    const FloorCell& cell = cells.floor[i];
    const CellIndex::Cell c = cells.cell(i);
    const PlanSample middle = cells.middleOf(i);
    view[kAreas[classes[i]]].push_back(middle);
    if (cell.votes[3] > kMarkingShare * cell.ground())
      view[Channel::lane_marking].push_back(middle);
    const auto addBorder = [&](std::int32_t j, float x, float y) {
      if (j < 0 || classes[j] == kNoFloor || classes[j] == classes[i]) return;
      view[borderChannel(classes[i], classes[j])].push_back({x, y, middle.z});
    };
    addBorder(cells.index.find(c.x + 1, c.y), middle.x + kHalf, middle.y);
    addBorder(cells.index.find(c.x, c.y + 1), middle.x, middle.y + kHalf);
  }
}

void addUprightCell(const UprightCell& cell, float height, PlanView& view) {
  const auto put = [&](Channel channel, Kind kind) {
    const Standing& s = cell.of(kind);
    view[channel].push_back({s.sum_x / s.votes, s.sum_y / s.votes, height});
  };
  if (cell.holds(Kind::building, kMinShare)) {
    put(Channel::building, Kind::building);
    if (cell.of(Kind::building).low >= 0.5f * kMinVotes) put(Channel::wall_foot, Kind::building);
  }
  if (cell.holds(Kind::fence, kMinShare)) put(Channel::fence, Kind::fence);
  if (cell.holds(Kind::vegetation, kMinShare)) {
    const Standing& plants = cell.of(Kind::vegetation);
    if (plants.low >= kMinVotes) put(Channel::low_vegetation, Kind::vegetation);
    if (plants.high >= kMinVotes) put(Channel::canopy, Kind::vegetation);
  }
  if (cell.holds(Kind::vehicle, kMinShare)) put(Channel::vehicle_surface, Kind::vehicle);
  if (cell.holds(Kind::other_surface, kMinShare)) put(Channel::other_surface, Kind::other_surface);
}

void addUprights(const PlanCells& cells, PlanView& view) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const UprightCell* cell = cells.uprightOf(i);
    if (!cell) continue;
    const PlanSample middle = cells.middleOf(i);
    if (cell->obstacle_low >= kMinVotes) view[Channel::obstacle_low].push_back(middle);
    if (cell->obstacle_high >= kMinVotes) view[Channel::obstacle_high].push_back(middle);
    addUprightCell(*cell, middle.z, view);
  }
}

void addKnown(const PlanCells& cells, PlanView& view) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const FloorCell& floor = cells.floor[i];
    if (floor.total < kMinVotes) continue;
    view.known.push_back(
        {cells.cell(i).x, cells.cell(i).y, floor.height, floor.ground() > kMinVotes});
  }
}

/// False for points that are no numbers, or so far away that their cells have no number.
bool isSomewhere(const Eigen::Vector3d& p) {
  constexpr double kFarthest_m = 1e8;
  return std::abs(p.x()) < kFarthest_m && std::abs(p.y()) < kFarthest_m &&
         std::abs(p.z()) < kFarthest_m;
}

/// A labelled point and what it counts.
struct PlanVote {
  VoxelKey key;
  float x, y, z;  ///< relative to the plan origin [m]
  float votes;
  bool near;  ///< measured near enough for thin objects
};

/// Adds votes to their voxels; what one of them needs is asked for some votes ahead.
void sum(const std::vector<PlanVote>& votes, CellTable<PlanVoxel, PlanVoxels>& voxels) {
  constexpr std::size_t kSlotAhead = 16, kVoxelAhead = 8;
  voxels.reserve(voxels.size() + votes.size());
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (i + kSlotAhead < votes.size()) voxels.prefetchSlot(votes[i + kSlotAhead].key);
    if (i + kVoxelAhead < votes.size()) voxels.prefetchEntry(votes[i + kVoxelAhead].key);
    const PlanVote& vote = votes[i];
    PlanVoxel& voxel = voxels[voxels.numberOf(
        vote.key, [&] { return PlanVoxel{vote.key, vote.x, vote.y, vote.z, 0, 0}; })];
    voxel.votes += vote.votes;
    if (vote.near) voxel.near_votes += vote.votes;
    const float share = vote.votes / voxel.votes;
    voxel.x += share * (vote.x - voxel.x);
    voxel.y += share * (vote.y - voxel.y);
    voxel.z += share * (vote.z - voxel.z);
  }
}

}  // namespace

VoxelKey voxelOf(const Eigen::Vector3d& p, Kind kind) {
  const auto index = [](double coordinate) {
    const double q = coordinate * (1.0 / kPlanVoxel_m);
    const auto toward_zero = static_cast<std::int64_t>(q);
    return toward_zero - (q < static_cast<double>(toward_zero));
  };
  const auto ix = static_cast<std::uint64_t>(index(p.x()) + (1 << 20)) & 0x1FFFFF;
  const auto iy = static_cast<std::uint64_t>(index(p.y()) + (1 << 20)) & 0x1FFFFF;
  const auto iz = static_cast<std::uint64_t>(index(p.z()) + (1 << 17)) & 0x3FFFF;
  return {(ix << 43) | (iy << 22) | (iz << 4) | static_cast<std::uint64_t>(kind)};
}

struct PlanViewBuilder::State {
  explicit State(const LabelSet& set) : labels(set) {}

  /// Whole multiples of 128 cells, so that two views of one frame share their cells.
  void setOrigin(const Eigen::Vector3d& first_point) {
    constexpr double kGrid_m = 128 * kPlanCell_m;
    origin = (first_point / kGrid_m).array().floor() * kGrid_m;
    has_origin = true;
  }

  LabelSet labels;
  CellTable<PlanVoxel, PlanVoxels> voxels;  ///< sums of votes per voxel and kind
  std::vector<PlanVote> cast;               ///< of the frame that is being added
  bool has_origin = false;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double votes = 0, aerial_votes = 0;
};

PlanViewBuilder::PlanViewBuilder(const LabelSet& labels)
    : state_(std::make_unique<State>(labels)) {}
PlanViewBuilder::~PlanViewBuilder() = default;

void PlanViewBuilder::add(const LabelledCloud& cloud, const std::vector<float>& votes,
                          const std::vector<bool>& near, const Eigen::Isometry3d& T_plan_cloud,
                          bool aerial) {
  State& s = *state_;
  const Eigen::Matrix3d R = T_plan_cloud.linear();
  const Eigen::Vector3d t = T_plan_cloud * cloud.origin;
  s.cast.clear();
  s.cast.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Kind kind = s.labels.kind(cloud.points[i].label);
    if (kind == Kind::none || !(votes[i] > 0)) continue;
    const Eigen::Vector3d p_plan = R * cloud.points[i].getVector3fMap().cast<double>().eval() + t;
    if (!isSomewhere(p_plan)) continue;
    if (!s.has_origin) s.setOrigin(p_plan);
    const Eigen::Vector3d p = p_plan - s.origin;
    const Eigen::Vector3f q = p.cast<float>();
    s.cast.push_back({voxelOf(p, kind), q.x(), q.y(), q.z(), votes[i], near.empty() || near[i]});
    s.votes += votes[i];
    if (aerial) s.aerial_votes += votes[i];
  }
  sum(s.cast, s.voxels);
}

PlanView PlanViewBuilder::build() const {
  const State& s = *state_;
  PlanView view;
  view.cell_m = kPlanCell_m;
  view.origin_x = s.origin.x();
  view.origin_y = s.origin.y();
  view.origin_z = s.origin.z();
  view.aerial = s.votes > 0 && s.aerial_votes >= kAerialShare * s.votes;
  const PlanVoxels& voxels = s.voxels.entries();
  if (voxels.empty()) return view;
  const GroundRule rule = groundRule(view.aerial);
  const PlanCells cells = sortIntoCells(voxels, groundSurface(voxels, rule), rule);
  addFloor(cells, view);
  addUprights(cells, view);
  findPosts(cells, view);
  findPlanObjects(cells, view);
  addKnown(cells, view);
  // Whatever the order of the frames was.
  for (auto& channel : view.samples)
    std::sort(channel.begin(), channel.end(), inRowOrder<PlanSample>);
  std::sort(view.known.begin(), view.known.end(), inRowOrder<GroundCell>);
  return view;
}

}  // namespace xview::graph
