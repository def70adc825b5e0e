// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/localization.h"
#include "xview/types/semantic_place.h"

namespace xview::map {

/// A place that is kept in a file, to localize in. Its poses, frames and stamps are key frames.
struct SemanticMap : Place {
  std::vector<std::uint32_t> source_of_pose;  ///< per key frame, a position in `sources`
  std::vector<std::string> sources;           ///< inputs it was built from, in order
  std::string options_yaml;                   ///< effective options of the last build
  std::vector<LookAlike> look_alikes;         ///< some of its own stretches; see lookAlikesOf

  void addKeyframe(const Eigen::Isometry3d& T_map_sensor, std::int64_t frame, double stamp_s,
                   std::uint32_t source) {
    poses.push_back(T_map_sensor);
    frames.push_back(frame);
    stamps_s.push_back(stamp_s);
    source_of_pose.push_back(source);
  }
};

}  // namespace xview::map
