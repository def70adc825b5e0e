// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/plan_view.h"

#include <algorithm>
#include <cmath>

#include "graph/plan_cells.h"
#include "graph/plan_floor.h"
#include "graph/plan_ground.h"
#include "graph/plan_objects.h"
#include "graph/plan_voxels.h"

namespace xview {
namespace {

void addUprightCell(const UprightCell& cell, float height, const PlanOptions& options,
                    PlanView& view) {
  const double votes = options.min_votes, share = options.min_share;
  const auto put = [&](Channel channel, Kind kind) {
    const Standing& s = *cell.find(kind);
    view[channel].push_back({s.sum_x / s.votes, s.sum_y / s.votes, height});
  };
  if (cell.holds(Kind::building, votes, share)) {
    put(Channel::building, Kind::building);
    if (cell.lowOf(Kind::building) >= 0.5 * votes) put(Channel::wall_foot, Kind::building);
  }
  if (cell.holds(Kind::fence, votes, share)) put(Channel::fence, Kind::fence);
  if (cell.holds(Kind::vegetation, votes, share)) {
    if (cell.lowOf(Kind::vegetation) >= votes) put(Channel::low_vegetation, Kind::vegetation);
    if (cell.highOf(Kind::vegetation) >= votes) put(Channel::canopy, Kind::vegetation);
  }
  if (cell.holds(Kind::vehicle, votes, share)) put(Channel::vehicle_surface, Kind::vehicle);
  if (cell.holds(Kind::other_surface, votes, share))
    put(Channel::other_surface, Kind::other_surface);
}

void addUprights(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  const auto side = static_cast<float>(options.cell_m);
  for (std::size_t i = 0; i < cells.floor.size(); ++i) {
    const UprightCell* cell = cells.uprightOf(i);
    if (!cell) continue;
    const CellIndex::Cell c = cells.index.cells()[i];
    const PlanSample middle{(static_cast<float>(c.x) + 0.5f) * side,
                            (static_cast<float>(c.y) + 0.5f) * side, cells.floor[i].height};
    if (cell->obstacle_low >= options.min_votes) view[Channel::obstacle_low].push_back(middle);
    if (cell->obstacle_high >= options.min_votes) view[Channel::obstacle_high].push_back(middle);
    addUprightCell(*cell, middle.z, options, view);
  }
}

void addKnown(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  for (std::size_t i = 0; i < cells.floor.size(); ++i) {
    if (cells.floor[i].total < options.min_votes) continue;
    const CellIndex::Cell c = cells.index.cells()[i];
    view.known.push_back(
        {c.x, c.y, cells.floor[i].height, cells.floor[i].ground() > options.min_votes});
  }
}

/// Samples and cells in (y, x) order, whatever the order of the frames was.
void sortView(PlanView& view) {
  for (auto& channel : view.samples) {
    std::sort(channel.begin(), channel.end(), [](const PlanSample& a, const PlanSample& b) {
      return a.y != b.y ? a.y < b.y : a.x < b.x;
    });
  }
  std::sort(view.known.begin(), view.known.end(), [](const GroundCell& a, const GroundCell& b) {
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
}

/// LabelSet::kind as a table, because it is asked for every point.
class KindTable {
 public:
  explicit KindTable(const LabelSet& set) : set_(set) {
    for (const auto& [id, info] : set.classes()) {
      if (id >= kLargest) continue;
      if (id >= table_.size()) table_.resize(id + 1, Kind::none);
      table_[id] = set.kind(id);
    }
  }
  Kind of(std::uint32_t id) const {
    return id < table_.size() ? table_[id] : id < kLargest ? Kind::none : set_.kind(id);
  }

 private:
  static constexpr std::uint32_t kLargest = 1 << 16;
  LabelSet set_;
  std::vector<Kind> table_;
};

/// False for points that are no numbers, or so far away that their cells have no number.
bool isSomewhere(const Eigen::Vector3d& p) {
  constexpr double kFarthest_m = 1e8;
  return std::abs(p.x()) < kFarthest_m && std::abs(p.y()) < kFarthest_m &&
         std::abs(p.z()) < kFarthest_m;
}

}  // namespace

struct PlanViewBuilder::State {
  State(const LabelSet& set, const PlanOptions& plan_options)
      : kinds(set), options(plan_options), voxels(plan_options.voxel_m) {}

  /// Whole multiples of 128 cells, so that two views of one frame share their cells.
  void setOrigin(const Eigen::Vector3d& first_point) {
    const double grid_m = 128 * options.cell_m;
    origin = (first_point / grid_m).array().floor() * grid_m;
    has_origin = true;
  }

  KindTable kinds;
  PlanOptions options;
  PlanVoxels voxels;
  std::vector<PlanVote> cast;  ///< of the frame that is being added
  bool has_origin = false;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double votes = 0, aerial_votes = 0;
};

PlanViewBuilder::PlanViewBuilder(const LabelSet& labels, const PlanOptions& options)
    : state_(std::make_unique<State>(labels, options)) {}
PlanViewBuilder::~PlanViewBuilder() = default;
PlanViewBuilder::PlanViewBuilder(PlanViewBuilder&&) noexcept = default;
PlanViewBuilder& PlanViewBuilder::operator=(PlanViewBuilder&&) noexcept = default;

void PlanViewBuilder::add(const LabelledCloud& cloud, const std::vector<float>& votes,
                          const std::vector<bool>& near, const Eigen::Isometry3d& T_plan_cloud,
                          bool aerial) {
  State& s = *state_;
  const Eigen::Matrix3d R = T_plan_cloud.linear();
  const Eigen::Vector3d t = T_plan_cloud * cloud.origin;
  s.cast.clear();
  s.cast.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Kind kind = s.kinds.of(cloud.points[i].label);
    if (kind == Kind::none || !(votes[i] > 0)) continue;
    const Eigen::Vector3d p_plan = R * cloud.points[i].getVector3fMap().cast<double>().eval() + t;
    if (!isSomewhere(p_plan)) continue;
    if (!s.has_origin) s.setOrigin(p_plan);
    const Eigen::Vector3d p = p_plan - s.origin;
    const Eigen::Vector3f q = p.cast<float>();
    s.cast.push_back({s.voxels.keyOf(p.x(), p.y(), p.z(), kind), q.x(), q.y(), q.z(), votes[i],
                      near.empty() || near[i]});
    s.votes += votes[i];
    if (aerial) s.aerial_votes += votes[i];
  }
  s.voxels.add(s.cast);
}

PlanView PlanViewBuilder::build() const {
  const State& s = *state_;
  PlanView view;
  view.cell_m = s.options.cell_m;
  view.origin_x = s.origin.x();
  view.origin_y = s.origin.y();
  view.origin_z = s.origin.z();
  view.aerial = s.votes > 0 && s.aerial_votes >= s.options.min_aerial_share * s.votes;
  if (s.voxels.voxels().empty()) return view;
  const GroundRule rule = groundRule(s.options, view.aerial);
  const GroundSurface ground(s.voxels.voxels(), rule);
  const PlanCells cells = sortIntoCells(s.voxels.voxels(), ground, rule, s.options);
  addFloor(cells, s.options, view);
  addUprights(cells, s.options, view);
  findPlanObjects(cells, s.options, view);
  addKnown(cells, s.options, view);
  sortView(view);
  return view;
}

}  // namespace xview
