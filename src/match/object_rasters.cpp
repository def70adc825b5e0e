// SPDX-License-Identifier: BSD-3-Clause
#include "object_rasters.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr double kFarthest = 10;  // squared Mahalanobis distance beyond which nothing is stamped
constexpr double kLeastShare =
    0.3;  // of the weight of a surface: what does not tell places apart still tells where they are
constexpr double kHeadingBlur = 0.5;  // [m^2] the pose is known to half a yaw step only

/// A Gaussian around a map point.
struct Stamp {
  double along, across;  // standard deviations [m]
  double log_gain;
  double weight;
};

class Stamper {
 public:
  Stamper(LikelihoodRaster& raster, const MapPoint& point) : raster_(raster), point_(point) {}

  void raise(std::uint16_t slot, const Stamp& stamp) {
    const double cell = raster_.cellSize();
    const double dx = directed() ? point_.tangent_x : 1, dy = directed() ? point_.tangent_y : 0;
    const double reach = std::sqrt(kFarthest) * std::max(stamp.along, stamp.across);
    const auto first = [&](double v) {
      return static_cast<std::int32_t>(std::floor((v - reach) / cell));
    };
    const auto last = [&](double v) {
      return static_cast<std::int32_t>(std::floor((v + reach) / cell));
    };
    for (std::int32_t cy = first(point_.y); cy <= last(point_.y); ++cy) {
      for (std::int32_t cx = first(point_.x); cx <= last(point_.x); ++cx) {
        const double ex = (cx + 0.5) * cell - point_.x, ey = (cy + 0.5) * cell - point_.y;
        const double u = (ex * dx + ey * dy) / stamp.along, v = (-ex * dy + ey * dx) / stamp.across;
        const double distance2 = u * u + v * v;
        if (distance2 > kFarthest) continue;
        const double nats = stamp.weight * softplus(stamp.log_gain - 0.5 * distance2);
        const int value =
            std::min(kHighestRasterValue, static_cast<int>(kRasterStepsPerNat * nats + 0.5));
        if (value > 0) raster_.raise(slot, cx, cy, static_cast<std::uint8_t>(value));
      }
    }
  }

  bool directed() const { return point_.tangent_x != 0 || point_.tangent_y != 0; }

 private:
  LikelihoodRaster& raster_;
  const MapPoint point_;
};

/// So far to the left of the surface.
MapPoint shifted(MapPoint p, double metres) {
  p.x -= static_cast<float>(metres) * p.tangent_y;
  p.y += static_cast<float>(metres) * p.tangent_x;
  return p;
}

/// Where a query vertex falls within its cell is unknown, which adds to the variance.
Stamp widened(const ObjectClass& model, bool directed, double across_m, double cell_m) {
  const double blur = cell_m * cell_m / 6 + kHeadingBlur;
  const double along = std::sqrt(model.along_m * model.along_m + blur);
  // The samples of the query are as far apart as a cell at least, see ObjectQuery::samples.
  const double weight = model.is_surface
                            ? std::min(1.0, std::max(model.spacing_m, cell_m) / kIndependentM) *
                                  std::max(kLeastShare, model.gain_weight)
                            : model.weight;
  if (!model.is_surface) return {along, along, 0, weight};
  if (!directed) return {0.8 * along, 0.8 * along, 0, weight};
  return {along, std::sqrt(across_m * across_m + blur), 0, weight};
}

}  // namespace

LikelihoodRaster rasterizeObjects(const ObjectMap& map, const ObjectPlaceOptions& options,
                                  double cell_m) {
  LikelihoodRaster raster(cell_m, std::vector<std::uint8_t>(map.classes().size(), 0));
  for (const MapPoint& point : map.points()) {
    const ObjectClass& model = map.classes()[point.slot];
    Stamper stamper(raster, point);
    const auto raise = [&](Stamper& at, std::uint16_t slot, double across_m, double chance) {
      Stamp stamp = widened(model, at.directed(), across_m, cell_m);
      stamp.log_gain = std::log(chance) + logGain(map.classes()[slot], stamp.along * stamp.across,
                                                  map.logClutter(slot, point.x, point.y));
      at.raise(slot, stamp);
    };
    raise(stamper, point.slot, model.across_m, 1);
    if (model.kind == Kind::building && stamper.directed()) {
      for (const double side : {-1.0, 1.0}) {
        Stamper roof(raster, shifted(point, side * options.roof_offset_m));
        raise(roof, point.slot, options.roof_lateral_m, 0.5);
      }
    }
    for (const std::uint16_t partner : model.confused_with)
      raise(stamper, partner, model.across_m, options.confusion);
  }
  return raster;
}

}  // namespace xview
