// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "building.h"

namespace xview {
namespace {

constexpr double kCorner = 9;                      // no lot nearer to the end of a street [m]
constexpr double kPathHalfWidth = 1.35;            // of driveways [m]
constexpr double kAlikeLot = 17, kAlikeHall = 45;  // width of a lot where streets are alike [m]
constexpr double kBoundaryStep = 1.5;  // fences and hedges follow the ground in such pieces [m]

/// A fence, picket fence, hedge or wall.
struct Boundary {
  Tag tag;
  double thickness_m = 0, height_m = 0;  ///< 0: none
};

Boundary drawBoundary(Town& town, Random& random) {
  const double kind = random.uniform();
  if (kind < 0.22 || (town.options.lots == Lots::halls && random.uniform() < 0.85)) return {};
  Boundary boundary;
  const bool is_hedge = kind >= 0.55 && kind < 0.88;
  if (kind < 0.42) {
    boundary.thickness_m = 0.08;
    boundary.height_m = random.uniform(1.2, 1.9);
  } else if (kind < 0.55) {
    boundary.thickness_m = 0.06;
    boundary.height_m = random.uniform(0.7, 1.1);
  } else if (is_hedge) {
    boundary.thickness_m = random.uniform(0.5, 1.1);
    boundary.height_m = random.uniform(0.7, 2.2);
  } else {
    boundary.thickness_m = 0.3;
    boundary.height_m = random.uniform(0.5, 1.2);
  }
  const std::uint16_t hedge =
      town.options.hedges_apart ? town_class::kHedge : town_class::kVegetation;
  boundary.tag = town.tags.next(is_hedge ? hedge : town_class::kFence);
  return boundary;
}

void addBoundaryPiece(Town& town, const Boundary& boundary, const Eigen::Vector2d& a,
                      const Eigen::Vector2d& b) {
  for (const Eigen::Vector2d& p : {a, Eigen::Vector2d((a + b) / 2), b}) {
    if (!town.isFree(p, 0.12, 0.2)) return;
  }
  const double yaw = std::atan2(b.y() - a.y(), b.x() - a.x());
  const Eigen::Vector3d base = town.onGround((a + b) / 2) - up(0.2);
  addBox(town.mesh, poseFromYaw(base, yaw),
         {(b - a).norm() + 0.02, boundary.thickness_m, boundary.height_m + 0.2}, boundary.tag);
}

/// From a to b in pieces; leaves gaps at ways and houses.
void addBoundary(Town& town, const Boundary& boundary, const Eigen::Vector2d& a,
                 const Eigen::Vector2d& b) {
  if (boundary.height_m <= 0) return;
  const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / kBoundaryStep)));
  for (int i = 0; i < pieces; ++i) {
    addBoundaryPiece(town, boundary, a + (b - a) * i / pieces, a + (b - a) * (i + 1) / pieces);
  }
}

/// One side of one street: lots along it. "out" is the direction away from the road.
class StreetSideBuilder {
 public:
  StreetSideBuilder(Town& town, const Street& street, double side, Random& random)
      : town_(town),
        street_(street),
        line_(street.centreline),
        side_(side),
        random_(random),
        edge_m_(street.half_width_m + street.sidewalk_m) {}

  void build(std::size_t street) {
    const bool is_row = random_.uniform() < town_.options.row_share;
    const HouseDesign row_design = draw();
    const double row_garden = random_.uniform(2.5, 6);
    const double row_width = row_design.extent().sizes().x() + random_.uniform(1.5, 4);
    std::uint64_t number = 0;
    for (double s = kCorner; s < line_.length() - kCorner - 6; ++number) {
      const bool like_others = followsPattern(street, number);
      Lot lot;
      lot.from_m = s;
      lot.house = is_row && !like_others ? row_design : draw();
      lot.garden_m = is_row ? row_garden : random_.uniform(2.5, 9) * (isCampus() ? 2 : 1);
      const double room = lot.house.extent().sizes().x();
      lot.to_m = s + (is_row ? row_width : room + random_.uniform(2, 10) * (isCampus() ? 2.5 : 1));
      if (town_.options.alike > 0) lot.to_m = s + (isCampus() ? kAlikeHall : kAlikeLot);
      lot.turn = is_row ? 0 : random_.uniform(-0.12, 0.12);
      buildLot(lot);
      s = lot.to_m;
    }
  }

