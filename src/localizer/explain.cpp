// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/explain.h"

#include <algorithm>
#include <cmath>

#include "base/cells.h"
#include "map/contents.h"
#include "search/likelihoods.h"

namespace xview {
namespace {

constexpr double kResidualReach_m = search::kBinLimits_m.back();

/// Map samples of one channel in cells as large as the reach.
class NearestSample {
 public:
  explicit NearestSample(const std::vector<BevSample>& samples) : samples_(samples) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      cells_.add(cellOf({samples[i].x, samples[i].y, 0}, kResidualReach_m, 0), i);
  }

  std::optional<double> distanceTo(double x, double y) const {
    double best = kResidualReach_m;
    cells_.forAround(cellOf({x, y, 0}, kResidualReach_m, 0), [&](std::size_t i) {
      best = std::min(best, std::hypot(samples_[i].x - x, samples_[i].y - y));
    });
    return best < kResidualReach_m ? std::optional(best) : std::nullopt;
  }

 private:
  const std::vector<BevSample>& samples_;
  CellLists cells_;
};

/// Ground height of the query at a position, 0 where it was not seen; in its plan frame.
double groundAt(const BevGrid& bev, const Eigen::Vector2d& p) {
  const auto cx = static_cast<std::int32_t>(std::floor((p.x() - bev.origin_x) / bev.cell_m));
  const auto cy = static_cast<std::int32_t>(std::floor((p.y() - bev.origin_y) / bev.cell_m));
  const GroundCell* seen = bev.knownCell(cx, cy);
  return bev.origin_z + (seen ? seen->z : 0);
}

Support supportOf(const search::SampleEvidence& e) {
  if (!e.known) return Support::unknown;
  return e.nats < 0 ? Support::contradicting : Support::kept;
}

}  // namespace

void explainSamples(const BevGrid& map, const Query& query, const search::FieldQuery& in_field,
                    const Eigen::Isometry3d& T_map_query, Explanation& explanation) {
  std::array<std::optional<NearestSample>, kBevChannels> nearest;
  for (const search::SampleEvidence& e : in_field.evidence(T_map_query)) {
    const auto c = static_cast<std::size_t>(e.channel);
    if (!nearest[c]) nearest[c].emplace(map.samples[c]);
    Contribution contribution;
    contribution.name = toString(e.channel);
    contribution.support = supportOf(e);
    const Eigen::Vector3d in_query(e.query.x(), e.query.y(), groundAt(query.bev, e.query));
    contribution.map_position << e.map, (T_map_query * in_query).z();
    contribution.nats = e.nats;
    contribution.expected = e.expected;
    contribution.residual_m =
        nearest[c]->distanceTo(e.map.x() - map.origin_x, e.map.y() - map.origin_y);
    explanation.contributions.push_back(contribution);
  }
}

void explainVertices(const map::SemanticMap& map, const Query& query,
                     const std::vector<Correspondence>& kept, const Eigen::Isometry3d& T_map_query,
                     Explanation& explanation) {
  const AllVertices in_map = map::allVertices(map);
  for (const Correspondence& c : kept) {
    if (c.query >= query.graph.size() || c.map >= in_map.size()) continue;
    const Vertex& seen = query.graph.vertices[c.query];
    const Vertex known = in_map.at(c.map);
    Contribution contribution;
    const ClassInfo* info = map.labels.find(known.label);
    contribution.name = info ? info->name : std::to_string(known.label);
    contribution.support = Support::kept;
    contribution.map_position = T_map_query * seen.position;
    contribution.residual_m = (known.position - contribution.map_position).norm();
    explanation.contributions.push_back(contribution);
  }
}

void scaleLengths(double factor, Explanation& explanation) {
  for (Contribution& c : explanation.contributions) {
    c.map_position *= factor;
    if (c.residual_m) *c.residual_m *= factor;
  }
}

void turn(const Eigen::Quaterniond& R, Explanation& explanation) {
  for (Contribution& c : explanation.contributions) c.map_position = R * c.map_position;
}

}  // namespace xview
