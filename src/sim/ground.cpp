// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <vector>

#include "building.h"

namespace xview {
namespace {

constexpr int kFine = 4;  // fine cells along a side of a relief cell that an edge crosses
constexpr double kMarkingLift = 0.02;  // above the road [m]

/// A corner of the ground with its distances to the edges that will cut it.
struct GroundPoint {
  Eigen::Vector3d p;
  double road, sidewalk;
};

using Polygon = std::vector<GroundPoint>;

/// Where the distance changes sign between two corners; the same point for (a, b) and (b, a).
GroundPoint crossing(const GroundPoint& a, const GroundPoint& b, double GroundPoint::*distance) {
  const bool swapped = a.p.x() > b.p.x() || (a.p.x() == b.p.x() && a.p.y() > b.p.y());
  const GroundPoint &first = swapped ? b : a, &second = swapped ? a : b;
  const double t = first.*distance / (first.*distance - second.*distance);
  return {first.p + t * (second.p - first.p), first.road + t * (second.road - first.road),
          first.sidewalk + t * (second.sidewalk - first.sidewalk)};
}

struct Cut {
  Polygon inside, outside;  ///< distance < 0, >= 0
  Polygon edge;             ///< the two crossings, or empty
};

Cut cutAlong(const Polygon& polygon, double GroundPoint::*distance) {
  Cut cut;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const GroundPoint &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const bool a_inside = a.*distance < 0, b_inside = b.*distance < 0;
    (a_inside ? cut.inside : cut.outside).push_back(a);
    if (a_inside == b_inside) continue;
    const GroundPoint c = crossing(a, b, distance);
    cut.inside.push_back(c);
    cut.outside.push_back(c);
    cut.edge.push_back(c);
  }
  return cut;
}

void addPolygon(TriangleMesh& mesh, const Polygon& polygon, double drop_m, std::uint16_t label) {
  const Eigen::Vector3d drop = up(-drop_m);
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    addTriangle(mesh, polygon[0].p + drop, polygon[i - 1].p + drop, polygon[i].p + drop,
                {label, 0});
  }
}

/// One triangle of the relief, cut into road, sidewalk and terrain.
void addCutTriangle(TriangleMesh& mesh, const Polygon& triangle) {
  const Cut road = cutAlong(triangle, &GroundPoint::road);
  addPolygon(mesh, road.inside, kCurb, town_class::kRoad);
  if (road.edge.size() == 2) {
    const Eigen::Vector3d &a = road.edge[0].p, &b = road.edge[1].p;
    addQuad(mesh, a, b, b - up(kCurb), a - up(kCurb), {town_class::kSidewalk, 0});
  }
  const Cut sidewalk = cutAlong(road.outside, &GroundPoint::sidewalk);
  addPolygon(mesh, sidewalk.inside, 0, town_class::kSidewalk);
  addPolygon(mesh, sidewalk.outside, 0, town_class::kTerrain);
}

void addGroundCell(Town& town, int x, int y) {
  const double cell = Relief::kCell, half_diagonal = 0.75 * cell;
  const Eigen::Vector2d center((x + 0.5) * cell, (y + 0.5) * cell);
  const bool crossed = std::abs(town.field.toRoad(center)) < half_diagonal ||
                       std::abs(town.field.toSidewalk(center)) < half_diagonal;
  const int n = crossed ? kFine : 1;
  const auto point = [&](int i, int j) -> GroundPoint {
    const Eigen::Vector2d p = cell / n * Eigen::Vector2d(x * n + i, y * n + j);
    return {{p.x(), p.y(), town.relief.at(p)}, town.field.toRoad(p), town.field.toSidewalk(p)};
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const GroundPoint a = point(i, j), c = point(i + 1, j + 1);
      addCutTriangle(town.mesh, {a, point(i + 1, j), c});
      addCutTriangle(town.mesh, {a, c, point(i, j + 1)});
    }
  }
}

