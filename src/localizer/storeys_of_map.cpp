// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/storeys_of_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "localizer/proposer.h"
#include "localizer/query_in_map.h"
#include "map/contents.h"
#include "place/storeys.h"
#include "verdict/verdict.h"

namespace xview {
namespace {

constexpr double kSquare_m = 2;           ///< canonical
constexpr std::size_t kFewestPoses = 10;  ///< of a storey that somebody walked through
/// Of a map of which nobody knows what was seen through, what another floor scores elsewhere counts
/// as if this share of it were scored at the same pose in the plane.
constexpr double kElsewhere = 2. / 3;
const Eigen::Quaterniond kUpright = Eigen::Quaterniond::Identity();

bool wasWalkedThrough(const map::SemanticMap& map) { return map.poses.size() >= kFewestPoses; }

/// As if somebody had stood in squares of a storey that nobody walked through: how alike its places
/// are is asked there.
void standInSquares(StoreyOfMap& storey) {
  storey.key_frames.clear();
  const BevGrid& view = storey.map.bev;
  CellIndex squares;
  for (const GroundCell& cell : view.known) {
    if (!cell.measured) continue;
    const Eigen::Vector3d p((cell.x + 0.5) * view.cell_m, (cell.y + 0.5) * view.cell_m, cell.z);
    const std::size_t before = squares.size();
    squares.findOrAdd(floorToInt(p.x() / kSquare_m), floorToInt(p.y() / kSquare_m));
    if (squares.size() == before) continue;
    storey.map.addKeyframe(Eigen::Isometry3d(Eigen::Translation3d(
                               p + Eigen::Vector3d(view.origin_x, view.origin_y, view.origin_z))),
                           0, 0, 0);
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
    part.addKeyframe(map.poses[i], 0, 0, i < map.source_of_pose.size() ? map.source_of_pose[i] : 0);
    result.key_frames.push_back(i);
  }
  part.cloud = pointsIn(storey, map.cloud, kUpright);  // maps of rooms are not packed
  part.bev = viewOfThinned(part.cloud, part.labels, kUpright);
  if (!wasWalkedThrough(part)) standInSquares(result);
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
  if (!wasWalkedThrough(map)) {
    for (const search::PlaceHypothesis& place : found.places) {
      if (place.storey != best.storey)
        most = std::max(most, kElsewhere * place.score() / best.score());
    }
  }
  evidence.storeys = static_cast<double>(storeys.size());
  evidence.other_storey = most;
}

}  // namespace xview
