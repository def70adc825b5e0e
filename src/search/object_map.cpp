// SPDX-License-Identifier: BSD-3-Clause
#include "search/object_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "base/median.h"
#include "search/object_query.h"
#include "xview/base/error.h"

namespace xview::search {
namespace {

constexpr double kDensityCell = 16;  // [m]
constexpr double kDensityArea = 9 * kDensityCell * kDensityCell;
constexpr int kMostCounted = 1000;  // vertices of a class in 48 x 48 m; more are as good as that
constexpr double kLeastDensity =
    2e-4;  // [1/m^2] one in 70 x 70 m: rarer classes do not get more evidence
constexpr double kWidestSpacing =
    16;  // [m] surface classes with wider gaps are things in their own right
constexpr std::size_t kSpacingSamples = 2000;
constexpr double kDeviationPerMedian = 1.4826;    // of normal errors, per median size
constexpr double kAhead[] = {9, 13, 17, 21, 25};  // [m] where a surface may go on
constexpr double kGap = 1.5;                      // spacings without a sample are no end yet
constexpr double kAlone = 0.25;     // share of looks to both sides that find nothing, of a surface
                                    // whose pieces tell as much as objects do
constexpr double kMostAlone = 1.5;  // of the weight of an object
constexpr double kIndependentPieceM = 4;  // [m] spacing of samples that count in full
constexpr double kLeastElongation = 0.7;  // of the scatter of neighbours, to have a direction

/// Along the surface; within an area, which has no direction, both ways across.
std::vector<Eigen::Vector2d> directionsOf(const MapPoint& p) {
  if (p.hasTangent()) return {{p.tangent_x, p.tangent_y}};
  return {{1, 0}, {0, 1}};
}

bool isSurfaceIn(const LabelSet& labels, std::uint32_t label) {
  const ClassInfo* info = labels.find(label);
  return info && info->role == Role::surface;
}

}  // namespace

double softplus(double v) {
  constexpr double kLow = -12, kHigh = 12, kSteps = 32;  // steps per unit
  static const std::vector<float> table = [] {
    std::vector<float> t;
    for (int i = 0; i <= static_cast<int>((kHigh - kLow) * kSteps) + 1; ++i) {
      t.push_back(static_cast<float>(std::log1p(std::exp(kLow + i / kSteps))));
    }
    return t;
  }();
  if (v <= kLow) return 0;
  if (v >= kHigh) return v;
  const double place = (v - kLow) * kSteps;
  const auto i = static_cast<std::size_t>(place);
  const double f = place - static_cast<double>(i);
  return table[i] + f * (table[i + 1] - table[i]);
}

double logGain(const ObjectClass& model, double area, double log_clutter) {
  return std::log(model.detection / ((1 - model.detection) * 2 * M_PI * area)) - log_clutter;
}

ObjectMap::ObjectMap(const AllVertices& vertices, const LabelSet& labels,
                     const SearchOptions& options) {
  takeVertices(vertices, labels, options);
  sortIntoBlocks();
  measureSpacing();
  findTangents();
  weighSurfaces();
  measureDensities();
  for (MapPoint& p : points_) {
    const ObjectClass& model = classes_[p.slot];
    const double area = p.hasTangent()
                            ? model.along_m * model.across_m
                            : (model.is_surface ? 0.6 : 1.0) * model.along_m * model.along_m;
    p.odds = static_cast<float>(std::exp(logGain(model, area, logClutter(p.slot, p.x, p.y))));
  }
}

void ObjectMap::takeVertices(const AllVertices& vertices, const LabelSet& labels,
                             const SearchOptions& options) {
  struct Thing {
    Eigen::Vector3d position;
    std::uint32_t label, vertex;
  };
  constexpr double kSameHeight_m = 1e-3;
  ChunkedVector<Thing> things;
  SemanticGraph surfaces;
  std::vector<std::uint32_t> numbers;  // of the surfaces
  Eigen::AlignedBox3d box;
  vertices.forEach([&](std::uint32_t number, const Vertex& v) {
    const ClassInfo* info = labels.find(v.label);
    if (!v.position.allFinite() || (info && info->role == Role::ignored)) return;
    box.extend(v.position);
    slot_of_label_[v.label] = 0;
    if (!isSurfaceIn(labels, v.label)) return things.push_back({v.position, v.label, number});
    surfaces.vertices.push_back(v);
    numbers.push_back(number);
  });
  if (slot_of_label_.empty()) return;
  origin_ = box.center().array().round();
  has_heights_ = box.sizes().z() > kSameHeight_m;
  std::vector<std::uint32_t> label_of_slot;
  for (auto& [label, slot] : slot_of_label_) {
    slot = static_cast<std::uint16_t>(label_of_slot.size());
    label_of_slot.push_back(label);
  }
  if (label_of_slot.size() > 4096) {
    throw UsageError("object place search: the map has " + std::to_string(label_of_slot.size()) +
                     " classes, at most 4096 are possible; are the labels instance ids?");
  }
  makeClasses(labels, label_of_slot, options);
  std::vector<std::uint32_t> all(numbers.size());
  std::iota(all.begin(), all.end(), 0u);
  const auto distinct = distinctFromAbove(surfaces, all, [](std::uint32_t) { return true; });
  points_.reserve(things.size() + distinct.size());
  const auto add = [&](const Eigen::Vector3d& position, std::uint32_t label, std::uint32_t vertex) {
    const Eigen::Vector3f p = (position - origin_).cast<float>();
    points_.push_back({p.x(), p.y(), p.z(), 0, 0, 0, vertex, slot_of_label_[label]});
  };
  for (std::size_t i = 0; i < things.size(); ++i)
    add(things[i].position, things[i].label, things[i].vertex);
  for (const std::uint32_t i : distinct)
    add(surfaces.vertices[i].position, surfaces.vertices[i].label, numbers[i]);
}

void ObjectMap::makeClasses(const LabelSet& labels, const std::vector<std::uint32_t>& label_of_slot,
                            const SearchOptions& options) {
  for (const std::uint32_t label : label_of_slot) {
    ObjectClass model;
    model.label = label;
    const ClassInfo* info = labels.find(label);
    const Role role = info ? info->role : Role::object;
    model.is_surface = isSurfaceIn(labels, label);
    model.detection = options.detection;
    if (role == Role::dynamic) model.detection *= kDynamicDetection;
    if (role == Role::surface) model.detection *= kSurfaceDetection;
    model.log_miss = std::log(1 - model.detection);
    model.along_m = model.across_m = options.sigma_m;
    classes_.push_back(model);
  }
}

/// Row by row, within a block by slot and vertex.
void ObjectMap::sortIntoBlocks() {
  struct Block {
    PlaneCell key;
    std::uint32_t points = 0;
  };
  CellTable<Block> blocks;
  std::vector<std::uint32_t> block_of;
  block_of.reserve(points_.size());
  for (const MapPoint& p : points_) {
    const PlaneCell at = cellAt(p.x, p.y, kBlock_m);
    const std::size_t number = blocks.numberOf(at, [&] { return Block{at}; });
    ++blocks[number].points;
    block_of.push_back(static_cast<std::uint32_t>(number));
  }
  std::vector<std::uint32_t> in_order(blocks.size());
  std::iota(in_order.begin(), in_order.end(), 0u);
  std::sort(in_order.begin(), in_order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return InRowOrder()(blocks[a].key, blocks[b].key);
  });
  std::vector<std::uint32_t> next(blocks.size());  // position for the next point of each block
  std::uint32_t begin = 0;
  for (const std::uint32_t number : in_order) {
    next[number] = begin;
    blocks_.at(blocks[number].key) = {begin, begin + blocks[number].points};
    begin += blocks[number].points;
  }
  std::vector<MapPoint> sorted(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) sorted[next[block_of[i]]++] = points_[i];
  points_ = std::move(sorted);
  for (const std::uint32_t number : in_order) {
    const auto end = points_.begin() + next[number];
    std::sort(end - blocks[number].points, end, [](const MapPoint& a, const MapPoint& b) {
      return std::tie(a.slot, a.vertex) < std::tie(b.slot, b.vertex);
    });
  }
}

