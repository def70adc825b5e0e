// SPDX-License-Identifier: BSD-3-Clause
#include "search/object_verifier.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace xview::search {
namespace {

constexpr double kMargin = 8;    // [m] poses may move by this without collecting the map again
constexpr double kWidest = 1.8;  // largest scale of the standard deviations in use
constexpr float kFarthestMatch =
    10;                             // squared Mahalanobis distance beyond which nothing is a match
constexpr double kLeastPull = 0.3;  // of a surface: what does not tell places apart still tells
                                    // where they are
constexpr double kRoundShare =
    0.6;  // variance of surface vertices without tangent, of that along a surface
constexpr double kIndependentShare =
    0.6;  // of the evidence of objects that agree: they stand in rows, one brings others along
constexpr int kLeastSide = 20, kLargestSide = 300;  // cells of the local grid
constexpr double kItemsPerCell = 4;
constexpr float kFadingSteps = 64;  // per unit of squared distance

/// exp(-distance2 / 2) from a table, good to 1e-4; 0 from kFarthestMatch on.
const std::vector<float> kFadingTable = [] {
  std::vector<float> table;
  for (int i = 0; i <= static_cast<int>(kFarthestMatch * kFadingSteps) + 1; ++i)
    table.push_back(std::exp(-0.5f * static_cast<float>(i) / kFadingSteps));
  return table;
}();

float fading(float distance2) {
  const float place = std::max(0.0f, distance2) * kFadingSteps;
  const auto i = static_cast<std::size_t>(place);
  const float f = place - static_cast<float>(i);
  return kFadingTable[i] + f * (kFadingTable[i + 1] - kFadingTable[i]);
}

}  // namespace

ObjectVerifier::ObjectVerifier(const ObjectMap& map, const ObjectQuery& query,
                               const SearchOptions& options)
    : map_(map), query_(query), options_(options), lane_of_slot_(map.classes().size(), -1) {
  const auto addLane = [&](std::uint16_t slot) {
    if (lane_of_slot_[slot] < 0) lane_of_slot_[slot] = lanes_++;
  };
  for (const QueryItem& item : query.items()) addLane(item.slot);
  associations_.resize(query.items().size());
  known_.resize(query.items().size());
  cost_.resize(query.items().size());
}

ObjectVerifier::Spread ObjectVerifier::spreadOf(const ObjectClass& model, double widen) const {
  double along = model.along_m, across = model.across_m;
  across *= widen;
  if (!model.is_surface) along *= widen;
  const double round2 = along * along * (model.is_surface ? kRoundShare : 1.0);
  Spread spread;
  spread.gate = static_cast<float>(model.is_surface ? 2 * along + 1.6 : 3 * along);
  spread.inverse_along2 = static_cast<float>(1 / (along * along));
  spread.inverse_across2 = static_cast<float>(1 / (across * across));
  spread.inverse_round2 = static_cast<float>(1 / round2);
  spread.odds_factor = static_cast<float>(model.along_m * model.across_m / (along * across));
  spread.pull = static_cast<float>(model.is_surface ? std::max(kLeastPull, model.gain_weight) : 1);
  return spread;
}

const std::vector<ObjectVerifier::Spread>& ObjectVerifier::spreads(double widen) {
  for (const auto& [scale, spreads] : spreads_) {
    if (scale == widen) return spreads;
  }
  std::vector<Spread> spreads;
  for (const ObjectClass& model : map_.classes()) spreads.push_back(spreadOf(model, widen));
  return spreads_.emplace_back(widen, std::move(spreads)).second;
}

void ObjectVerifier::moveTo(const PlacePose& pose) {
  buildGrid(pose);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  places_.clear();
  for (const QueryItem& item : query_.items())
    places_.emplace_back(pose.x + c * item.x - s * item.y, pose.y + s * item.x + c * item.y);
  map_.coverage(places_, coverage_);
  for (std::size_t i = 0; i < known_.size(); ++i) {
    known_[i] = coverage_[i] > 0 || map_.isKnown(places_[i].x(), places_[i].y());
    cost_[i] =
        static_cast<float>(known_[i] ? costOfMissing(query_.items()[i].slot, coverage_[i]) : 0);
  }
}

double ObjectVerifier::knownShare() const {
  if (known_.empty()) return 0;
  const auto known = std::count(known_.begin(), known_.end(), std::uint8_t{1});
  return static_cast<double>(known) / static_cast<double>(known_.size());
}

