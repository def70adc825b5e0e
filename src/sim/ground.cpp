// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/ground.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "xview/sim/town_labels.h"

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
  const Eigen::Vector3d drop(0, 0, -drop_m);
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    addTriangle(mesh, polygon[0].p + drop, polygon[i - 1].p + drop, polygon[i].p + drop,
                {label, 0});
  }
}

class GroundBuilder {
 public:
  GroundBuilder(TriangleMesh& mesh, const Relief& relief, const StreetField& field)
      : mesh_(mesh), relief_(relief), field_(field) {}

  void addCell(int x, int y) {
    const double cell = Relief::kCell, half_diagonal = 0.75 * cell;
    const Eigen::Vector2d center((x + 0.5) * cell, (y + 0.5) * cell);
    const bool crossed = std::abs(field_.toRoad(center)) < half_diagonal ||
                         std::abs(field_.toSidewalk(center)) < half_diagonal;
    const int n = crossed ? kFine : 1;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) addSquare(x * n + i, y * n + j, cell / n);
    }
  }

 private:
  void addSquare(int x, int y, double size) {
    const GroundPoint a = point(x * size, y * size), b = point((x + 1) * size, y * size);
    const GroundPoint c = point((x + 1) * size, (y + 1) * size),
                      d = point(x * size, (y + 1) * size);
    addCutTriangle({a, b, c});
    addCutTriangle({a, c, d});
  }

  GroundPoint point(double x, double y) const {
    const Eigen::Vector2d p(x, y);
    return {{x, y, relief_.at(p)}, field_.toRoad(p), field_.toSidewalk(p)};
  }

  void addCutTriangle(const Polygon& triangle) {
    const Cut road = cutAlong(triangle, &GroundPoint::road);
    addPolygon(mesh_, road.inside, kCurb, town_class::kRoad);
    addCurb(road.edge);
    const Cut sidewalk = cutAlong(road.outside, &GroundPoint::sidewalk);
    addPolygon(mesh_, sidewalk.inside, 0, town_class::kSidewalk);
    addPolygon(mesh_, sidewalk.outside, 0, town_class::kTerrain);
  }

  void addCurb(const Polygon& edge) {
    if (edge.size() != 2) return;
    const Eigen::Vector3d drop(0, 0, -kCurb);
    addQuad(mesh_, edge[0].p, edge[1].p, edge[1].p + drop, edge[0].p + drop,
            {town_class::kSidewalk, 0});
  }

  TriangleMesh& mesh_;
  const Relief& relief_;
  const StreetField& field_;
};

/// Flat strips a little above the road.
class MarkingPainter {
 public:
  MarkingPainter(TriangleMesh& mesh, const Relief& relief, const StreetField& field)
      : mesh_(mesh), relief_(relief), field_(field) {}

  /// A strip along the line, `left_m` to its left.
  void paintAlong(const ArcLength& line, double from_m, double to_m, double left_m,
                  double width_m) {
    const int pieces = std::max(1, static_cast<int>(std::ceil((to_m - from_m) / 1.0)));
    for (int i = 0; i < pieces; ++i) {
      const PolylinePoint a = line.at(from_m + (to_m - from_m) * i / pieces);
      const PolylinePoint b = line.at(from_m + (to_m - from_m) * (i + 1) / pieces);
      paintQuad(a.position + (left_m - width_m / 2) * a.left(),
                b.position + (left_m - width_m / 2) * b.left(),
                b.position + (left_m + width_m / 2) * b.left(),
                a.position + (left_m + width_m / 2) * a.left());
    }
  }

 private:
  void paintQuad(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                 const Eigen::Vector2d& d) {
    if (field_.toRoad((a + c) / 2) > -0.4) return;
    addQuad(mesh_, lifted(a), lifted(b), lifted(c), lifted(d), {town_class::kLaneMarking, 0});
  }

  Eigen::Vector3d lifted(const Eigen::Vector2d& p) const {
    return {p.x(), p.y(), relief_.at(p) - kCurb + kMarkingLift};
  }

  TriangleMesh& mesh_;
  const Relief& relief_;
  const StreetField& field_;
};

void paintZebra(MarkingPainter& painter, const ArcLength& line, double at_m, double half_width_m) {
  for (double left = -half_width_m + 0.6; left < half_width_m - 0.3; left += 1.0) {
    painter.paintAlong(line, at_m, at_m + 2.5, left, 0.5);
  }
}

void paintStreet(MarkingPainter& painter, const Street& street, Random& random) {
  const ArcLength line(street.centreline);
  const double style = random.uniform(), phase = random.uniform(0, 3);
  const double dash = random.uniform(1.5, 3.5), period = dash + random.uniform(2, 5);
  const bool zebra_from = random.uniform() < 0.3, zebra_to = random.uniform() < 0.3;
  const double end = line.length() - 9;
  if (style < 0.6) {
    for (double s = 9 + phase; s + dash < end; s += period) {
      painter.paintAlong(line, s, s + dash, 0, 0.15);
    }
  } else if (style < 0.8) {
    painter.paintAlong(line, 9, end, 0, 0.15);
  }
  if (!street.isThrough() || line.length() < 40) return;
  if (zebra_from) paintZebra(painter, line, 10, street.half_width_m);
  if (zebra_to) paintZebra(painter, line, line.length() - 12, street.half_width_m);
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

double groundHeight(const Relief& relief, const StreetField& field, const Eigen::Vector2d& p) {
  return relief.at(p) - (field.toRoad(p) < 0 ? kCurb : 0);
}

void addGround(TriangleMesh& mesh, const Relief& relief, const StreetField& field,
               double margin_m) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m);
  const Eigen::Vector2d low = (field.bounds().min() - margin) / Relief::kCell;
  const Eigen::Vector2d high = (field.bounds().max() + margin) / Relief::kCell;
  GroundBuilder builder(mesh, relief, field);
  for (int y = static_cast<int>(std::floor(low.y())); y < high.y(); ++y) {
    for (int x = static_cast<int>(std::floor(low.x())); x < high.x(); ++x) builder.addCell(x, y);
  }
}

void addLaneMarkings(TriangleMesh& mesh, const StreetNetwork& network, const Relief& relief,
                     const StreetField& field, std::uint64_t seed) {
  MarkingPainter painter(mesh, relief, field);
  for (std::size_t i = 0; i < network.streets.size(); ++i) {
    Random random(seed ^ 0x4C41, i);
    paintStreet(painter, network.streets[i], random);
  }
}

}  // namespace xview
