// SPDX-License-Identifier: BSD-3-Clause
#include "match/consistency.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "base/median.h"
#include "base/pose.h"

namespace xview::match {
namespace {

constexpr std::size_t kMostCorrespondences = 3000;  ///< the bits of all their pairs take 1 MB
constexpr std::size_t kMostVotes = 100000;  ///< of more pairs that agree an even share votes
constexpr std::size_t kMostPoses = 500;     ///< poses made of the pairs with most votes

using Points = std::vector<Eigen::Vector3d>;

constexpr std::size_t kMostSeeds = 300;  ///< matches around which poses are made
constexpr std::size_t kAroundSeed = 20;  ///< matches that make such a pose, beside the seed
constexpr int kRefits = 3;               ///< of a pose to its supporters
constexpr std::size_t kFewestSupporters = 4;
constexpr double kLeastApart = 3;      ///< of two matches that may agree, in tolerances
constexpr double kAnglesDiffer = 0.3;  ///< of normals in query and map: difference of their cosines
constexpr double kNormalsAgree = 0.7;  ///< cosine between normals of a match that a pose explains
/// Poses that differ by less are one: in tolerances, at the middle of the matches, and by angle.
constexpr double kOnePose = 2, kOnePose_rad = 0.15;

/// Which correspondences agree with which, one row of bits each.
class Agreement {
 public:
  explicit Agreement(std::size_t size) : words_((size + 63) / 64), bits_(size * words_, 0) {}
  void connect(std::size_t a, std::size_t b) {
    bits_[a * words_ + b / 64] |= std::uint64_t{1} << (b % 64);
    bits_[b * words_ + a / 64] |= std::uint64_t{1} << (a % 64);
  }
  int countCommon(std::size_t a, std::size_t b) const {
    int count = 0;
    for (std::size_t w = 0; w < words_; ++w) count += __builtin_popcountll(row(a)[w] & row(b)[w]);
    return count;
  }
  bool agree(std::size_t a, std::size_t b) const { return row(a)[b / 64] >> (b % 64) & 1; }
  template <class Visit>
  void forCommon(std::size_t a, std::size_t b, Visit&& visit) const {
    for (std::size_t w = 0; w < words_; ++w) {
      for (std::uint64_t rest = row(a)[w] & row(b)[w]; rest != 0; rest &= rest - 1)
        visit(64 * w + static_cast<unsigned>(__builtin_ctzll(rest)));
    }
  }

 private:
  const std::uint64_t* row(std::size_t i) const { return bits_.data() + i * words_; }
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

/// Two correspondences that agree, and how many agree with both.
struct Pair {
  std::uint32_t a = 0, b = 0;
  int votes = 0;
};

class Draws {
 public:
  Draws(const Points& query, const Points& map, std::vector<Correspondence> correspondences,
        double tolerance_m, bool upright)
      : correspondences_(std::move(correspondences)),
        tolerance_m_(tolerance_m),
        upright_(upright),
        agreement_(correspondences_.size()) {
    for (const Correspondence& c : correspondences_) {
      query_.push_back(query[c.query]);
      map_.push_back(map[c.map]);
    }
  }

  /// The pose that most query vertices support.
  std::optional<Eigen::Isometry3d> best() {
    std::optional<Eigen::Isometry3d> best;
    std::size_t most = 2;
    for (const Pair& pair : mostVoted()) {
      const Eigen::Isometry3d T = poseOf(pair);
      const std::size_t support = supportOf(T);
      if (support <= most) continue;
      most = support;
      best = T;
    }
    return best;
  }

 private:
  bool agree(std::size_t a, std::size_t b) const {
    const Correspondence &c = correspondences_[a], &d = correspondences_[b];
    if (c.query == d.query || c.map == d.map) return false;
    Eigen::Vector3d in_query = query_[b] - query_[a], in_map = map_[b] - map_[a];
    if (upright_) {
      if (std::abs(in_query.z() - in_map.z()) > tolerance_m_) return false;
      in_query.z() = in_map.z() = 0;
    }
    const double length_m = in_query.norm(), map_length_m = in_map.norm();
    return std::min(length_m, map_length_m) >= tolerance_m_ &&
           std::abs(length_m - map_length_m) <= tolerance_m_;
  }