/// Of a query vertex without a partner. A sample of a surface where the map has nothing at all is
/// not a gap between two samples: the whole surface is missing.
double ObjectVerifier::costOfMissing(std::uint16_t slot, double coverage) const {
  const ObjectClass& model = map_.classes()[slot];
  const double outside =
      model.is_surface ? -model.independence * std::log(1 - options_.detection) : -model.log_miss;
  return -coverage * model.weight * model.log_miss + (1 - coverage) * outside;
}

/// Counting sort of the points around by class and cell.
void ObjectVerifier::buildGrid(const PlacePose& pose) {
  double gate = kSeenNear_m;
  for (const QueryItem& item : query_.items())
    gate = std::max<double>(gate, spreads(kWidest)[item.slot].gate);
  const double half = query_.radius() + gate + kMargin;
  map_.pointsIn(pose.x, pose.y, half, found_);
  found_.erase(
      std::remove_if(found_.begin(), found_.end(),
                     [&](std::uint32_t i) { return lane_of_slot_[map_.points()[i].slot] < 0; }),
      found_.end());
  const double side = std::sqrt(static_cast<double>(query_.items().size()) / kItemsPerCell);
  cell_ = std::max(4.0, 2 * half / std::clamp(static_cast<int>(side), kLeastSide, kLargestSide));
  side_ = static_cast<int>(2 * half / cell_) + 1;
  grid_x_ = pose.x - half;
  grid_y_ = pose.y - half;
  const auto cellOf = [&](const MapPoint& p) {
    const int cx = std::clamp(static_cast<int>((p.x - grid_x_) / cell_), 0, side_ - 1);
    const int cy = std::clamp(static_cast<int>((p.y - grid_y_) / cell_), 0, side_ - 1);
    return static_cast<std::size_t>((lane_of_slot_[p.slot] * side_ + cy) * side_ + cx);
  };
  // Counted one cell late and filled from the front, cell_start_[k] ends up as the first point of
  // cell k.
  cell_start_.assign(static_cast<std::size_t>(lanes_ * side_ * side_) + 2, 0);
  for (const std::uint32_t i : found_) ++cell_start_[cellOf(map_.points()[i]) + 2];
  for (std::size_t k = 2; k < cell_start_.size(); ++k) cell_start_[k] += cell_start_[k - 1];
  points_.resize(found_.size());
  for (const std::uint32_t i : found_) {
    const MapPoint& p = map_.points()[i];
    const float undirected = p.hasTangent() ? 0 : 1;
    points_[cell_start_[cellOf(p) + 1]++] = {p.x,    p.y, p.tangent_x, p.tangent_y, undirected,
                                             p.odds, i};
  }
}

/// Calls visitor(local, distance2) for the points of a class within the gate.
template <class Visitor>
void ObjectVerifier::visitNear(std::uint16_t slot, float x, float y, float gate,
                               const Spread& spread, const Visitor& visitor) const {
  const auto cell = [&](double v) { return std::clamp(static_cast<int>(v / cell_), 0, side_ - 1); };
  const int x0 = cell(x - gate - grid_x_), x1 = cell(x + gate - grid_x_);
  const int y0 = cell(y - gate - grid_y_), y1 = cell(y + gate - grid_y_);
  for (int cy = y0; cy <= y1; ++cy) {
    const auto row = static_cast<std::size_t>((lane_of_slot_[slot] * side_ + cy) * side_);
    const std::uint32_t end = cell_start_[row + static_cast<std::size_t>(x1) + 1];
    for (std::uint32_t k = cell_start_[row + static_cast<std::size_t>(x0)]; k < end; ++k) {
      const LocalPoint& p = points_[k];
      const float ex = x - p.x, ey = y - p.y, e2 = ex * ex + ey * ey;
      if (e2 > gate * gate) continue;
      const float u = ex * p.tangent_x + ey * p.tangent_y, v = ey * p.tangent_x - ex * p.tangent_y;
      const float along2 =
          u * u * spread.inverse_along2 + p.undirected * e2 * spread.inverse_round2;
      const float distance2 = along2 + v * v * spread.inverse_across2;
      if (distance2 < kFarthestMatch) visitor(k, distance2);
    }
  }
}

