// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/storeys_of_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "localizer/proposer.h"
#include "localizer/query_in_map.h"
#include "map/contents.h"
#include "place/storeys.h"
#include "verdict/verdict.h"

namespace xview {
namespace {

constexpr double kSquare_m = 2;           ///< canonical
constexpr double kStep = 2.5;             ///< squares; what is farther off is another walk
constexpr std::size_t kFewestPoses = 10;  ///< of a storey that somebody walked through
/// Of a map of which nobody knows what was seen through, what another floor scores elsewhere counts
/// as if this share of it were scored at the same pose in the plane.
constexpr double kElsewhere = 2. / 3;
const Eigen::Quaterniond kUpright = Eigen::Quaterniond::Identity();

/// Whether somebody walked where poses of a map are: clouds and stations are a recording each.
bool isWalk(const map::SemanticMap& map, const std::vector<std::size_t>& poses) {
  std::size_t steps = 0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    steps += poses[i] == poses[i - 1] + 1 && sourceOf(map, poses[i]) == sourceOf(map, poses[i - 1]);
  return steps + 1 >= kFewestPoses;
}

/// From each square to the nearest one that is left.
std::vector<std::size_t> walkOver(const CellIndex& squares) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> walk, left(squares.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<char> is_left(squares.size(), true);
  std::size_t next = left.empty() ? kNone : 0;
  while (next != kNone) {
    walk.push_back(next);
    is_left[next] = false;
    const PlaneCell at = squares.cells()[next];
    next = kNone;
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    const auto ask = [&](std::size_t i) {
      const std::int64_t x = squares.cells()[i].x - at.x, y = squares.cells()[i].y - at.y;
      if (!is_left[i] || x * x + y * y >= least) return;
      least = x * x + y * y;
      next = i;
    };
    squares.forAround(walk.back(), 1, [&](std::int32_t i) { ask(static_cast<std::size_t>(i)); });
    if (next != kNone) continue;
    left.erase(std::remove_if(left.begin(), left.end(), [&](auto i) { return !is_left[i]; }),
               left.end());
    for (const std::size_t i : left) ask(i);
  }
  return walk;
}

/// As if somebody had walked over the squares of a storey that nobody walked through: how alike its
/// places are is asked there.
void standInSquares(StoreyOfMap& storey) {
  storey.key_frames.clear();
  const BevGrid& view = storey.map.bev;
  const Eigen::Vector3d origin(view.origin_x, view.origin_y, view.origin_z);
  CellIndex squares;
  std::vector<Eigen::Vector3d> positions;
  for (const GroundCell& cell : view.known) {
    if (!cell.measured) continue;
    const Eigen::Vector3d p((cell.x + 0.5) * view.cell_m, (cell.y + 0.5) * view.cell_m, cell.z);
    squares.findOrAdd(floorToInt(p.x() / kSquare_m), floorToInt(p.y() / kSquare_m));
    if (squares.size() > positions.size()) positions.push_back(origin + p);
  }
  std::uint32_t walk = 0;
  const PlaneCell* last = nullptr;
  for (const std::size_t i : walkOver(squares)) {
    const PlaneCell& square = squares.cells()[i];
    walk += last && std::hypot(square.x - last->x, square.y - last->y) > kStep;
    storey.map.addKeyframe(Eigen::Isometry3d(Eigen::Translation3d(positions[i])), 0, 0, walk);
    last = &square;
  }
}

StoreyOfMap partOf(const map::SemanticMap& map, const Storey& storey) {
  StoreyOfMap result;
  result.bottom = storey.bottom;
  map::SemanticMap& part = result.map;
  part.labels = map.labels;
  part.size = map.size;
  part.gravity = map.gravity;
  part.sensor = map.sensor;
  part.sources = map.sources;
  part.graph.space = map.graph.space;
  part.graph.edge_radius_m = map.graph.edge_radius_m;
  for (const Vertex& vertex : map.graph.vertices) {
    if (storey.holds(vertex.position.z())) part.graph.vertices.push_back(vertex);
  }
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    if (!storey.holds(map.poses[i].translation().z())) continue;
    part.addKeyframe(map.poses[i], 0, 0, sourceOf(map, i));
    result.key_frames.push_back(i);
  }
  part.cloud = pointsIn(storey, map.cloud, kUpright);  // maps of rooms are not packed
  part.bev = viewOfThinned(part.cloud, part.labels, kUpright);
  if (!isWalk(map, result.key_frames)) standInSquares(result);
  return result;
}

std::unique_ptr<const search::Field> fieldOf(const search::MapView& view,
                                             const map::SemanticMap& map,
                                             const search::PathNull& known,
                                             const Options& options) {
  std::vector<Eigen::Vector3d> path;
  for (const Eigen::Isometry3d& T : map.poses) path.push_back(T.translation());
  return search::makeSurfaceField(view, path, surroundingsOf(map.size), known, options.places,
                                  options.threads);
}

}  // namespace