void ObjectMap::pointsIn(double x, double y, double half_side,
                         std::vector<std::uint32_t>& found) const {
  found.clear();
  visitBlocks(x, y, half_side, [&](std::uint32_t i) {
    if (std::abs(points_[i].x - x) <= half_side && std::abs(points_[i].y - y) <= half_side)
      found.push_back(i);
  });
}

void ObjectMap::measureSpacing() {
  std::vector<std::vector<double>> nearest(classes_.size()), rises(classes_.size());
  std::vector<std::uint32_t> near;
  const std::size_t step = std::max<std::size_t>(
      1, points_.size() / (kSpacingSamples * std::max<std::size_t>(1, classes_.size())));
  for (std::size_t i = 0; i < points_.size(); i += step) {
    const MapPoint& p = points_[i];
    if (!classes_[p.slot].is_surface) continue;
    pointsIn(p.x, p.y, kWidestSpacing, near);
    double best = 2 * kWidestSpacing, rise = 0;
    for (const std::uint32_t j : near) {
      if (j == i || points_[j].slot != p.slot) continue;
      const double distance = std::hypot(points_[j].x - p.x, points_[j].y - p.y);
      if (distance >= best) continue;
      best = distance;
      rise = std::abs(points_[j].z - p.z);
    }
    nearest[p.slot].push_back(best);
    if (best <= kWidestSpacing) rises[p.slot].push_back(rise);
  }
  for (std::size_t slot = 0; slot < classes_.size(); ++slot) {
    ObjectClass& model = classes_[slot];
    if (!model.is_surface) continue;
    if (!nearest[slot].empty()) model.spacing_m = medianOf(std::move(nearest[slot]));
    model.is_surface = model.spacing_m > 0 && model.spacing_m <= kWidestSpacing;
    if (!model.is_surface) continue;
    // The query's samples fall anywhere between two of the map.
    model.along_m = 0.8 + 0.2 * model.spacing_m;
    model.across_m = kSurfaceSigma_m;
    model.height_m = std::max(model.height_m, kDeviationPerMedian * medianOf(rises[slot]));
    model.weight = std::min(1.0, model.spacing_m / kIndependentM);
  }
}

