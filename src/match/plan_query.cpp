// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>

#include "match/plan_blocks.h"
#include "xview/match/plan_places.h"

namespace xview {
namespace {

/// One sample per block: the nearest to the centre of the block.
std::vector<PlanSample> onePerBlock(const std::vector<PlanSample>& samples, double block_m) {
  struct Kept {
    std::size_t sample;
    double distance;
  };
  std::map<std::pair<std::int64_t, std::int64_t>, Kept> blocks;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double bx = std::floor(samples[i].x / block_m), by = std::floor(samples[i].y / block_m);
    const double d =
        std::hypot(samples[i].x - (bx + 0.5) * block_m, samples[i].y - (by + 0.5) * block_m);
    const auto [it, is_new] = blocks.try_emplace(
        {static_cast<std::int64_t>(by), static_cast<std::int64_t>(bx)}, Kept{i, d});
    if (!is_new && d < it->second.distance) it->second = {i, d};
  }
  std::vector<PlanSample> result;
  for (const auto& [block, kept] : blocks) result.push_back(samples[kept.sample]);
  return result;
}

std::vector<PlanQuery::Sample> gather(const PlanView& view, bool coarse,
                                      const Eigen::Vector2d& centre) {
  std::vector<PlanQuery::Sample> result;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto channel = static_cast<Channel>(c);
    const double block = coarse ? coarseBlock(channel) : fineBlock(channel);
    for (const PlanSample& s : block > 0 ? onePerBlock(view.samples[c], block) : view.samples[c]) {
      result.push_back({static_cast<float>(view.origin_x + s.x - centre.x()),
                        static_cast<float>(view.origin_y + s.y - centre.y()),
                        static_cast<std::uint8_t>(c), WaySide::none,
                        static_cast<float>(view.origin_z + s.z)});
    }
  }
  return result;
}

/// The way of the sensor; steps shorter than this show no direction.
std::vector<Eigen::Vector2d> spaced(const std::vector<Eigen::Vector2d>& way) {
  constexpr double kStep_m = 0.5;
  std::vector<Eigen::Vector2d> kept;
  for (const Eigen::Vector2d& p : way) {
    if (kept.empty() || (p - kept.back()).norm() >= kStep_m) kept.push_back(p);
  }
  return kept;
}

/// Seen from the nearest position on the way, along its direction there.
WaySide sideOf(const std::vector<Eigen::Vector2d>& way, const Eigen::Vector2d& p) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    if ((way[i] - p).squaredNorm() < (way[nearest] - p).squaredNorm()) nearest = i;
  }
  const Eigen::Vector2d along =
      way[std::min(nearest + 1, way.size() - 1)] - way[nearest > 0 ? nearest - 1 : 0];
  const Eigen::Vector2d off = p - way[nearest];
  return along.x() * off.y() - along.y() * off.x() > 0 ? WaySide::left : WaySide::right;
}

}  // namespace

double radiusOf(const std::vector<PlanQuery::Sample>& samples) {
  double radius = 0;
  for (const auto& s : samples) radius = std::max(radius, std::hypot(double{s.x}, double{s.y}));
  return radius;
}

PlanQuery makePlanQuery(const PlanView& view, const std::vector<Eigen::Vector2d>& way) {
  PlanQuery query;
  query.viewpoint = view.aerial ? Viewpoint::air : Viewpoint::ground;
  const auto about_zero = gather(view, false, Eigen::Vector2d::Zero());
  if (about_zero.empty()) return query;
  for (const auto& s : about_zero) query.centre += Eigen::Vector2d(s.x, s.y);
  query.centre /= static_cast<double>(about_zero.size());
  query.fine = gather(view, false, query.centre);
  query.coarse = gather(view, true, query.centre);
  const std::vector<Eigen::Vector2d> steps = spaced(way);
  if (steps.size() > 1) {
    for (PlanQuery::Sample& s : query.fine)
      s.side = sideOf(steps, query.centre + Eigen::Vector2d(s.x, s.y));
  }
  for (const Channel c : {Channel::road, Channel::sidewalk, Channel::terrain}) {
    for (const PlanSample& s : onePerBlock(view[c], 2.0)) {
      query.ground.push_back({static_cast<float>(view.origin_x + s.x - query.centre.x()),
                              static_cast<float>(view.origin_y + s.y - query.centre.y()),
                              static_cast<float>(view.origin_z + s.z)});
    }
  }
  return query;
}

}  // namespace xview
