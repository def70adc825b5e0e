// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/query_in_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "xview/raw_recording.h"
#include "xview/types/error.h"
#include "xview/types/label_match.h"
#include "xview/types/place_size.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

bool isTurn(const Eigen::Quaterniond& R) {
  return R.angularDistance(Eigen::Quaterniond::Identity()) > 0;
}

void turn(const Eigen::Quaterniond& R, SemanticGraph& graph, LabelledCloud& cloud, PlanView& plan) {
  for (Vertex& v : graph.vertices) v.position = R * v.position;
  const Eigen::Matrix3f turned = R.toRotationMatrix().cast<float>();
  for (Point& p : cloud.points) p.getVector3fMap() = turned * p.getVector3fMap();
  cloud.origin = R * cloud.origin;
  plan.upright = plan.upright * R.conjugate();
}

/// Sorted, one per cell: a measured one if there is one, else the first.
std::vector<GroundCell> onePerCell(std::vector<GroundCell> cells) {
  std::stable_sort(cells.begin(), cells.end(), [](const GroundCell& a, const GroundCell& b) {
    return std::tuple(a.y, a.x, !a.measured) < std::tuple(b.y, b.x, !b.measured);
  });
  const auto areOne = [](const GroundCell& a, const GroundCell& b) {
    return a.x == b.x && a.y == b.y;
  };
  cells.erase(std::unique(cells.begin(), cells.end(), areOne), cells.end());
  return cells;
}

/// A view from above drawn in a turned frame, in which it is upright.
PlanView turnedPlan(const PlanView& view, const Eigen::Quaterniond& R) {
  PlanView turned = view;
  turned.upright = Eigen::Quaterniond::Identity();
  const Eigen::Vector3d origin(view.origin_x, view.origin_y, view.origin_z);
  const auto toTurned = [&](double x, double y, double z) -> Eigen::Vector3d {
    return R * (origin + Eigen::Vector3d(x, y, z)) - origin;
  };
  for (auto& channel : turned.samples) {
    for (PlanSample& s : channel) {
      const Eigen::Vector3f p = toTurned(s.x, s.y, s.z).cast<float>();
      s = {p.x(), p.y(), p.z()};
    }
  }
  for (GroundCell& cell : turned.known) {
    const Eigen::Vector3d p =
        toTurned((cell.x + 0.5) * view.cell_m, (cell.y + 0.5) * view.cell_m, cell.z);
    cell.x = static_cast<std::int32_t>(std::floor(p.x() / view.cell_m));
    cell.y = static_cast<std::int32_t>(std::floor(p.y() / view.cell_m));
    cell.z = static_cast<float>(p.z());
  }
  turned.known = onePerCell(std::move(turned.known));
  return turned;
}

/// What the query shows, horizontally; of bare graphs the vertices.
Eigen::AlignedBox2d boxOf(const Query& query) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < query.cloud.size(); ++i)
    box.extend(query.cloud.position(i).head<2>());
  for (const Vertex& vertex : query.graph.vertices) box.extend(vertex.position.head<2>());
  return box;
}

/// The kinds of ground that a set knows, as bits.
unsigned groundsOf(const LabelSet& labels) {
  unsigned grounds = 0;
  for (const auto& [id, info] : labels.classes()) {
    if (info.role == Role::ignored) continue;
    if (info.kind == Kind::road || info.kind == Kind::lane_marking) grounds |= 1;
    if (info.kind == Kind::sidewalk) grounds |= 2;
    if (info.kind == Kind::terrain) grounds |= 4;
  }
  return grounds;
}

}  // namespace

Detail commonDetail(const LabelSet& query, const LabelSet& map) {
  if (query == map) return Detail::classes;
  if (knowsShapesOnly(query)) return knowsShapesOnly(map) ? Detail::classes : Detail::shapes;
  if (knowsShapesOnly(map)) return Detail::classes;
  const unsigned in_query = groundsOf(query), in_map = groundsOf(map);
  const bool differ = in_query != 0 && in_map != 0 && in_query != in_map;
  return differ ? Detail::one_ground : Detail::classes;
}

