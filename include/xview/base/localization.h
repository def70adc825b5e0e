// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "xview/base/graph.h"

namespace xview {

/// A gravity-aligned pose: p_map = Rz(yaw) * p_query + (x, y), and what speaks for it.
struct PlacePose {
  double x = 0, y = 0;  ///< [m]
  double yaw = 0;       ///< [rad]
  double score = 0;     ///< log-likelihood ratio against chance [nats]
};

/// What a user may know beforehand about the pose of the last query frame.
struct PlacePrior {
  struct Circle {
    double x = 0, y = 0, radius = 0;  ///< [m], map frame
  };
  struct Heading {
    double yaw = 0, tolerance = 0;  ///< [rad], map frame
  };
  std::optional<Circle> near;
  std::optional<Heading> heading;
};

/// How many times as long a length of the map may be as it is in the query.
struct ScaleRange {
  double low = 1, high = 1;
};

/// Poses this near to one another are the same place for the verdict.
constexpr double kSamePlace_m = 8, kSamePlace_rad = 0.4;
/// Neither farther away nor turned by more than that.
bool samePlace(const PlacePose& a, const PlacePose& b);

/// Which way is up in a frame, and how that is known.
struct Gravity {
  bool known = true;  ///< false: nothing tells; poses of this frame have six degrees of freedom
  Eigen::Quaterniond alignment =
      Eigen::Quaterniond::Identity();  ///< turns the frame so that z points up
  double sigma_rad = 0;  ///< error of that; 0 = z is up by the word of whoever made the frame
  std::string reason = "z is up as given";