void ObjectMap::findTangents() {
  for (MapPoint& p : points_) {
    const ObjectClass& model = classes_[p.slot];
    if (model.is_surface) findTangent(p, std::max(10.0, 2.2 * model.spacing_m));
  }
}

/// Principal direction of the vertices of the class around, if they have one.
void ObjectMap::findTangent(MapPoint& point, double radius) const {
  double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  visitBlocks(point.x, point.y, radius, [&](std::uint32_t i) {
    const MapPoint& q = points_[i];
    if (q.slot != point.slot) return;
    const double x = q.x - point.x, y = q.y - point.y;
    if (x * x + y * y > radius * radius) return;
    n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y;
  });
  if (n < 3) return;
  sxx -= sx * sx / n, syy -= sy * sy / n, sxy -= sx * sy / n;
  const double elongation = std::hypot(sxx - syy, 2 * sxy);
  if (!(elongation > kLeastElongation * (sxx + syy))) return;
  const double angle = 0.5 * std::atan2(2 * sxy, sxx - syy);
  point.tangent_x = static_cast<float>(std::cos(angle));
  point.tangent_y = static_cast<float>(std::sin(angle));
}

/// How often a surface goes on where one looks along it says how little its pieces tell apart.
void ObjectMap::weighSurfaces() {
  std::vector<double> looks(classes_.size(), 0), continued(classes_.size(), 0);
  const std::size_t step = std::max<std::size_t>(
      1, points_.size() / (kSpacingSamples * std::max<std::size_t>(1, classes_.size())));
  for (std::size_t i = 0; i < points_.size(); i += step) {
    const MapPoint& p = points_[i];
    if (!classes_[p.slot].is_surface) continue;
    for (const Eigen::Vector2d& direction : directionsOf(p)) {
      for (const double metres : kAhead) {
        for (const double sign : {-1.0, 1.0}) {
          looks[p.slot] += 1;
          continued[p.slot] += goesOn(p, direction, sign * metres);
        }
      }
    }
  }
  for (std::size_t slot = 0; slot < classes_.size(); ++slot) {
    ObjectClass& model = classes_[slot];
    if (!model.is_surface) continue;
    const double ends = looks[slot] > 0 ? 1 - continued[slot] / looks[slot] : 1;
    model.independence = std::min(1.0, model.spacing_m / kIndependentPieceM);
    model.gain_weight = std::min(kMostAlone, ends * ends / kAlone) * model.independence;
  }
}

/// True if there is a vertex of the same class so far ahead.
bool ObjectMap::goesOn(const MapPoint& point, const Eigen::Vector2d& direction,
                       double metres) const {
  const ObjectClass& model = classes_[point.slot];
  const double x = point.x + metres * direction.x(), y = point.y + metres * direction.y();
  const double along = kGap * model.spacing_m, across = 2 * model.across_m;
  bool found = false;
  visitBlocks(x, y, std::max(along, across), [&](std::uint32_t i) {
    if (points_[i].slot != point.slot) return;
    const double ex = points_[i].x - x, ey = points_[i].y - y;
    const double u = ex * direction.x() + ey * direction.y();
    const double v = ey * direction.x() - ex * direction.y();
    found = found || (std::abs(u) <= along && std::abs(v) <= across);
  });
  return found;
}

