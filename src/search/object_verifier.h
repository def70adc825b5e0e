// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "search/heights.h"
#include "search/object_query.h"

namespace xview::search {

/// The map point that a query item is taken for.
struct Association {
  static constexpr std::int32_t kNone = -1;
  std::int32_t local = kNone;  ///< the likeliest, as an index in the neighbourhood of the verifier
  float odds = 0;              ///< that the item has a partner in the map at all
  float chance() const { return odds / (1 + odds); }
};

/// Scores poses near one place of the map against all query vertices. Not thread-safe: one per
/// thread.
class ObjectVerifier {
 public:
  ObjectVerifier(const ObjectMap& map, const ObjectQuery& query, const SearchOptions& options);

  /// Collects the map around a pose; poses within a few metres can be scored afterwards.
  void moveTo(const PlacePose& pose);
  /// Sum over query vertices of log P(seen here | true) / P(seen here | chance) [nats], where any
  /// map point around may be the partner; vertices in unknown area count zero. `widen` multiplies
  /// the standard deviations while the pose is still rough.
  double score(const PlacePose& pose, double widen);
  /// One Gauss-Newton step on x, y, yaw (expectation maximization): every map point of the class
  /// pulls by the chance that it is the partner.
  PlacePose improved(const PlacePose& pose, double widen);
  /// Pairs of the last score() that are more likely than not, with their heights.
  const std::vector<HeightPair>& heightPairs();
  /// What the heights of these pairs speak against the pose [nats]; 0 if map or query has no
  /// heights.
  double heightCost();
  /// Cost of objects of the map that the query should have seen; for the associations of the last
  /// score().
  double missedObjects(const PlacePose& pose) const;
  /// Mean of score() - missedObjects() if `pose`, that of moveTo(), were true.
  double expectedScore(const PlacePose& pose);

  /// Share of the query vertices in known area at the pose of moveTo().
  double knownShare() const;

  const std::vector<Association>& associations() const { return associations_; }
  const MapPoint& mapPoint(std::int32_t local) const {
    return map_.points()[points_[static_cast<std::size_t>(local)].point];
  }

 private:
  /// A map point near the pose.
  struct LocalPoint {
    float x, y, tangent_x, tangent_y;
    float undirected;  ///< 1 if the tangent is not known or it is an object, else 0
    float odds;
    std::uint32_t point;  ///< index in the map
  };
  /// What the scale of the standard deviations means for a class.
  struct Spread {
    float gate, inverse_along2, inverse_across2, inverse_round2;  ///< [m], [1/m^2]
    float odds_factor;  ///< because of other deviations than the map's
    float pull;         ///< of a vertex of the class on the pose
  };

  void buildGrid(const PlacePose& pose);
  const std::vector<Spread>& spreads(double widen);
  Spread spreadOf(const ObjectClass& model, double widen) const;
  template <class Visitor>
  void visitNear(std::uint16_t slot, float x, float y, float gate, const Spread& spread,
                 const Visitor& visitor) const;
  void associate(std::uint16_t slot, float x, float y, const Spread& spread,
                 Association& association);
  double costOfMissing(std::uint16_t slot, double coverage) const;
  double costOfUnseen(const MapPoint& p, double x, double y) const;
  std::vector<std::optional<double>> gainsOfSeenAgain(const PlacePose& pose);

  const ObjectMap& map_;
  const ObjectQuery& query_;
  const SearchOptions& options_;
  std::vector<std::int32_t>
      lane_of_slot_;  ///< dense numbers of the classes that matter for this query; -1 = none
  std::int32_t lanes_ = 0;
  std::vector<std::pair<double, std::vector<Spread>>> spreads_;  ///< by scale

  std::vector<std::uint32_t> found_;
  std::vector<LocalPoint> points_;  ///< sorted by lane and cell
  std::vector<std::uint32_t> cell_start_;
  double grid_x_ = 0, grid_y_ = 0, cell_ = 1;
  int side_ = 0;
  std::vector<Eigen::Vector2d> places_;  ///< of the items at the pose of moveTo
  std::vector<double> coverage_;         ///< of the map there
  std::vector<std::uint8_t> known_;      ///< per item: lies in known area at the pose of moveTo
  std::vector<float> cost_;       ///< per item: of having no partner at the pose of moveTo [nats]
  std::vector<float> explained_;  ///< per point: chance that the last score() found it in the query
  std::vector<std::pair<std::uint32_t, float>> pairs_;  ///< of one item: points and their odds
  std::vector<Association> associations_;
  std::vector<HeightPair> height_pairs_;
};

}  // namespace xview::search