  bool turned() const { return alignment.angularDistance(Eigen::Quaterniond::Identity()) > 0; }
};

/// How many degrees of freedom an answer was looked for with.
enum class GravityUse {
  aligned,   ///< x, y, z and heading: z is up in map and query as they are
  levelled,  ///< the same after one of them was turned into gravity alignment
  free       ///< six: the pose itself says which way is up
};

inline const char* toString(GravityUse use) {
  return use == GravityUse::aligned ? "aligned" : use == GravityUse::levelled ? "levelled" : "free";
}

/// What the answer promises.
enum class Status {
  accepted,   ///< the pose is right; precision of accepted answers is the first duty
  ambiguous,  ///< several places explain the query about equally well; the hypotheses list them
  rejected    ///< nothing found that could not be chance
};

const char* toString(Status status);

/// Why an answer has its status, for programs: a closed set (docs/formats.md).
enum class ReasonCode {
  accepted,
  ambiguous,      ///< several places explain the query about equally well
  out_of_map,     ///< too little of the query lies where the map was seen, or nothing agrees
  too_short,      ///< no place stands out; more of the way would tell
  contradicted,   ///< the best place does not hold: points, obstacles or rays contradict it
  not_converged,  ///< the registration does not converge at the best place, or leaves it open
  outside_prior,  ///< what was given about the pose excludes the place, or a better one refutes it
  odometry_jump,  ///< the odometry contradicts its scans, and what is behind it does not suffice
  budget_exhausted,  ///< time or memory ended first
  not_comparable     ///< query or map is empty or too little, or they share no class or size
};

const char* toString(ReasonCode code);

/// Which stage proposed a pose.
enum class Proposer { walks, search };

const char* toString(Proposer proposer);

/// One place where the query may be.
struct Hypothesis {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  double score = 0;  ///< log-likelihood ratio against chance [nats]; comparable within one query
  int inliers = 0;   ///< query vertices with a partner of the same class
  Proposer proposer = Proposer::walks;
};

/// What speaks for an answer, each as log odds of right against wrong.
struct Witnesses {
  double place = 0;            ///< how far the best place stands out of the others
  double correspondences = 0;  ///< how many vertices keep a partner at it
  double dense = 0;            ///< how many points meet the map after the refinement
};

/// A stretch of a map at the best place that is not its own: one sample of the null hypothesis, of
/// what wrong places of this map look like.
struct WrongPlace {
  /// Inlier ratio of its points there above the null inlier ratio, in [-1, 1]; 0 if the
  /// registration does not converge. Nothing for a map without points.
  std::optional<double> above_null;
  /// As Visibility::miss_ratio, there.
  std::optional<double> miss_ratio;
  /// As in Statistics, over the next wrong place.
  std::optional<double> dense_margin, likelihood_margin;
};

/// Conflict ratio and miss ratio at which right and wrong places are about equally frequent.
constexpr double kConflictThreshold = 0.25;

/// Overlaps and conflicts of query and map at a place, both ways. The search does not maximise
/// them: a score is a sum, in which conflicts weigh little where much fits. Nothing where a value
/// would say nothing.
struct Visibility {
  /// Query in map: share of blocks of 4 m of obstacles of the query, where the map was seen, whose
  /// score is negative as a whole, weighted by the score of a true pose there. In [0, 1].
  std::optional<double> conflict_ratio;
  /// Query in map: how far obstacles of the query, of any label, are obstacles of the map where
  /// that was seen. Share of the log-likelihood ratio that a true pose has on average, in
  /// [-1, 1.5].
  std::optional<double> obstacle_overlap;
  /// Map in query: how far obstacles of the map are obstacles of the query where it observed the
  /// ground, in [-1, 1]; negative if the query rather observed free ground. Nothing for bare
  /// graphs, which observe no free ground, for queries that measured little of it, and in rooms,
  /// where furniture occludes furniture.
  std::optional<double> map_overlap;
  /// Map in query: share of blocks of obstacles of the map that the query does not have, as
  /// conflict_ratio; set where map_overlap is.
  std::optional<double> miss_ratio;
};

/// Dense verification of one place: overlaps of query and map, and the registration there.
struct DenseEvidence : Visibility {
  enum class Of : std::uint8_t {
    nothing,  ///< there was nothing to register
    points,   ///< points of query and map
    views     ///< bird's-eye views, where no single point is known well enough
  };
  Of of = Of::nothing;
  bool converged = false;  ///< the registration found a pose near the place
  /// Inlier ratio: how closely points of obstacles lie on points of their class, where the map
  /// holds anything, in [0, 1]; 0 if the registration did not converge.
  double inlier_ratio = 0;
  double null_inlier_ratio = 0;  ///< the inlier ratio some metres off, on average
  /// Split-half self-consistency: inlier ratio of one half of the query in the other, the best that
  /// a true place could have. Set where map_overlap is not.
  std::optional<double> self_consistency;
  /// Free-space violation: share of the map that rays of the query pass through, over the same
  /// share some metres off. See pose::freeSpaceViolation.
  std::optional<double> free_space_violation;
  bool aerial = false;   ///< query or map was recorded from the air
  bool narrow = false;   ///< a camera outdoors: most of what stands around is out of its view
  bool indoors = false;  ///< a camera in rooms, or on a desk

