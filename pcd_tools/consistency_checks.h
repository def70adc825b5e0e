// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "narrative.h"
#include "tool.h"
#include "xview/map/semantic_map.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview::tools {

/// True if most of the poses are where one of the others is.
bool areSamePoses(const std::vector<Eigen::Isometry3d>& poses,
                  const std::vector<Eigen::Isometry3d>& others, double tolerance_m);

/// Notes if a query is a drive that the map was made of, which is found whatever the map is worth.
void logOwnDrive(const map::SemanticMap& map, const std::string& query,
                 const std::vector<Eigen::Isometry3d>& T_odom_sensor, const Narrative& narrate);

/// Why something should not be added to a map: it is in it already, or lies as if its frame were
/// another one: far away, or so that what both have seen is not the same. Nothing if it may.
std::optional<std::string> objectionTo(const map::SemanticMap& addition,
                                       const map::SemanticMap& map, const std::string& map_name,
                                       const Options& options);

/// Throws Error with the objection, if there is one.
void requireFits(const map::SemanticMap& map, const std::string& map_name,
                 const map::SemanticMap& addition, const Job& job);

/// Notes the objection, if there is one.
void logConsistencyChecks(const map::SemanticMap& map, const std::string& map_name,
                          const map::SemanticMap& addition, const Options& options,
                          const Narrative& narrate);

/// The same for recordings that become one map at once: each of them by itself, made of some of its
/// frames, against the one before it that it lies nearest to. A heap, of which half does not fit,
/// is an Error unless the user wants it so.
class SketchedRecordings {
 public:
  /// `sources` must outlive this.
  SketchedRecordings(const std::vector<const FrameSource*>& sources, const Options& options)
      : sources_(sources), options_(options) {}
  /// In order of the recordings and of their frames.
  void add(const FrameSource& source, const PreprocessedFrame& frame);
  void check(bool accept_all, const Narrative& narrate);

 private:
  void finishLast();

  std::vector<const FrameSource*> sources_;
  Options options_;
  std::vector<map::SemanticMap> sketches_;  ///< of the recordings before the last
  std::unique_ptr<PlaceBuilder> last_;
  std::size_t frames_ = 0;  ///< of the last
};

}  // namespace xview::tools