  /// Ties: the earlier pair.
  std::vector<Pair> mostVoted() {
    std::vector<Pair> agreeing;
    for (std::uint32_t b = 1; b < correspondences_.size(); ++b) {
      for (std::uint32_t a = 0; a < b; ++a) {
        if (!agree(a, b)) continue;
        agreement_.connect(a, b);
        agreeing.push_back({a, b, 0});
      }
    }
    const std::size_t step = 1 + agreeing.size() / kMostVotes;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < agreeing.size(); i += step) {
      pairs.push_back(agreeing[i]);
      pairs.back().votes = agreement_.countCommon(pairs.back().a, pairs.back().b);
    }
    const std::size_t count = std::min(pairs.size(), kMostPoses);
    std::partial_sort(pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(count),
                      pairs.end(), [](const Pair& p, const Pair& q) {
                        return std::tie(q.votes, p.b, p.a) < std::tie(p.votes, q.b, q.a);
                      });
    pairs.resize(count);
    return pairs;
  }

  /// Turns about z and moves, or fits the pair and that third which agrees with both and is as far
  /// from the line between them as any.
  Eigen::Isometry3d poseOf(const Pair& pair) const {
    const Eigen::Vector3d q = query_[pair.b] - query_[pair.a], m = map_[pair.b] - map_[pair.a];
    if (upright_) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.rotate(Eigen::AngleAxisd(std::atan2(m.y(), m.x()) - std::atan2(q.y(), q.x()),
                                 Eigen::Vector3d::UnitZ()));
      T.pretranslate(0.5 * (map_[pair.a] + map_[pair.b]) -
                     T.linear() * (0.5 * (query_[pair.a] + query_[pair.b])));
      return T;
    }
    std::size_t third = pair.a;
    double widest = 0;
    agreement_.forCommon(pair.a, pair.b, [&](std::size_t c) {
      const double off = q.cross(query_[c] - query_[pair.a]).norm();
      if (off <= widest) return;
      widest = off;
      third = c;
    });
    Eigen::Matrix3d source, target;
    source << query_[pair.a], query_[pair.b], query_[third];
    target << map_[pair.a], map_[pair.b], map_[third];
    return Eigen::Isometry3d(Eigen::umeyama(source, target, false));
  }

  std::size_t supportOf(const Eigen::Isometry3d& T_map_query) const {
    std::size_t support = 0;
    for (std::size_t i = 0; i < query_.size();) {
      bool near = false;
      const std::uint32_t vertex = correspondences_[i].query;
      for (; i < query_.size() && correspondences_[i].query == vertex; ++i)
        near = near ||
               (map_[i] - T_map_query * query_[i]).squaredNorm() <= tolerance_m_ * tolerance_m_;
      support += near;
    }
    return support;
  }

  std::vector<Correspondence> correspondences_;
  Points query_, map_;  ///< their ends
  double tolerance_m_;
  bool upright_;
  Agreement agreement_;
};

/// Poses around single matches.
class Seeds {
 public:
  Seeds(const std::vector<PointMatch>& matches, double tolerance_m)
      : m_(matches), tolerance_m_(tolerance_m), agreement_(matches.size()) {
    votes_.assign(m_.size(), 0);
    for (std::size_t b = 1; b < m_.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        if (agree(a, b)) agreement_.connect(a, b);
      }
    }
    for (std::size_t b = 1; b < m_.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        if (!agreement_.agree(a, b)) continue;
        const int common = agreement_.countCommon(a, b);
        votes_[a] += common;
        votes_[b] += common;
      }
    }
  }

  /// Matches with most votes first; ties: the earlier one.
  std::vector<std::size_t> seeds() const {
    std::vector<std::size_t> order(m_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return votes_[a] > votes_[b]; });
    order.resize(std::min(order.size(), kMostSeeds));
    return order;
  }

  std::optional<ConsistentPose> poseAround(std::size_t seed) const {
    std::vector<std::pair<int, std::size_t>> around;
    for (std::size_t i = 0; i < m_.size(); ++i) {
      if (agreement_.agree(seed, i)) around.emplace_back(-agreement_.countCommon(seed, i), i);
    }
    std::sort(around.begin(), around.end());
    std::vector<std::size_t> used{seed};
    for (std::size_t k = 0; k < std::min(kAroundSeed, around.size()); ++k)
      used.push_back(around[k].second);
    ConsistentPose pose;
    for (int round = 0; round <= kRefits; ++round) {
      if (used.size() < kFewestSupporters) return std::nullopt;
      pose.T_map_query = fitted(used);
      used = supporters(pose.T_map_query);
    }
    pose.support = used.size();
    return pose.support < kFewestSupporters ? std::nullopt : std::optional(pose);
  }

 private:
  bool agree(std::size_t a, std::size_t b) const {
    const double in_query = (m_[b].query - m_[a].query).norm();
    const double in_map = (m_[b].map - m_[a].map).norm();
    if (in_query < kLeastApart * tolerance_m_ || std::abs(in_query - in_map) > tolerance_m_)
      return false;
    return std::abs(std::abs(m_[a].query_normal.dot(m_[b].query_normal)) -
                    std::abs(m_[a].map_normal.dot(m_[b].map_normal))) <= kAnglesDiffer;
  }

  Eigen::Isometry3d fitted(const std::vector<std::size_t>& used) const {
    Eigen::Matrix3Xd source(3, used.size()), target(3, used.size());
    for (std::size_t k = 0; k < used.size(); ++k) {
      source.col(static_cast<Eigen::Index>(k)) = m_[used[k]].query;
      target.col(static_cast<Eigen::Index>(k)) = m_[used[k]].map;
    }
    return Eigen::Isometry3d(Eigen::umeyama(source, target, false));
  }

  std::vector<std::size_t> supporters(const Eigen::Isometry3d& T) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < m_.size(); ++i) {
      if ((T * m_[i].query - m_[i].map).norm() < 1.5 * tolerance_m_ &&
          std::abs((T.linear() * m_[i].query_normal).dot(m_[i].map_normal)) > kNormalsAgree)
        found.push_back(i);
    }
    return found;
  }

  const std::vector<PointMatch>& m_;
  double tolerance_m_;
  Agreement agreement_;
  std::vector<std::int64_t> votes_;
};

