// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/eval/consistency.h"
#include "xview/eval/precision_recall.h"
#include "xview/types/localization.h"

namespace xview {

/// An answered query beside the truth.
struct ScoredQuery {
  std::string input;
  std::int64_t first_frame = 0, last_frame = 0;
  Status status = Status::rejected;
  double confidence = 0;
  bool negative = false;  ///< from elsewhere: any acceptance is false, and there is no truth
  bool has_pose = false;  ///< false: not even a rejected hypothesis
  Eigen::Isometry3d estimate =
      Eigen::Isometry3d::Identity();                        ///< T_map_sensor; valid with has_pose
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();  ///< T_map_sensor; valid unless negative
  bool has_covariance = false;
  Matrix6d covariance = Matrix6d::Zero();  ///< of the estimate; valid with has_covariance
  Timings timing_ms;                       ///< per stage, and "total"

  double positionError() const;  ///< [m]; infinite without a pose
  double rotationError() const;  ///< [rad]; infinite without a pose
  double totalMs() const;        ///< 0 if unknown
};

/// Success over distance and angle for one choice of answers.
struct SuccessTable {
  std::vector<double> within_m;    ///< share for each of kDistances_m
  std::vector<double> within_deg;  ///< share for each of kAngles_deg
  double median_m = 0, p90_m = 0, median_deg = 0,
         p90_deg = 0;  ///< of the answers that have a pose; NaN if none
};

extern const std::vector<double> kDistances_m;  ///< 1, 2, 5, 10, 20, 30
extern const std::vector<double> kAngles_deg;   ///< 1, 2, 5, 10

/// What a set of answers is worth. Ratios are NaN where nothing was asked.
struct Evaluation {
  double correct_within_m = 0;
  std::size_t queries = 0;                                ///< with truth
  std::size_t negatives = 0;                              ///< from elsewhere
  std::size_t accepted = 0, ambiguous = 0, rejected = 0;  ///< of the queries with truth
  std::size_t false_accepts = 0;                          ///< of the negatives
  SuccessTable
      best;  ///< best hypothesis of every query, accepted or not (the paper's success rate)
  SuccessTable believed;  ///< accepted answers only; the share is still of all queries
  double precision = 0, recall = 0, f1 = 0;  ///< of the program's own verdict
  double area_under_pr = 0;
  Consistency consistency;             ///< of the covariances of accepted answers that are correct
  double median_ms = 0, p90_ms = 0;    ///< total per query
  Timings stages_ms;                   ///< median of each stage, in the order of execution
  std::vector<PrecisionRecall> curve;  ///< over the confidence
};

/// A pose is correct if its position is within `correct_within_m` of the truth (paper, section IV:
/// 20 or 30 m).
Evaluation evaluate(const std::vector<ScoredQuery>& queries, double correct_within_m);

}  // namespace xview
