// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace xview {

/// One answer as a detection: how sure the program was, and whether it was right.
struct Detection {
  double confidence = 0;
  bool correct = false;
};

/// Precision and recall if exactly the answers with at least this confidence are believed.
struct PrecisionRecall {
  double threshold = 0;
  double precision = 0;
  double recall = 0;
};

/// One point per distinct confidence, from the surest answer down. `positives` is the number of
/// answers that could have been correct; detections from elsewhere can only be wrong and do not
/// count there.
std::vector<PrecisionRecall> precisionRecallCurve(std::vector<Detection> detections,
                                                  std::size_t positives);

/// Area under the curve as average precision: sum of (R_k - R_k-1) P_k, without interpolation,
/// which would flatter.
double averagePrecision(const std::vector<PrecisionRecall>& curve);

/// Harmonic mean; 0 if both are 0, NaN if either is unknown.
double f1Score(double precision, double recall);

}  // namespace xview