/// A flat strip a little above the road, along the line, `left_m` to its left.
void paintAlong(Town& town, const ArcLength& line, double from_m, double to_m, double left_m,
                double width_m) {
  const int pieces = std::max(1, static_cast<int>(std::ceil((to_m - from_m) / 1.0)));
  const auto lifted = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector3d(p.x(), p.y(), town.relief.at(p) - kCurb + kMarkingLift);
  };
  for (int i = 0; i < pieces; ++i) {
    const PolylinePoint p = line.at(from_m + (to_m - from_m) * i / pieces);
    const PolylinePoint q = line.at(from_m + (to_m - from_m) * (i + 1) / pieces);
    const Eigen::Vector2d a = p.position + (left_m - width_m / 2) * p.left();
    const Eigen::Vector2d b = q.position + (left_m - width_m / 2) * q.left();
    const Eigen::Vector2d c = q.position + (left_m + width_m / 2) * q.left();
    const Eigen::Vector2d d = p.position + (left_m + width_m / 2) * p.left();
    if (town.field.toRoad((a + c) / 2) > -0.4) continue;
    addQuad(town.mesh, lifted(a), lifted(b), lifted(c), lifted(d), {town_class::kLaneMarking, 0});
  }
}

void paintZebra(Town& town, const ArcLength& line, double at_m, double half_width_m) {
  for (double left = -half_width_m + 0.6; left < half_width_m - 0.3; left += 1.0) {
    paintAlong(town, line, at_m, at_m + 2.5, left, 0.5);
  }
}

void paintStreet(Town& town, const Street& street, Random& random) {
  const ArcLength line(street.centreline);
  const double style = random.uniform(), phase = random.uniform(0, 3);
  const double dash = random.uniform(1.5, 3.5), period = dash + random.uniform(2, 5);
  const bool zebra_from = random.uniform() < 0.3, zebra_to = random.uniform() < 0.3;
  const double end = line.length() - 9;
  if (style < 0.6) {
    for (double s = 9 + phase; s + dash < end; s += period) {
      paintAlong(town, line, s, s + dash, 0, 0.15);
    }
  } else if (style < 0.8) {
    paintAlong(town, line, 9, end, 0, 0.15);
  }
  if (!street.isThrough() || line.length() < 40) return;
  if (zebra_from) paintZebra(town, line, 10, street.half_width_m);
  if (zebra_to) paintZebra(town, line, line.length() - 12, street.half_width_m);
}

}  // namespace

Relief::Relief(std::uint64_t seed, double amplitude_m) {
  Random random(seed, 2);
  for (Wave& wave : waves_) {
    const double direction = random.uniform(0, 2 * M_PI);
    const double length = random.uniform(150, 500);
    wave.number = 2 * M_PI / length * Eigen::Vector2d(std::cos(direction), std::sin(direction));
    wave.phase = random.uniform(0, 2 * M_PI);
    wave.amplitude_m = amplitude_m / static_cast<double>(waves_.size());
  }
}

double Relief::smooth(const Eigen::Vector2d& p) const {
  double height = 0;
  for (const Wave& wave : waves_)
    height += wave.amplitude_m * std::sin(wave.number.dot(p) + wave.phase);
  return height;
}

double Relief::at(const Eigen::Vector2d& p) const {
  const double x = std::floor(p.x() / kCell), y = std::floor(p.y() / kCell);
  const double u = p.x() / kCell - x, v = p.y() / kCell - y;
  const auto corner = [&](double i, double j) {
    return smooth({(x + i) * kCell, (y + j) * kCell});
  };
  const double low = corner(0, 0), high = corner(1, 1);
  if (u >= v) {
    const double side = corner(1, 0);
    return low + u * (side - low) + v * (high - side);
  }
  const double side = corner(0, 1);
  return low + v * (side - low) + u * (high - side);
}

void addGround(Town& town, double margin_m) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m);
  const Eigen::Vector2d low = (town.field.bounds().min() - margin) / Relief::kCell;
  const Eigen::Vector2d high = (town.field.bounds().max() + margin) / Relief::kCell;
  for (int y = static_cast<int>(std::floor(low.y())); y < high.y(); ++y) {
    for (int x = static_cast<int>(std::floor(low.x())); x < high.x(); ++x) {
      addGroundCell(town, x, y);
    }
  }
}

void addLaneMarkings(Town& town) {
  for (std::size_t i = 0; i < town.network.streets.size(); ++i) {
    Random random = town.randomOfStreet(0x4C41, i);
    paintStreet(town, town.network.streets[i], random);
  }
}

}  // namespace xview