void mergeGround(PlanView& plan) {
  for (const Channel ground : {Channel::sidewalk, Channel::terrain}) {
    plan[Channel::road].insert(plan[Channel::road].end(), plan[ground].begin(), plan[ground].end());
    plan[ground].clear();
  }
  std::sort(plan[Channel::road].begin(), plan[Channel::road].end(), inRowOrder<PlanSample>);
  for (const Channel line : {Channel::lane_marking, Channel::border_road_sidewalk,
                             Channel::border_sidewalk_terrain, Channel::border_road_terrain})
    plan[line].clear();
}

std::optional<map::SemanticMap> uprightMap(const map::SemanticMap& map,
                                           const Eigen::Quaterniond& R_up) {
  if (!isTurn(R_up)) return std::nullopt;
  map::SemanticMap turned = map;
  turn(R_up, turned.graph, turned.cloud, turned.plan);
  for (Eigen::Isometry3d& T : turned.poses) T = R_up * T;
  return turned;
}

Query turnedQuery(const Query& query, const Eigen::Quaterniond& R_up) {
  Query turned = query;
  turn(R_up, turned.graph, turned.cloud, turned.plan);
  for (Eigen::Isometry3d& T : turned.poses) T = R_up * T;
  return turned;
}

Query tiltedQuery(const Query& query, const Eigen::Quaterniond& R) {
  Query tilted = turnedQuery(query, R);
  tilted.plan = turnedPlan(tilted.plan, R);
  return tilted;
}

Query scaledQuery(const Query& query, double scale) {
  Query scaled = query;
  scaleLengths(scale, scaled);
  return scaled;
}

QueryInMap::QueryInMap(const Query& given, const LabelSet& map_labels, double map_size)
    : given_(given) {
  if (given.size != map_size && !given.plan.known.empty()) {
    throw Error("the query", fmt::format("it was made with lengths of size {0} and the map with "
                                         "those of size {1}; make it again with --size {1}",
                                         sizeText(given.size), sizeText(map_size)));
  }
  if (!(given.labels == map_labels)) {
    const LabelMatch match(given.labels, map_labels);
    if (!match.changesNothing() && !match.isHopeless()) changed_ = translated(given, match);
  }
  if (commonDetail(given.labels, map_labels) == Detail::one_ground) {
    if (!changed_) changed_ = given;
    mergeGround(changed_->plan);
  }
  if (map_size != kTown) changed_ = scaledQuery(**this, 1 / map_size);
}

GuessedQuery::GuessedQuery(const Query& given, const FrameGuess& guess) : given_(given) {
  if (guess.scale != 1) changed_ = scaledQuery(given, guess.scale);
  if (isTurn(guess.R_up)) changed_ = turnedQuery(**this, guess.R_up);
}

Eigen::Vector3d middleOf(const Query& query) {
  if (query.graph.empty()) return query.poses.back().translation();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Vertex& v : query.graph.vertices) sum += v.position;
  return sum / static_cast<double>(query.graph.size());
}

std::optional<Query> seenFromItsCentre(const Query& query) {
  if (query.sensor != Sensor::cloud || query.poses.size() != 1 || query.graph.empty())
    return std::nullopt;
  if (boxOf(query).contains(query.poses[0].translation().head<2>())) return std::nullopt;
  Query centred = query;
  centred.poses = {Eigen::Isometry3d(Eigen::Translation3d(middleOf(query)))};
  return centred;
}

std::vector<double> scalesIn(const ScaleRange& range) {
  const double ratio = range.high / range.low;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::log(ratio) / kScaleStep)));
  std::vector<double> scales;
  for (int i = 0; i <= steps; ++i)
    scales.push_back(range.low * std::pow(ratio, static_cast<double>(i) / steps));
  return scales;
}

Matrix6d movedCovariance(const Matrix6d& covariance, const Eigen::Vector3d& p_map,
                         const Eigen::Vector3d& to_map) {
  // d(to) = d(p) + d(theta) x (to - p)
  const Eigen::Vector3d v = to_map - p_map;
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() << 0, v.z(), -v.y(), -v.z(), 0, v.x(), v.y(), -v.x(), 0;
  return J * covariance * J.transpose();
}

Eigen::Isometry3d alignedAbout(const Eigen::Vector3d& point, const Eigen::Isometry3d& T) {
  Eigen::Isometry3d aligned = poseFromYaw(Eigen::Vector3d::Zero(), yawOf(T.linear()));
  aligned.translation() = T * point - aligned.linear() * point;
  return aligned;
}

}  // namespace xview