/// Finite correspondences by query vertex, at most kMostCorrespondences.
std::vector<Correspondence> firstOfEachVertex(const Points& query, const Points& map,
                                              const std::vector<Correspondence>& correspondences) {
  struct Ranked {
    Correspondence correspondence;
    std::size_t rank = 0;  ///< among those of its query vertex
  };
  std::vector<std::size_t> ranks(query.size(), 0);
  std::vector<Ranked> ranked;
  for (const Correspondence& c : correspondences) {
    if (query[c.query].allFinite() && map[c.map].allFinite())
      ranked.push_back({c, ranks[c.query]++});
  }
  if (ranked.size() > kMostCorrespondences) {
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const Ranked& a, const Ranked& b) { return a.rank < b.rank; });
    ranked.resize(kMostCorrespondences);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
    return a.correspondence.query < b.correspondence.query;
  });
  std::vector<Correspondence> first;
  for (const Ranked& r : ranked) first.push_back(r.correspondence);
  return first;
}

}  // namespace

std::vector<Correspondence> consistentCorrespondences(
    const Points& query, const Points& map, const std::vector<Correspondence>& correspondences,
    double tolerance_m, bool upright) {
  const auto T_map_query =
      Draws(query, map, firstOfEachVertex(query, map, correspondences), tolerance_m, upright)
          .best();
  std::vector<Correspondence> kept;
  if (!T_map_query) return kept;
  for (const Correspondence& c : correspondences) {
    // The comparison is false for positions that are not finite.
    if ((map[c.map] - *T_map_query * query[c.query]).norm() <= 2 * tolerance_m) kept.push_back(c);
  }
  return kept;
}

bool isOnePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& point,
               double near) {
  return (a * point - b * point).norm() < near && rotationBetween(a, b) < kOnePose_rad;
}

std::vector<ConsistentPose> consistentPoses(const std::vector<PointMatch>& given,
                                            double tolerance_m, std::size_t most) {
  const std::vector<PointMatch> matches = evenlySpread(given, kMostCorrespondences);
  if (matches.size() < kFewestSupporters) return {};
  const Seeds seeds(matches, tolerance_m);
  std::vector<ConsistentPose> poses;
  for (const std::size_t seed : seeds.seeds()) {
    if (const auto pose = seeds.poseAround(seed)) poses.push_back(*pose);
  }
  std::stable_sort(
      poses.begin(), poses.end(),
      [](const ConsistentPose& a, const ConsistentPose& b) { return a.support > b.support; });
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PointMatch& match : matches) middle += match.query;
  middle /= static_cast<double>(matches.size());
  return distinctPoses(poses, middle, kOnePose * tolerance_m, most);
}

}  // namespace xview::match
