// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/query_in_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/label_match.h"
#include "base/pose.h"
#include "base/stray_points.h"
#include "localizer/query_check.h"
#include "map/contents.h"
#include "place/gravity.h"
#include "place/raw_recording.h"
#include "place/shapes.h"
#include "place/sound_input.h"
#include "search/likelihoods.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"
#include "xview/options.h"

namespace xview {
namespace {

bool isTurn(const Eigen::Quaterniond& R) {
  return R.angularDistance(Eigen::Quaterniond::Identity()) > 0;
}

template <class PlaceOrMap>
PlaceOrMap turned(PlaceOrMap place, const Eigen::Quaterniond& R) {
  for (Vertex& v : place.graph.vertices) v.position = R * v.position;
  const Eigen::Matrix3f R_float = R.toRotationMatrix().cast<float>();
  for (Point& p : place.cloud.points) p.getVector3fMap() = R_float * p.getVector3fMap();
  place.cloud.origin = R * place.cloud.origin;
  place.bev.alignment = place.bev.alignment * R.conjugate();
  for (Eigen::Isometry3d& T : place.poses) T = R * T;
  return place;
}

/// A BEV grid drawn in a turned frame, in which it is upright.
BevGrid turnedBev(const BevGrid& view, const Eigen::Quaterniond& R) {
  BevGrid turned = view;
  turned.alignment = Eigen::Quaterniond::Identity();
  const Eigen::Vector3d origin(view.origin_x, view.origin_y, view.origin_z);
  const auto toTurned = [&](double x, double y, double z) -> Eigen::Vector3d {
    return R * (origin + Eigen::Vector3d(x, y, z)) - origin;
  };
  for (auto& channel : turned.samples) {
    for (BevSample& s : channel) {
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

/// What the query shows, after a turn; of bare graphs the vertices.
Eigen::AlignedBox3d boxOf(const Query& query, const Eigen::Quaterniond& R) {
  const auto pointAt = [&](std::size_t i) -> Eigen::Vector3d {
    return R * query.cloud.position(i);
  };
  const auto vertexAt = [&](std::size_t i) -> Eigen::Vector3d {
    return R * query.graph.vertices[i].position;
  };
  Eigen::AlignedBox3d box = boxWithoutStrays(query.cloud.size(), pointAt);
  box.extend(boxWithoutStrays(query.graph.size(), vertexAt));
  return box;
}

/// Whether somebody who sees such a box may be at p: on it from above, and not higher or lower than
/// it by what it is high, or a fifth of what it is wide.
bool canBeSeenFrom(const Eigen::Vector3d& p, const Eigen::AlignedBox3d& box) {
  constexpr double kOfWidth = 0.2;
  const Eigen::Vector3d size = box.sizes();
  const double lever_m = std::max(size.z(), kOfWidth * size.head<2>().norm());
  const Eigen::Vector3d margin(0, 0, lever_m);
  return Eigen::AlignedBox3d(box.min() - margin, box.max() + margin).contains(p);
}

}  // namespace

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

Options optionsOfSearch(const Options& given, double size, const LabelSet& map_labels) {
  Options options = inCanonicalLengths(given, size);
  if (!options.places.likelihoods.empty()) return options;
  if (surroundingsOf(size) == search::Surroundings::rooms)
    options.places.likelihoods = search::kRooms;
  else if (knowsShapesOnly(map_labels))
    options.places.likelihoods = search::kShapes;
  return options;
}

std::optional<map::SemanticMap> gravityAlignedMap(const map::SemanticMap& map,
                                                  const Eigen::Quaterniond& R_up) {
  return isTurn(R_up) ? std::optional(turned(map::unpacked(map), R_up)) : std::nullopt;
}

Query turnedQuery(const Query& query, const Eigen::Quaterniond& R_up) {
  return turned(query, R_up);
}

Query tiltedQuery(const Query& query, const Eigen::Quaterniond& R) {
  Query tilted = turnedQuery(query, R);
  tilted.bev = turnedBev(tilted.bev, R);
  return tilted;
}

Query scaledQuery(const Query& query, double scale) {
  Query scaled = query;
  scaleLengths(scale, scaled);
  return scaled;
}

QueryInMap::QueryInMap(const Query& given, const LabelSet& map_labels, double map_size,
                       const ClassNames& names)
    : CopyOnChange(given) {
  requireSound(given);
  if (given.size != map_size && !given.bev.known.empty()) {
    throw Error("the query", fmt::format("it was made with lengths of size {0} and the map with "
                                         "those of size {1}; make it again with --size {1}",
                                         sizeText(given.size), sizeText(map_size)));
  }
  const map::CommonDetail detail = map::commonDetail(given.labels, map_labels);
  if (knowsShapesOnly(map_labels) && !knowsShapesOnly(given.labels)) {
    changed_ = given;
    map::reduceToShapes(map_labels, *changed_);
  } else if (!detail.shapes && !(given.labels == map_labels)) {
    const LabelMatch match(given.labels, map_labels, names);
    if (!match.isHopeless()) changed_ = translated(given, match);
  }
  if (!detail.isAll()) {
    if (!changed_) changed_ = given;
    map::reduceTo(detail, changed_->bev);
  }
  if (map_size != kTownScale) changed_ = scaledQuery(**this, 1 / map_size);
}

AlignedQuery::AlignedQuery(const Query& given, const FrameHypothesis& guess) : CopyOnChange(given) {
  if (guess.scale != 1) changed_ = scaledQuery(given, guess.scale);
  if (isTurn(guess.R_up)) changed_ = turnedQuery(**this, guess.R_up);
}

Eigen::Vector3d middleOf(const Query& query) {
  if (query.graph.empty()) return query.poses.back().translation();
  const std::vector<Vertex>& vertices = query.graph.vertices;
  const Eigen::AlignedBox3d box =
      boxWithoutStrays(vertices.size(), [&](std::size_t i) { return vertices[i].position; });
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Vertex& v : vertices) {
    if (!box.contains(v.position)) continue;
    sum += v.position;
    ++count;
  }
  return sum / count;
}

std::optional<Query> seenFromItsCentre(const Query& query) {
  if (query.sensor != Sensor::cloud || query.poses.size() != 1 || query.graph.empty())
    return std::nullopt;
  const Eigen::Quaterniond& R_up = query.gravity.alignment;
  if (canBeSeenFrom(R_up * query.poses[0].translation(), boxOf(query, R_up))) return std::nullopt;
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

Eigen::Isometry3d alignedAbout(const Eigen::Vector3d& point, const Eigen::Isometry3d& T) {
  Eigen::Isometry3d aligned = poseFromYaw(Eigen::Vector3d::Zero(), yawOf(T.linear()));
  aligned.translation() = T * point - aligned.linear() * point;
  return aligned;
}

Gravity gravityOf(const map::SemanticMap& map, const std::string& mode) {
  return map::hasView(map) ? gravityOf(map.bev)
                           : gravityOf(map::allVertices(map), map.labels, mode);
}

}  // namespace xview