double ObjectVerifier::score(const PlacePose& pose, double widen) {
  const std::vector<Spread>& spread = spreads(widen);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  explained_.assign(points_.size(), 0);
  double total = 0;
  for (std::size_t i = 0; i < query_.items().size(); ++i) {
    const QueryItem& item = query_.items()[i];
    const ObjectClass& model = map_.classes()[item.slot];
    Association& association = associations_[i] = {};
    associate(item.slot, static_cast<float>(pose.x + c * item.x - s * item.y),
              static_cast<float>(pose.y + s * item.x + c * item.y), spread[item.slot], association);
    const double odds = association.odds, chance = association.chance();
    total += chance * model.gain_weight * model.log_miss - (1 - chance) * cost_[i] +
             model.gain_weight * kIndependentShare * std::log1p(odds);
  }
  return total;
}

/// Odds that the item is one of the points of its class around.
void ObjectVerifier::associate(std::uint16_t slot, float x, float y, const Spread& spread,
                               Association& association) {
  float best = 0;
  pairs_.clear();
  visitNear(slot, x, y, spread.gate, spread, [&](std::uint32_t k, float distance2) {
    const float odds = points_[k].odds * spread.odds_factor * fading(distance2);
    pairs_.emplace_back(k, odds);
    association.odds += odds;
    if (odds <= best) return;
    best = odds;
    association.local = static_cast<std::int32_t>(k);
  });
  for (const auto& [k, odds] : pairs_) explained_[k] += odds / (1 + association.odds);
}

PlacePose ObjectVerifier::improved(const PlacePose& pose, double widen) {
  const std::vector<Spread>& spread = spreads(widen);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Identity() * 1e-3;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (const QueryItem& item : query_.items()) {
    const Spread& w = spread[item.slot];
    const double rx = c * item.x - s * item.y, ry = s * item.x + c * item.y;
    const double x = pose.x + rx, y = pose.y + ry;
    // Sums over the partners of information matrices [a b; b d] and of pulls.
    double a = 0, b = 0, d = 0, gx = 0, gy = 0;
    float odds = 0;
    visitNear(
        item.slot, static_cast<float>(x), static_cast<float>(y), w.gate, w,
        [&](std::uint32_t k, float distance2) {
          const LocalPoint& p = points_[k];
          const float odds_of_pair = p.odds * w.odds_factor * fading(distance2);
          odds += odds_of_pair;
          // An undirected point has no tangent, which leaves the round part.
          const double tx = p.tangent_x, ty = p.tangent_y;
          const double across2 = w.inverse_across2;
          const double round = p.undirected * w.inverse_round2;
          const double pa = odds_of_pair * (w.inverse_along2 * tx * tx + across2 * ty * ty + round);
          const double pb = odds_of_pair * (w.inverse_along2 - across2) * tx * ty;
          const double pd = odds_of_pair * (w.inverse_along2 * ty * ty + across2 * tx * tx + round);
          const double ex = p.x - x, ey = p.y - y;
          a += pa, b += pb, d += pd;
          gx += pa * ex + pb * ey, gy += pb * ex + pd * ey;
        });
    if (odds == 0) continue;
    const double weight = w.pull / (1 + odds);
    a *= weight, b *= weight, d *= weight, gx *= weight, gy *= weight;
    // The derivative of the residual p - (t + R q) by (x, y, yaw) is -[1 0 -ry; 0 1 rx].
    gradient += Eigen::Vector3d(gx, gy, rx * gy - ry * gx);
    hessian(0, 0) += a;
    hessian(0, 1) += b;
    hessian(1, 1) += d;
    hessian(0, 2) += rx * b - ry * a;
    hessian(1, 2) += rx * d - ry * b;
    hessian(2, 2) += rx * rx * d - 2 * rx * ry * b + ry * ry * a;
  }
  const Eigen::Vector3d step = hessian.selfadjointView<Eigen::Upper>().ldlt().solve(gradient);
  return {pose.x + step.x(), pose.y + step.y(), pose.yaw + step.z(), 0};
}

double ObjectVerifier::costOfUnseen(const MapPoint& p, double x, double y) const {
  const ObjectClass& model = map_.classes()[p.slot];
  const double share = query_.visibleShare(p.slot);
  if (share == 0) return 0;
  const double expected = model.is_surface ? model.weight * query_.expectsSurface(p.slot, x, y)
                                           : query_.expectsObject(x, y);
  return kUnseenWeight * share * expected * model.detection / options_.detection;
}

double ObjectVerifier::missedObjects(const PlacePose& pose) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double cost = 0;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (explained_[k] >= 1) continue;
    const MapPoint& p = map_.points()[points_[k].point];
    const double dx = p.x - pose.x, dy = p.y - pose.y;
    cost += (1 - explained_[k]) * costOfUnseen(p, c * dx + s * dy, -s * dx + c * dy);
  }
  return cost;
}

