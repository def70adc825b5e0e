// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>
#include <vector>

#include "base/pose.h"
#include "baselines/baseline.h"
#include "pose/align.h"

namespace xview {
namespace {

constexpr double kShortest = 4, kLongest = 30;  // [m] sides
constexpr std::size_t kNeighbours = 10;         // nearest objects that make triangles with one
constexpr double kBin = 1.5;                    // [m] of the sides
constexpr double kCell = 3, kTurn = 0.157;      // [m], [rad] of the votes

/// Corners opposite to sides of rising length.
struct Triangle {
  std::array<std::uint32_t, 3> corner;
  std::array<double, 3> side;
};

/// Each triangle of an object with two of its neighbours, once.
std::vector<Triangle> trianglesOf(const SemanticGraph& graph) {
  const auto at = [&](std::uint32_t i) { return graph.vertices[i].position.head<2>(); };
  std::vector<std::uint32_t> order(graph.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return at(a).x() < at(b).x(); });
  std::vector<Triangle> triangles;
  for (std::size_t k = 0; k < order.size(); ++k) {
    std::vector<std::pair<double, std::uint32_t>> near;
    const auto look = [&](std::size_t j) {
      const double d = (at(order[j]) - at(order[k])).norm();
      if (d >= kShortest && d <= kLongest) near.push_back({d, order[j]});
    };
    const double x = at(order[k]).x();
    for (std::size_t j = k; j-- > 0 && x - at(order[j]).x() <= kLongest;) look(j);
    for (std::size_t j = k + 1; j < order.size() && at(order[j]).x() - x <= kLongest; ++j) look(j);
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), kNeighbours));
    for (std::size_t a = 0; a < near.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const std::array<std::uint32_t, 3> v{order[k], near[a].second, near[b].second};
        std::array<std::pair<double, std::uint32_t>, 3> sides{
            std::pair{(at(v[1]) - at(v[2])).norm(), v[0]}, std::pair{near[b].first, v[1]},
            std::pair{near[a].first, v[2]}};
        std::sort(sides.begin(), sides.end());
        if (sides[0].first < kShortest || sides[2].first > kLongest) continue;
        triangles.push_back({{sides[0].second, sides[1].second, sides[2].second},
                             {sides[0].first, sides[1].first, sides[2].first}});
      }
    }
  }
  return triangles;
}

std::uint64_t keyOf(const SemanticGraph& graph, const Triangle& t, const std::array<int, 3>& bin) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    key = key * 4096 + graph.vertices[t.corner[i]].label;
    key = key * 64 + static_cast<std::uint64_t>(bin[i]);
  }
  return key;
}

std::array<int, 3> binsOf(const Triangle& t) {
  return {static_cast<int>(t.side[0] / kBin), static_cast<int>(t.side[1] / kBin),
          static_cast<int>(t.side[2] / kBin)};
}

class TriangleHash final : public Baseline {
 public:
  TriangleHash(const SemanticGraph& map, const LabelSet& labels)
      : labels_(labels), map_(objectsOf(map, labels)), triangles_(trianglesOf(map_)) {
    for (std::uint32_t i = 0; i < triangles_.size(); ++i)
      table_[keyOf(map_, triangles_[i], binsOf(triangles_[i]))].push_back(i);
  }

  std::optional<Eigen::Isometry3d> localize(const SemanticGraph& graph) const override {
    const SemanticGraph query = objectsOf(graph, labels_);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Vertex& v : query.vertices) centre += v.position / static_cast<double>(query.size());
    Votes votes;
    for (const Triangle& t : trianglesOf(query)) vote(query, t, centre, votes);
    return strongest(votes, centre);
  }

 private:
  using Cell = std::array<int, 3>;
  struct Vote {
    double weight = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // of the centre in the map
    Eigen::Vector2d turn = Eigen::Vector2d::Zero();
  };
  using Votes = std::map<Cell, Vote>;

  void vote(const SemanticGraph& query, const Triangle& t, const Eigen::Vector3d& centre,
            Votes& votes) const {
    const std::array<int, 3> bins = binsOf(t);
    for (int k = 0; k < 27; ++k) {
      const auto it = table_.find(
          keyOf(query, t, {bins[0] + k % 3 - 1, bins[1] + k / 3 % 3 - 1, bins[2] + k / 9 - 1}));
      if (it == table_.end()) continue;
      for (const std::uint32_t m : it->second) {
        std::vector<Eigen::Vector3d> from, to;
        for (int i = 0; i < 3; ++i) {
          if (std::abs(t.side[i] - triangles_[m].side[i]) > kBin) break;
          from.push_back(query.vertices[t.corner[i]].position);
          to.push_back(map_.vertices[triangles_[m].corner[i]].position);
        }
        if (from.size() < 3) continue;
        const pose::Alignment fit = pose::alignPointsInYaw(from, to);
        if (!fit.valid || fit.rms_m > kBin) continue;  // a mirror image
        const Eigen::Vector3d p = fit.T_target_source * centre;
        const double yaw = yawOf(fit.T_target_source.linear());
        Vote& v = votes[{static_cast<int>(std::floor(p.x() / kCell)),
                         static_cast<int>(std::floor(p.y() / kCell)),
                         static_cast<int>(std::floor(yaw / kTurn))}];
        const double weight = 1 / std::sqrt(static_cast<double>(it->second.size()));
        v.weight += weight;
        v.sum += weight * p;
        v.turn += weight * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
      }
    }
  }

  static std::optional<Eigen::Isometry3d> strongest(const Votes& votes,
                                                    const Eigen::Vector3d& centre) {
    Vote best;
    for (const auto& [cell, own] : votes) {
      Vote sum;
      for (int k = 0; k < 27; ++k) {
        const auto it =
            votes.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
        if (it == votes.end()) continue;
        sum.weight += it->second.weight;
        sum.sum += it->second.sum;
        sum.turn += it->second.turn;
      }
      if (sum.weight > best.weight) best = sum;
    }
    if (best.weight == 0) return std::nullopt;
    const Eigen::Isometry3d T =
        poseFromYaw(best.sum / best.weight, std::atan2(best.turn.y(), best.turn.x()));
    return T * Eigen::Translation3d(-centre);
  }

  LabelSet labels_;
  SemanticGraph map_;
  std::vector<Triangle> triangles_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> table_;
};

}  // namespace

std::unique_ptr<Baseline> makeTriangleHash(const SemanticGraph& map, const LabelSet& labels) {
  return std::make_unique<TriangleHash>(map, labels);
}

}  // namespace xview
