// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/base/frame.h"
#include "xview/options.h"

namespace xview {

/// Scale of a place (base/semantic_place.h), and the measurement that it follows from.
struct MeasuredSize {
  double size = 1;
  std::string reason;
};

/// Of some frames, evenly spread over all of them: of a sensor how far away what it sees is, of a
/// cloud without view-points how far and how high it reaches.
MeasuredSize measureSize(const std::vector<const FrameSource*>& recordings);
/// The same of one frame.
MeasuredSize measureSize(const Frame& frame);
/// Of a bare graph: how far its vertices are apart and how far it reaches.
MeasuredSize measureSize(const SemanticGraph& graph);

/// What options.size says, else what is measured.
template <class Measured>
double sizeFor(const Options& options, const Measured& data) {
  const auto given = parseSize(options.size);
  return given ? *given : measureSize(data).size;
}

}  // namespace xview