void ObjectMap::measureDensities() {
  counts_.resize(classes_.size());
  for (const MapPoint& p : points_) {
    forSquare(p.x, p.y, kDensityCell, kDensityCell, [&](const PlaneCell& cell) {
      std::uint16_t& count = counts_[p.slot].at(cell);
      if (count < std::numeric_limits<std::uint16_t>::max()) ++count;
      known_.at(cell) = 1;
    });
  }
  constexpr std::size_t kSamples = 3000;
  const std::size_t step = std::max<std::size_t>(1, points_.size() / kSamples);
  for (std::uint16_t slot = 0; slot < classes_.size(); ++slot) {
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < points_.size(); i += step, n += 1) {
      sum += counts_[slot](cellAt(points_[i].x, points_[i].y, kDensityCell)) / kDensityArea;
    }
    ObjectClass& model = classes_[slot];
    model.mean_density = n > 0 ? sum / n : 0;
    for (int count = 0; count <= kMostCounted; ++count) {
      const double density =
          std::max(kLeastDensity, 0.5 * (count / kDensityArea + model.mean_density));
      model.log_clutter.push_back(static_cast<float>(std::log(density)));
    }
  }
}

/// Draws how surely things near the points of the map would be in it.
void ObjectMap::cover(Coverage::Tile& tile) const {
  constexpr double kFading_m = 1.5;  // half the width of the rim of what the map covers
  constexpr double kWidest_m = kSeenNear_m + kFading_m, kHalf_m = Coverage::kSide * kCovered_m / 2;
  const int x0 = tile.key.x * Coverage::kSide, y0 = tile.key.y * Coverage::kSide;
  const auto draw = [&](double x, double y) {
    const PlaneCell low = cellAt(x - kWidest_m, y - kWidest_m, kCovered_m),
                    high = cellAt(x + kWidest_m, y + kWidest_m, kCovered_m);
    for (int cy = std::max(low.y - y0, 0); cy <= std::min(high.y - y0, Coverage::kSide - 1); ++cy) {
      for (int cx = std::max(low.x - x0, 0); cx <= std::min(high.x - x0, Coverage::kSide - 1);
           ++cx) {
        const double dx = (x0 + cx + 0.5) * kCovered_m - x, dy = (y0 + cy + 0.5) * kCovered_m - y;
        const double square = dx * dx + dy * dy;
        std::uint8_t& cell = tile.values[static_cast<std::size_t>(cy * Coverage::kSide + cx)];
        if (square >= kWidest_m * kWidest_m || cell == 255) continue;
        const double fades = (kWidest_m - std::sqrt(square)) / (2 * kFading_m);
        cell = std::max(cell, static_cast<std::uint8_t>(255 * std::min(1.0, fades)));
      }
    }
  };
  visitBlocks(x0 * kCovered_m + kHalf_m, y0 * kCovered_m + kHalf_m, kHalf_m + kWidest_m,
              [&](std::uint32_t i) { draw(points_[i].x, points_[i].y); });
}

void ObjectMap::coverage(const std::vector<Eigen::Vector2d>& places,
                         std::vector<double>& result) const {
  const std::lock_guard<std::mutex> lock(covering_);
  result.clear();
  for (const Eigen::Vector2d& p : places) {
    const PlaneCell cell = cellAt(p.x(), p.y(), kCovered_m);
    result.push_back(coverage_.at(cell, [&](Coverage::Tile& tile) { cover(tile); }) / 255.0);
  }
}

std::optional<std::uint16_t> ObjectMap::slotOf(std::uint32_t label) const {
  const auto it = slot_of_label_.find(label);
  if (it == slot_of_label_.end()) return std::nullopt;
  return it->second;
}

double ObjectMap::logClutter(std::uint16_t slot, double x, double y) const {
  const std::vector<float>& table = classes_[slot].log_clutter;
  return table[std::min<std::size_t>(counts_[slot](cellAt(x, y, kDensityCell)), table.size() - 1)];
}

bool ObjectMap::isKnown(double x, double y) const {
  return known_(cellAt(x, y, kDensityCell)) != 0;
}

}  // namespace xview::search
