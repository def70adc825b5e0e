// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "localizer/tracker.h"
#include "xview/base/localization.h"
#include "xview/io/pose_files.h"
#include "xview/map/semantic_map.h"
#include "xview/sequence.h"

namespace xview::tools {

/// The answer to one query with what identifies the query.
struct Answer {
  std::string input;             ///< path as given
  std::string map;               ///< path of the MAP as given
  std::string map_checksum;      ///< 16 digits that tell it from any other map
  std::int64_t first_frame = 0;  ///< numbers of the frames, both inclusive
  std::int64_t last_frame = 0;
  std::size_t used_from = 0;   ///< position of the first frame that took part
  std::size_t last_index = 0;  ///< position of the last frame in the recording
  std::size_t frames = 1;      ///< length of the recording
  double last_stamp_s = 0;
  double heading_rad = 0;  ///< where the sensor of the last frame looks in the map
  double load_map_ms = 0;
  std::string error;             ///< why the query could not be read; then there is no fix
  std::string size;              ///< of the place, see base/semantic_place.h
  std::string budget_exhausted;  ///< Budget::exhausted()
  Localization fix;
  bool whole_statistics = false;           ///< read from a file that has all those of today
  std::optional<bool> right;               ///< as a file with checked answers says
  std::string make;                        ///< of world and sensor, as such a file says
  std::optional<SequenceAnswer> sequence;  ///< with --sequence
  std::optional<TrackAnswer> track;        ///< with --track
};

/// Takes points of the query as they are, in its own lengths, to the map: a pose times the scale
/// of the answer.
Eigen::Matrix4d inLengthsOfQuery(const Eigen::Isometry3d& T_map_query, double scale);

/// One JSON object on one line, keys in a fixed order, numbers such that reading them gives the
/// same bits. Poses and covariance are null if there is no hypothesis at all, and of a query that
/// could not be read, whose status is "error".
std::string toJson(const Answer& answer);

/// Reads a line that `xview localize --json` printed, or one with the same keys; of the fix only
/// status, reason, confidence, statistics, the poses, the counts and the times. Throws Error, which
/// names `where`.
Answer answerIn(const std::string& line, const std::string& where);
/// Reads all lines of a file of answers. Keys that only xview writes may be missing (Answer::frames
/// is then 0). Queries that could not be read are left out. Throws Error with path:line.
std::vector<Answer> readAnswers(const std::string& path);

/// What all answers share that are sought in a map. `path`: the MAP as given.
Answer unansweredIn(const map::SemanticMap& map, const std::string& path, double load_map_ms);

/// True poses of the frames of a recording, found by the rule of all poses files: one line per
/// frame, or more lines, of which line N (from 0) belongs to frame N. A real time stamp that both
/// sides have settles the second case first.
class Truth {
 public:
  explicit Truth(const std::string& path) : path_(path), poses_(io::readPoses(path)) {}

  /// T_map_sensor of the last frame of the query. Throws Error if the file has none.
  const Eigen::Isometry3d& poseFor(const Answer& answer) const;

 private:
  const io::StampedPose* withStamp(const Answer& answer) const;

  std::string path_;
  std::vector<io::StampedPose> poses_;
};

}  // namespace xview::tools