const std::vector<HeightPair>& ObjectVerifier::heightPairs() {
  height_pairs_.clear();
  for (std::size_t i = 0; i < associations_.size(); ++i) {
    const Association& association = associations_[i];
    if (association.chance() <= 0.5f) continue;
    const QueryItem& item = query_.items()[i];
    const MapPoint& p = mapPoint(association.local);
    const ObjectClass& model = map_.classes()[p.slot];
    height_pairs_.push_back({item.x, item.y, p.z - item.z, model.height_m, model.weight});
  }
  return height_pairs_;
}

double ObjectVerifier::heightCost() {
  if (!query_.hasHeights() || !map_.hasHeights()) return 0;
  const std::vector<HeightPair>& pairs = heightPairs();
  return search::heightCost(pairs, fitHeights(pairs, vertexHeights()));
}

/// Mean over the map points of each class around `pose` of log(1 + odds) of a vertex that shows one
/// of them, a standard deviation off along and across; by slot. None where there are no points.
std::vector<std::optional<double>> ObjectVerifier::gainsOfSeenAgain(const PlacePose& pose) {
  const std::vector<Spread>& spread = spreads(1);
  const double radius = query_.radius();
  std::vector<double> sum(spread.size(), 0), count(spread.size(), 0);
  for (std::uint32_t k = 0; k < points_.size(); ++k) {
    const LocalPoint& p = points_[k];
    const double dx = p.x - pose.x, dy = p.y - pose.y;
    if (dx * dx + dy * dy > radius * radius) continue;
    const std::uint16_t slot = map_.points()[p.point].slot;
    const Spread& s = spread[slot];
    const bool has_tangent = p.undirected == 0;
    const float tx = has_tangent ? p.tangent_x : 1, ty = has_tangent ? p.tangent_y : 0;
    const float along =
        (k & 1 ? 1.0f : -1.0f) / std::sqrt(has_tangent ? s.inverse_along2 : s.inverse_round2);
    const float across =
        (k & 2 ? 1.0f : -1.0f) / std::sqrt(has_tangent ? s.inverse_across2 : s.inverse_round2);
    float odds = 0;
    visitNear(slot, p.x + along * tx - across * ty, p.y + along * ty + across * tx, s.gate, s,
              [&](std::uint32_t j, float distance2) {
                odds += points_[j].odds * s.odds_factor * fading(distance2);
              });
    sum[slot] += std::log1p(odds);
    count[slot] += 1;
  }
  std::vector<std::optional<double>> gains(spread.size());
  for (std::size_t slot = 0; slot < gains.size(); ++slot) {
    if (count[slot] > 0) gains[slot] = sum[slot] / count[slot];
  }
  return gains;
}

double ObjectVerifier::expectedScore(const PlacePose& pose) {
  const std::vector<Spread>& spread = spreads(1);
  const std::vector<std::optional<double>> seen_again = gainsOfSeenAgain(pose);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double total = 0;
  for (std::size_t i = 0; i < query_.items().size(); ++i) {
    if (!known_[i]) continue;
    const QueryItem& item = query_.items()[i];
    const ObjectClass& model = map_.classes()[item.slot];
    const double area = 1 / std::sqrt(static_cast<double>(spread[item.slot].inverse_along2) *
                                      spread[item.slot].inverse_across2);
    // The mean of half a squared distance in the plane is 1.
    const double gain =
        model.is_surface && seen_again[item.slot]
            ? *seen_again[item.slot]
            : softplus(
                  logGain(model, area, map_.logClutter(item.slot, places_[i].x(), places_[i].y())) -
                  1);
    // Where one sample of a surface is not seen again, a neighbour of it is.
    const double detection = model.is_surface ? options_.detection : model.detection;
    total += detection * model.gain_weight * (model.log_miss + kIndependentShare * gain);
    total -= (1 - detection) * costOfMissing(item.slot, coverage_[i]);
  }
  for (const LocalPoint& local : points_) {
    const MapPoint& p = map_.points()[local.point];
    const ObjectClass& model = map_.classes()[p.slot];
    const double dx = p.x - pose.x, dy = p.y - pose.y;
    // Places where a piece of a surface was not seen are its costs already.
    const double missing = model.is_surface ? 1 - model.detection : 1;
    total -= (1 - model.detection) * missing * costOfUnseen(p, c * dx + s * dy, -s * dx + c * dy);
  }
  return total;
}

}  // namespace xview::search