std::vector<StoreyOfMap> storeysOf(const map::SemanticMap& upright) {
  StoreyFinder finder(upright.poses, kUpright, upright.size);
  std::vector<StoreyOfMap> parts;
  if (upright.bev.aerial) return parts;
  finder.add(upright.cloud, upright.labels);
  for (const Storey& storey : finder.storeys()) parts.push_back(partOf(upright, storey));
  return parts;
}

std::unique_ptr<const search::Field> surfaceFieldOf(const map::SemanticMap& upright,
                                                    const Options& options,
                                                    const map::CommonDetail& detail) {
  std::vector<StoreyOfMap> storeys = storeysOf(upright);
  if (storeys.empty()) return fieldOf(map::searchedView(upright), upright, upright.null, options);
  std::vector<search::FieldAbove> fields;
  for (StoreyOfMap& storey : storeys) {
    map::reduceTo(detail, storey.map.bev);
    auto view = std::make_shared<const BevGrid>(std::move(storey.map.bev));
    fields.push_back({storey.bottom, fieldOf(*view, storey.map, {}, options), view});
  }
  return search::makeStackedField(std::move(fields));
}

double heightBetween(const std::vector<search::PlaceHypothesis>& places) {
  return places[0].T_map_query.translation().z() - places[1].T_map_query.translation().z();
}

void keepStoreyOf(const Eigen::Isometry3d& T_expected, Candidates& found) {
  if (!found.in_field || found.in_field->storeys().size() == 1) return;
  const int storey = found.in_field->at(T_expected).storey();
  std::vector<search::PlaceHypothesis>& places = found.places;
  places.erase(std::remove_if(places.begin(), places.end(),
                              [&](const auto& place) { return place.storey != storey; }),
               places.end());
  found.to_register = countClose(places);
}

void tellStoreys(const Candidates& found, double size, Localization& answer) {
  const std::vector<search::PlaceHypothesis>& places = found.places;
  if (places.size() < 2 || places[0].storey == places[1].storey) return;
  answer.reason +=
      fmt::format("; floors {} and {} of {}, {:.1f} m apart in height", 1 + places[0].storey,
                  1 + places[1].storey, found.in_field->storeys().size(),
                  size * std::abs(heightBetween(places)));
}

void addStoreys(const Candidates& found, const map::SemanticMap& map, verdict::Evidence& evidence) {
  if (!found.in_field || found.places.empty()) return;
  const search::PlaceHypothesis& best = found.places[0];
  const std::vector<const search::FieldQuery*> storeys = found.in_field->storeys();
  if (storeys.size() == 1 || !(best.score() > 0)) return;
  double most = 0;
  for (const search::FieldQuery* storey : storeys) {
    if (storey->storey() == best.storey) continue;
    const PlacePose there =
        storey->refineLocally(storey->centrePose(best.T_map_query), search::RefinementLevel::fine);
    most = std::max(most, there.score / best.score());
  }
  std::vector<std::vector<std::size_t>> poses(storeys.size());
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    const Eigen::Vector3d p = map.poses[i].translation() - found.in_field->focus();
    const search::FieldQuery& there =
        found.in_field->at(Eigen::Isometry3d(Eigen::Translation3d(p)));
    poses[static_cast<std::size_t>(there.storey())].push_back(i);
  }
  for (const search::PlaceHypothesis& place : found.places) {
    if (place.storey != best.storey && !isWalk(map, poses[static_cast<std::size_t>(place.storey)]))
      most = std::max(most, kElsewhere * place.score() / best.score());
  }
  evidence.storeys = static_cast<double>(storeys.size());
  evidence.other_storey = most;
}

}  // namespace xview
