// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/town.h"

#include <cmath>

#include "xview/sim/option_check.h"
#include "xview/sim/street_furniture.h"

namespace xview {
namespace {

constexpr double kMargin = 90;  // ground and trees beyond the last street [m]

/// Parking places at the curb, half on the sidewalk.
std::vector<ParkingPlace> parkingAtCurbs(const StreetNetwork& network, const StreetField& field) {
  constexpr double kSpacing = 6.5, kFromEnd = 10;
  std::vector<ParkingPlace> places;
  for (const Street& street : network.streets) {
    const ArcLength line(street.centreline);
    for (const double side : {-1.0, 1.0}) {
      for (double s = kFromEnd; s < line.length() - kFromEnd; s += kSpacing) {
        const PolylinePoint p = line.at(s);
        const Eigen::Vector2d place = p.position + side * (street.half_width_m + 0.4) * p.left();
        if (field.toRoad(place) < -0.3) continue;
        const double yaw = std::atan2(p.direction.y(), p.direction.x());
        places.push_back({place, side < 0 ? yaw : yaw + M_PI});
      }
    }
  }
  return places;
}

}  // namespace

Town makeTown(const TownOptions& options) {
  TownOptions checked = options;
  visit(checked, OptionCheck("town."));
  StreetNetwork network = makeStreets(options);
  Site site(network, options.seed, options.relief_m);
  std::vector<ParkingPlace> parking = addLots(site, network, options);
  addStreetTrees(site, network, options);
  addWilderness(site, options, kMargin);
  addStreetFurniture(site, network, options.seed);
  addGround(site.mesh, site.relief, site.field, kMargin);
  addLaneMarkings(site.mesh, network, site.relief, site.field, options.seed);
  const std::vector<ParkingPlace> at_curbs = parkingAtCurbs(network, site.field);
  parking.insert(parking.end(), at_curbs.begin(), at_curbs.end());
  return {options,         std::move(network),   std::move(site.field),
          site.relief,     std::move(site.mesh), std::move(parking),
          site.tags.last()};
}

}  // namespace xview
