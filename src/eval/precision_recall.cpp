// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/precision_recall.h"

#include <algorithm>

namespace xview {

std::vector<PrecisionRecall> precisionRecallCurve(std::vector<Detection> detections,
                                                  std::size_t positives) {
  std::sort(detections.begin(), detections.end(),
            [](const Detection& a, const Detection& b) { return a.confidence > b.confidence; });
  std::vector<PrecisionRecall> curve;
  std::size_t correct = 0;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    correct += detections[i].correct;
    const bool tied =
        i + 1 < detections.size() && detections[i + 1].confidence == detections[i].confidence;
    if (tied) continue;  // equally sure answers are believed together
    const auto hits = static_cast<double>(correct);
    curve.push_back({detections[i].confidence, hits / static_cast<double>(i + 1),
                     positives == 0 ? 0 : hits / static_cast<double>(positives)});
  }
  return curve;
}

double averagePrecision(const std::vector<PrecisionRecall>& curve) {
  double area = 0, recall = 0;
  for (const PrecisionRecall& point : curve) {
    area += (point.recall - recall) * point.precision;
    recall = point.recall;
  }
  return area;
}

double f1Score(double precision, double recall) {
  const double sum = precision + recall;
  return sum == 0 ? 0 : 2 * precision * recall / sum;
}

}  // namespace xview
