// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/mapper.h"

namespace xview {

/// Watches what became of the measurements of a recording, to name a wrong depth scale instead of mapping nonsense.
class DepthPlausibility {
 public:
  void add(const FrameDigest& frame);

  /// Throws Error if next to nothing that was measured is within the range limits, or if depths are suspiciously small and frames
  /// contradict one another, while depths ten, a hundred or a thousand times as large would agree (agreementOfDepths). A recording that
  /// is merely unusual passes.
  void require(const FrameSource& source) const;

 private:
  LiftCounts counts_;
  std::vector<float> median_ranges_;  ///< of frames
};

/// What becomes of the pixels of one frame in another one, if depths times a scale and the poses are right.
struct DepthAgreement {
  double visible = 0;   ///< share of the pixels that the other frame should see
  double agreeing = 0;  ///< share of these that it measures there, within 5 %
};

DepthAgreement agreementOfDepths(const Frame& a, const Frame& b, double scale);

}  // namespace xview
