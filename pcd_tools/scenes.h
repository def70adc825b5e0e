// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "answer.h"
#include "answer_table.h"
#include "inputs.h"
#include "view/scene.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// A picture of a map, which must outlive it.
Scene sceneOf(const Place& map);

/// The command line as it could be typed again, the version and the date, which $SOURCE_DATE_EPOCH
/// can set.
std::string madeBy(const Job& job);

/// The same answer about another point of its query than the sensor.
Localization movedTo(const Eigen::Vector3d& p_query, Localization fix);

/// What an answer says about its query; its graph, cloud and way are left empty.
SceneQuery queryOf(const Localization& fix);

/// "accepted, ±2 cm" of one query, "8 of 9 found, ±2 cm" of several.
std::string outcomeOf(const std::vector<SceneQuery>& queries);

/// Where the arrow of a cloud or graph is drawn: at its origin if that is in the midst of it, else
/// in its middle, as of a cloud in coordinates of a country. Turned as `origin` is.
Eigen::Isometry3d arrowPose(const LabelledCloud& cloud,
                            const Eigen::Isometry3d& origin = Eigen::Isometry3d::Identity());
Eigen::Isometry3d arrowPose(const SemanticGraph& graph);
Eigen::Isometry3d arrowPose(const Query& query);  ///< of a drive at its last pose

/// The query with its graph, its cloud and its correspondences; it must outlive the result.
SceneQuery queryWith(const Query& query, const Localization& fix);

/// Brings places of several label sets under one: classes of the same name are the same.
class JoinedLabels {
 public:
  const LabelSet& labels() const { return labels_; }
  /// Begins with a set whose ids stay as they are.
  void take(const LabelSet& first) { labels_ = first; }
  /// Its graph and cloud get the ids of the joined set.
  void adopt(Place& place);

 private:
  std::map<std::uint32_t, std::uint32_t> idsFor(const LabelSet& its_labels);
  LabelSet labels_;
};

/// What is drawn of a map, a graph or a recording: of the latter its points, thinned, and the poses
/// of its way. A cloud without labels has those of its shapes; one that is too small or too large
/// for them is grey.
Place readDrawable(const std::string& path, io::InputOptions input, const Job& job, double voxel_m);

/// A path of an answer, sought from the working folder, from the folder of the answers and those
/// above it, and by its name among the other files that were given; as it is if nothing is there.
std::string foundPath(const std::string& input, const std::string& answers_path,
                      const std::vector<std::string>& given);

/// Answers as they are drawn into the map: with the way and the cloud of the query if its recording
/// is found, else with the pose alone.
class DrawnAnswers {
 public:
  DrawnAnswers(const InputFlags& input, double voxel_m, const Job& job,
               std::vector<std::string> given)
      : input_(input), voxel_m_(voxel_m), job_(job), given_(std::move(given)) {}

  /// All answers of a file, with their recordings if they are wanted. Clouds and graphs in the
  /// result live as long as this object.
  std::vector<SceneQuery> draw(const std::string& answers_path, JoinedLabels& joined,
                               bool with_recordings = true);
  /// The map that the answers name, if no other file than queries and ways was given and it is
  /// found; says so, or which map is missing.
  std::string mapBehind(const std::string& answers_path) const;
  /// True for a file that an answer speaks of: it is drawn at its answer's pose.
  bool isQuery(const std::string& path) const;

 private:
  const FrameSource* recordingOf(const std::string& path);  ///< null if it cannot be opened
  void drawPlace(const std::string& path, io::InputKind kind, const Answer& answer,
                 JoinedLabels& joined, SceneQuery& query);
  void drawRecording(const FrameSource& recording, const Answer& answer, std::size_t most_frames,
                     JoinedLabels& joined, SceneQuery& query);
  static void place(const Eigen::Isometry3d& arrow, const Answer& answer, SceneQuery& query);
  void keep(Place drawn, JoinedLabels& joined, SceneQuery& query);

  const InputFlags& input_;
  double voxel_m_;
  const Job& job_;
  std::vector<std::string> given_, drawn_;
  std::map<std::string, std::unique_ptr<FrameSource>> recordings_;
  std::deque<Place> places_;
};

}  // namespace xview::tools