  bool registered() const { return of != Of::nothing; }
};

/// Log-likelihood ratio of a part of a query at a place, and its mean at a true pose [nats].
struct PartEvidence {
  double score = 0, expected = 0;
};

/// What speaks for one place by itself.
struct PlaceEvidence {
  double score = 0;          ///< [nats]
  double expected = 0;       ///< score that a true pose would have on average [nats]
  double map_coverage = 1;   ///< share of the query where the map knows anything
  PartEvidence obstacles;    ///< of bird's-eye views: upright surfaces and obstacles
  bool of_surfaces = false;  ///< as in Statistics
  DenseEvidence dense;
};

/// Medians over the means of 43 maps, for maps that were not measured; of the spread the value that
/// three of four maps stay below.
constexpr double kUsualWrongPlaceAboveNull = 0.10, kUsualWrongPlaceMissRatio = 0.45,
                 kUsualWrongPlaceSpread = 0.07;

/// What the verdict was made of.
struct Statistics {
  bool of_surfaces = false;  ///< scores are those of bird's-eye views, not of vertices
  double likelihood_margin =
      0;                   ///< (s1 - s2) ln(s1 / s2) of the best two places, with noise [nats]
  double score_ratio = 1;  ///< share of the score that a true pose would have, in (0, 1]
  /// Share of the vertices of the query with a partner in the map at the best place, in (0, 1]; 1
  /// if it has none.
  double vertex_inlier_ratio = 1;
  double map_coverage = 1;  ///< share of the query where the map was seen, in (0, 1]
  double dense_margin =
      0;  ///< of dense scores, over the second-best place; see verdict::denseScore [nats]
  DenseEvidence dense;
  /// Means over wrong places of the map at hand (WrongPlace), its perceptual aliasing. Those of a
  /// usual map where none were measured.
  double wrong_place_above_null = kUsualWrongPlaceAboveNull;
  double wrong_place_miss_ratio = kUsualWrongPlaceMissRatio;
  double wrong_place_spread = kUsualWrongPlaceSpread;  ///< standard deviation of `above_null`
  /// How much more of the surfaces of the query lie on those of the map at the pose that local
  /// features say than at any other that they say, as a ratio >= 1. Set if that is the pose.
  std::optional<double> feature_margin;
  std::optional<double> storeys;  ///< of the map, each of which was searched; set if it has several
  /// What another storey scores at the same pose in the plane, at most, over the score here; where
  /// nobody walked also 2/3 of what it scores anywhere. Or how well the query lies on a map of one
  /// plane at another height, over how well it lies here. Set with `storeys`, and where an answer
  /// of one plane would be accepted.
  std::optional<double> other_storey;
  double sigma_m = 0;  ///< largest standard deviation of the registered position in the plane, in
                       ///< canonical lengths; 0 = not known
};

/// Milliseconds per stage, in the order of execution.
using Timings = std::vector<std::pair<std::string, double>>;

double timeOf(const Timings& timings, const std::string& stage);  ///< 0 if there is no such stage
double totalMs(const Timings& timings);  ///< "total", or the sum of the stages

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The answer to one query. Poses are those of the best hypothesis, also when it was not accepted;
/// they are valid only if `hypotheses` is not empty.
struct Localization {
  Status status = Status::rejected;
  std::string reason;  ///< one sentence with the deciding numbers
  ReasonCode reason_code = ReasonCode::not_comparable;
  double confidence =
      0;  ///< in [0, 1], monotone in how sure the program is; comparable between queries
  Witnesses witnesses;
  Statistics statistics;
  Eigen::Isometry3d T_map_query =
      Eigen::Isometry3d::Identity();  ///< query odometry frame to map frame
  Eigen::Isometry3d T_map_sensor =
      Eigen::Isometry3d::Identity();  ///< of the last frame of the query
  Matrix6d covariance =
      Matrix6d::Zero();  ///< of T_map_sensor: x y z [m], rx ry rz [rad], map frame, left increment
  double scale = 1;      ///< length in the map over length in the query; see options.scale
  GravityUse gravity = GravityUse::aligned;
  std::string gravity_reason;  ///< which way is up in query and map, and how that is known
  int inliers = 0;
  int vertices = 0;  ///< of the query graph
  int matches = 0;   ///< putative correspondences tried
  /// Tightest tolerance at which more than six of these agree with the pose that they propose, the
  /// consensus value s of X-View [m]; infinite if fewer do, and unless the method is walks.
  double consensus_m = std::numeric_limits<double>::infinity();
  std::vector<Hypothesis> hypotheses;  ///< best first, distinct places
  /// T_map_sensor of every frame of the query as the posterior bends its odometry; empty if that
  /// did not converge.
  std::vector<Eigen::Isometry3d> trajectory;
  std::vector<Correspondence> putative;
  std::vector<Correspondence> kept;
  Timings timing_ms;

  bool accepted() const { return status == Status::accepted; }
};

/// Milliseconds of wall time since construction or the last lap.
class Stopwatch {
 public:
  double lap_ms() {
    const auto now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace xview
