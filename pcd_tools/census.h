// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <string>

#include "xview/types/frame.h"
#include "xview/types/graph.h"

namespace xview::tools {

/// What some points, pixels or vertices hold: how many of each class, and where.
struct Census {
  std::map<std::uint32_t, std::size_t> counts;
  Eigen::AlignedBox3d bounds;  ///< [m]
  std::size_t measured = 0;    ///< points that are there, or pixels with depth
  std::size_t size = 0;        ///< points or pixels
  std::string camera;          ///< in words; empty if there is none
};

Census censusOf(const Frame& frame);  ///< in the frame of the sensor; a camera frame has no bounds
Census censusOf(const LabelledCloud& cloud);
Census censusOf(const SemanticGraph& graph);

void printRow(const std::string& name, const std::string& value);
void printBounds(const std::string& name, const Eigen::AlignedBox3d& box);
void printClasses(const Census& census, const LabelSet& labels, const char* unit);

}  // namespace xview::tools
