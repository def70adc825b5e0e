// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "answer.h"
#include "inputs.h"
#include "xview/view/scene.h"

namespace xview::tools {

/// Answers as they are drawn into the map: with the way of the query if its recording is still
/// there, else with the pose alone. What has no way, a cloud or a graph, is drawn itself.
class DrawnAnswers {
 public:
  DrawnAnswers(const InputFlags& input, double voxel_m, const Job& job)
      : input_(input), voxel_m_(voxel_m), job_(job) {}

  /// The clouds and graphs in the result live as long as this object.
  SceneQuery draw(const Answer& answer);
  const std::vector<SceneLine>& outlines() const { return outlines_; }  ///< of the clouds drawn

 private:
  const FrameSource* recordingOf(const std::string& path);  ///< null if it cannot be opened
  void drawWay(const FrameSource& recording, const Answer& answer, SceneQuery& query);
  void drawCloud(const FrameSource& recording, double scale, SceneQuery& query);

  const InputFlags& input_;
  double voxel_m_;
  const Job& job_;
  std::map<std::string, std::unique_ptr<FrameSource>> recordings_;
  std::deque<LabelledCloud> clouds_;
  std::deque<SemanticGraph> graphs_;
  std::vector<SceneLine> outlines_;
};

}  // namespace xview::tools