 private:
  struct Lot {
    double from_m = 0, to_m = 0;  // along the street
    double garden_m = 5;          // between sidewalk and house
    double turn = 0;              // of the house against the street [rad]
    HouseDesign house;
    double depth_m() const { return garden_m + house.size.y() + 9; }
  };

  bool isCampus() const { return town_.options.lots == Lots::halls; }
  HouseDesign draw() { return isCampus() ? drawHall(random_) : drawHouse(random_); }

  /// Decides it, if streets are alike at all; what is drawn for the lot then is its own, or the
  /// same as in all streets.
  bool followsPattern(std::size_t street, std::uint64_t number) {
    const TownOptions& options = town_.options;
    if (options.alike == 0) return false;
    const std::uint64_t lot = 2 * number + (side_ > 0 ? 1 : 0);
    random_ = Random(options.seed ^ 0x4F57, 1000 * street + lot);
    const bool follows = random_.uniform() < options.alike;
    if (follows) random_ = Random(options.pattern_seed ^ 0x5041, lot);
    return follows;
  }

  Eigen::Vector2d at(double along_m, double out_m) const {
    const PolylinePoint p = line_.at(along_m);
    return p.position + side_ * out_m * p.left();
  }

  void buildLot(const Lot& lot) {
    if (random_.uniform() < town_.options.house_density) buildHouse(lot);
    buildFront(lot);
    buildSide(lot);
    plantGarden(lot);
  }

  void buildHouse(const Lot& lot) {
    const double middle = (lot.from_m + lot.to_m) / 2;
    const Eigen::AlignedBox2d extent = lot.house.extent();
    const double out = edge_m_ + lot.garden_m - extent.min().y();
    const Eigen::Vector2d away = side_ * line_.at(middle).left();
    const double yaw = std::atan2(away.y(), away.x()) - M_PI / 2 + lot.turn;
    const Eigen::Vector2d center =
        at(middle, out) - Eigen::Rotation2Dd(yaw) * Eigen::Vector2d(extent.center().x(), 0);
    Footprint footprint{center, yaw, extent.sizes()};
    footprint.center = footprint.toWorld(extent.center());
    if (!town_.hasRoomFor(footprint)) return;
    town_.houses.push_back(footprint);
    const Eigen::Vector3d base(center.x(), center.y(), town_.relief.at(center));
    addHouse(town_.mesh, poseFromYaw(base, yaw), lot.house, town_.tags.next(town_class::kBuilding));
    buildDriveway(lot, footprint, yaw);
  }

  void buildDriveway(const Lot& lot, const Footprint& footprint, double yaw) {
    if (!lot.house.has_garage && random_.uniform() < 0.5) return;
    const double x = lot.house.garage_side * (footprint.size.x() / 2 - 1.6);
    const Eigen::Vector2d door = footprint.toWorld({x, -footprint.size.y() / 2 + 0.5});
    const Eigen::Vector2d curb =
        footprint.toWorld({x, -footprint.size.y() / 2 - lot.garden_m - street_.sidewalk_m});
    town_.field.addPath(door, curb, kPathHalfWidth);
    if (lot.garden_m > 5) town_.parking.push_back({door + 0.45 * (curb - door), yaw + M_PI / 2});
  }

  void buildFront(const Lot& lot) {
    const Boundary boundary = drawBoundary(town_, random_);
    const double out = edge_m_ + 0.5 + random_.uniform(0, 0.4);
    for (double s = lot.from_m + 0.3; s + 0.5 < lot.to_m; s += 4) {
      addBoundary(town_, boundary, at(s, out), at(std::min(s + 4, lot.to_m - 0.2), out));
    }
  }

  void buildSide(const Lot& lot) {
    const Boundary side = drawBoundary(town_, random_);
    const double depth = edge_m_ + lot.depth_m() * random_.uniform(0.5, 1);
    addBoundary(town_, side, at(lot.to_m, edge_m_ + 0.8), at(lot.to_m, depth));
    if (random_.uniform() > 0.5) return;
    const Boundary back = drawBoundary(town_, random_);
    addBoundary(town_, back, at(lot.from_m, depth), at(lot.to_m, depth));
  }

