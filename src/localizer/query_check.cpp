// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/query_check.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/label_match.h"
#include "base/pose.h"
#include "base/stray_points.h"
#include "base/user_text.h"
#include "map/contents.h"
#include "place/sound_input.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"

namespace xview {
namespace {

constexpr const char* kNothingIsLeft =
    "nothing of the query is left to be found: it is empty, or all of it is unlabelled or out of "
    "range";

bool isEmpty(const Place& place) {
  return place.graph.empty() && place.bev.sampleCount() == 0 && place.cloud.empty();
}

/// Some names of a set, for a message.
std::string namesIn(const LabelSet& labels) {
  constexpr std::size_t kMost = 4;
  std::string names;
  std::size_t count = 0;
  for (const auto& [id, info] : labels.classes()) {
    if (info.role == Role::ignored || ++count > kMost) continue;
    names += (names.empty() ? "" : ", ") + info.name;
  }
  return count > kMost ? names + ", ..." : names;
}

std::optional<std::string> whyClassesDiffer(const LabelSet& query, const LabelSet& map) {
  if (query == map || !LabelMatch(query, map).isHopeless()) return std::nullopt;
  if (query.isGeneric() != map.isGeneric()) {
    return fmt::format(
        "the classes of the {} have no names and the shapes of its points do not tell them, so "
        "they cannot meet those of the {} ({}); name them with {} SET or a classes.yaml beside "
        "the file, or leave them aside with `--labels shapes`",
        query.isGeneric() ? "query" : "map", query.isGeneric() ? "map" : "query",
        namesIn(query.isGeneric() ? map : query), query.isGeneric() ? "--labels" : "--map-labels");
  }
  return fmt::format(
      "query and map have no class in common ({} against {}); if they mean the same, "
      "say so with --class-names",
      namesIn(query), namesIn(map));
}

Eigen::AlignedBox2d fromAbove(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return {};
  return {box.min().head<2>(), box.max().head<2>()};
}

/// What of a map is anywhere, from above [m].
Eigen::AlignedBox2d boundsOf(const map::SemanticMap& map) {
  Eigen::AlignedBox2d box = fromAbove(map::allVertices(map).bounds());
  for (const Eigen::Isometry3d& T : map.poses) box.extend(T.translation().head<2>());
  for (const GroundCell& cell : map::viewOf(map).known) {
    box.extend(Eigen::Vector2d(map.bev.origin_x + cell.x * map.bev.cell_m,
                               map.bev.origin_y + cell.y * map.bev.cell_m));
  }
  return box;
}

/// Less than any place can be told by. A bare graph may have few vertices.
std::optional<std::string> whyTooLittle(const Query& query) {
  constexpr std::size_t kFewestSamples = 30, kFewestVertices = 4, kFewestPoints = 500;
  if (query.bev.known.empty() && query.cloud.empty()) return std::nullopt;
  if (query.bev.sampleCount() >= kFewestSamples || query.graph.size() >= kFewestVertices ||
      query.cloud.size() >= kFewestPoints)
    return std::nullopt;
  return fmt::format(
      "the query is too little to tell one place from another: {} points after "
      "thinning and {} vertices; use more of the recording (longer --window), or a "
      "denser cloud",
      query.cloud.size(), query.graph.size());
}

/// In the upright frame of the cells, in which z is no matter.
void extendBy(const Place& place, Eigen::AlignedBox2d& box) {
  const Eigen::Matrix3d R_bev = place.bev.alignment.toRotationMatrix();
  const Eigen::Vector3d origin(place.bev.origin_x, place.bev.origin_y, 0);
  const auto vertexAt = [&](std::size_t i) -> Eigen::Vector3d {
    const Eigen::Vector3d p = R_bev * place.graph.vertices[i].position;
    return {p.x(), p.y(), 0};
  };
  const auto cellAt = [&](std::size_t i) -> Eigen::Vector3d {
    const GroundCell& cell = place.bev.known[i];
    return origin + Eigen::Vector3d(cell.x, cell.y, 0) * place.bev.cell_m;
  };
  box.extend(fromAbove(boxWithoutStrays(place.graph.size(), vertexAt)));
  box.extend(fromAbove(boxWithoutStrays(place.bev.known.size(), cellAt)));
}

double widthOf(const Eigen::AlignedBox2d& box) { return box.isEmpty() ? 0 : box.diagonal().norm(); }

/// From above; not from where it was seen, which may be the origin of a country.
double widthOf(const Place& place) {
  Eigen::AlignedBox2d box;
  extendBy(place, box);
  return widthOf(box);
}

/// A stored view is as wide as its columns, and its vertices stand in them.
double widthOf(const map::SemanticMap& map) {
  Eigen::AlignedBox2d box;
  if (!map.stored_view) {
    box = fromAbove(map::allVertices(map).bounds());
    extendBy(map, box);
    return widthOf(box);
  }
  for (const PlaneCell& column : map.stored_view->columns()) {
    for (const int corner : {0, 1})
      box.extend(StoredView::kColumn_m * Eigen::Vector2d(column.x + corner, column.y + corner));
  }
  return widthOf(box);
}

/// So much wider than the map that next to nothing of it can lie there.
std::optional<std::string> whyTooLarge(const Query& query, const map::SemanticMap& map) {
  constexpr double kTooLarge = 10;
  const double query_m = widthOf(query), map_m = widthOf(map);
  if (map_m <= 0 || query_m <= kTooLarge * map_m) return std::nullopt;
  return fmt::format(
      "the query is {:.4g} m wide and the map {:.3g} m, so that it cannot lie in it; are the "
      "lengths of the query metres, and not millimetres or centimetres?",
      query_m * map.size, map_m * map.size);
}

}  // namespace

std::optional<std::string> whyUnfindable(const Query& query, const map::SemanticMap& map) {
  const map::Counts in_map = map::countsOf(map);
  if (isEmpty(map) && !map::hasView(map) && in_map.points == 0 && in_map.vertices == 0)
    return "the map is empty; build it of a recording that sees something";
  if (isEmpty(query)) return kNothingIsLeft;
  if (const auto reason = whyTooLittle(query)) return reason;
  if (const auto reason = whyTooLarge(query, map)) return reason;
  return whyClassesDiffer(query.labels, map.labels);
}

void requireSound(const ExpectedPose& expected, double size) {
  requireNear("the expected T_map_query", expected.T_map_query, size);
  if (!(expected.radius_m >= 0 && std::isfinite(expected.radius_m)))
    throw UsageError(fmt::format("radius_m = {}, must be >= 0 and finite", expected.radius_m));
  if (!(expected.yaw_rad >= 0 && std::isfinite(expected.yaw_rad)))
    throw UsageError(fmt::format("yaw_rad = {}, must be >= 0 and finite", expected.yaw_rad));
}

void requireAnswerTo(const Query& query, const map::SemanticMap& map, const Localization& answer) {
  if (!(answer.scale > 0 && std::isfinite(answer.scale)))
    throw UsageError(fmt::format("the scale of the answer is {}, must be > 0", answer.scale));
  const std::size_t in_map = map::countsOf(map).vertices;
  for (const Correspondence& pair : answer.kept) {
    if (pair.query >= query.graph.size() || pair.map >= in_map)
      throw UsageError("the answer is to another query: it pairs vertices that there are not");
  }
}

/// A sensor may stand outside of what it sees, but not by more than half of a map, nor by more than
/// it sees.
void requirePriorInside(const PlacePrior& prior, const map::SemanticMap& map) {
  if (!prior.near) return;
  const double sight_m = 50 * map.size;
  const Eigen::AlignedBox2d box = boundsOf(map);
  if (box.isEmpty()) return;
  const double outside_m = box.exteriorDistance(Eigen::Vector2d(prior.near->x, prior.near->y));
  const double reach_m = std::min(sight_m, 0.5 * box.diagonal().norm());
  if (outside_m <= prior.near->radius + reach_m) return;
  throw UsageError(fmt::format(
      "the prior is outside of the map: x {:.1f}, y {:.1f} within {:.1f} m, but the map has x "
      "{:.1f} .. {:.1f}, y {:.1f} .. {:.1f}; give it in the frame of the map or leave it out",
      prior.near->x, prior.near->y, prior.near->radius, box.min().x(), box.max().x(), box.min().y(),
      box.max().y()));
}

PlacePrior parsePrior(const PriorOptions& options) {
  PlacePrior prior;
  if (!options.near.empty()) prior.near = parseCircle("prior.near", options.near);
  if (!options.yaw.empty()) prior.heading = parseHeading("prior.yaw", options.yaw);
  return prior;
}

PlacePrior priorAround(const ExpectedPose& expected, const Query& query) {
  const Eigen::Isometry3d pose = expected.T_map_query * query.poses.back();
  return {PlacePrior::Circle{pose.translation().x(), pose.translation().y(), expected.radius_m},
          PlacePrior::Heading{headingOf(pose.linear(), query.sensor), expected.yaw_rad}};
}

Priors ofQueryFrame(Priors priors, const Query& query) {
  const double of_sensor = headingOf(query.poses.back().linear(), query.sensor);
  for (PlacePrior& p : priors) {
    if (p.heading) p.heading->yaw = angleDifference(p.heading->yaw, of_sensor);
  }
  return priors;
}

bool sayAnything(const Priors& priors) {
  return std::any_of(priors.begin(), priors.end(),
                     [](const PlacePrior& p) { return p.near || p.heading; });
}
bool satisfies(const Priors& priors, Sensor sensor, const Eigen::Isometry3d& T_map_sensor) {
  const Eigen::Vector3d position = T_map_sensor.translation();
  const double heading = headingOf(T_map_sensor.linear(), sensor);
  return std::all_of(priors.begin(), priors.end(), [&](const PlacePrior& p) {
    const bool is_near =
        !p.near || std::hypot(position.x() - p.near->x, position.y() - p.near->y) <= p.near->radius;
    return is_near && (!p.heading ||
                       std::abs(angleDifference(heading, p.heading->yaw)) <= p.heading->tolerance);
  });
}

}  // namespace xview