  void plantGarden(const Lot& lot) {
    const auto somewhere = [&](double depth_m) {
      const double along = random_.uniform(lot.from_m, lot.to_m);
      return at(along, edge_m_ + random_.uniform(0.8, depth_m));
    };
    const auto trees = static_cast<int>(town_.options.tree_density * random_.uniform(0, 4.5));
    for (int i = 0; i < trees; ++i) {
      const Eigen::Vector2d p = somewhere(lot.depth_m() + 4);
      const TreeDesign design = drawTree(random_);
      if (!town_.isFree(p, 0.6, 0.7 * design.crown_radius_m)) continue;
      addTree(town_.mesh, town_.onGround(p), design, random_,
              town_.tags.next(town_class::kVegetation));
    }
    const auto bushes = static_cast<int>(town_.options.tree_density * random_.uniform(0, 3.5));
    for (int i = 0; i < bushes; ++i) {
      const Eigen::Vector2d p = somewhere(lot.garden_m + 2);
      const double radius = random_.uniform(0.35, 1.1);
      if (!town_.isFree(p, radius, 0.2)) continue;
      addBush(town_.mesh, town_.onGround(p), radius, random_,
              town_.tags.next(town_class::kVegetation));
    }
  }

  Town& town_;
  const Street& street_;
  ArcLength line_;
  double side_;
  Random& random_;
  double edge_m_;  // from the centre line to the outer edge of the sidewalk
};

void addShed(Town& town, const Eigen::Vector2d& p, Random& random) {
  const Footprint shed{p, random.uniform(0, M_PI), {random.uniform(2, 5), random.uniform(2, 4)}};
  if (!town.hasRoomFor(shed)) return;
  town.houses.push_back(shed);
  addBox(town.mesh, poseFromYaw(town.onGround(p) - up(0.4), shed.yaw),
         {shed.size.x(), shed.size.y(), random.uniform(2.4, 3.2)},
         town.tags.next(town_class::kBuilding));
}

}  // namespace

void addLots(Town& town) {
  for (std::size_t i = 0; i < town.network.streets.size(); ++i) {
    Random random = town.randomOfStreet(0x4C4F, i);
    for (const double side : {-1.0, 1.0}) {
      StreetSideBuilder(town, town.network.streets[i], side, random).build(i);
    }
  }
}

void addStreetTrees(Town& town) {
  for (std::size_t i = 0; i < town.network.streets.size(); ++i) {
    Random random = town.randomOfStreet(0x5354, i);
    if (random.uniform() > 0.35 * town.options.tree_density) continue;
    const Street& street = town.network.streets[i];
    const ArcLength line(street.centreline);
    const TreeDesign design = drawTree(random);
    const double side = random.uniform() < 0.5 ? -1 : 1, spacing = random.uniform(8, 14);
    const double out = street.half_width_m + street.sidewalk_m - 0.4;
    for (double s = random.uniform(8, 16); s < line.length() - 8; s += spacing) {
      const PolylinePoint p = line.at(s);
      const Eigen::Vector2d place = p.position + side * out * p.left();
      if (town.field.toRoad(place) < 0.6) continue;
      TreeDesign grown = design;
      grown.height_m *= random.uniform(0.85, 1.15);
      grown.trunk_m = std::max(design.trunk_m, 2.2);
      grown.crown_radius_m = std::min(design.crown_radius_m, 1.8);
      addTree(town.mesh, town.onGround(place), grown, random,
              town.tags.next(town_class::kVegetation));
    }
  }
}

void addWilderness(Town& town, double margin_m) {
  Random random(town.options.seed, 7);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m);
  const Eigen::AlignedBox2d area(town.field.bounds().min() - margin,
                                 town.field.bounds().max() + margin);
  const auto somewhere = [&] {
    const double x = random.uniform(area.min().x(), area.max().x());
    return Eigen::Vector2d(x, random.uniform(area.min().y(), area.max().y()));
  };
  const double hectares = area.sizes().prod() * 1e-4;
  for (int i = 0; i < 4 * hectares; ++i) addShed(town, somewhere(), random);
  for (int i = 0; i < 30 * hectares * town.options.tree_density; ++i) {
    const Eigen::Vector2d p = somewhere();
    const TreeDesign design = drawTree(random);
    if (!town.isFree(p, 2.5, design.crown_radius_m)) continue;
    addTree(town.mesh, town.onGround(p), design, random, town.tags.next(town_class::kVegetation));
  }
}

}  // namespace xview
