// SPDX-License-Identifier: BSD-3-Clause
#include "drawn_answers.h"

#include <fmt/core.h>

#include <filesystem>

#include "frames_to_cloud.h"
#include "xview/graph/blobs.h"
#include "xview/io/graph_files.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

bool isGraph(const std::string& path) {
  return std::filesystem::path(path).extension() == ".ply" &&
         recogniseInput(path) == InputKind::graph;
}

/// The rectangle around a cloud, in the colour of the answer.
SceneLine outlineOf(const LabelledCloud& cloud, const SceneQuery& query) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < cloud.size(); ++i) box.extend(cloud.position(i));
  SceneLine line;
  line.name = std::string("query, ") + toString(query.status);
  line.color = statusColor(query.status);
  for (const int corner : {0, 1, 3, 2, 0}) {
    line.points.push_back(query.T_map_query *
                          box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  return line;
}

/// Lengths of the query become those of the map.
void scaleBy(double scale, SemanticGraph& graph) {
  for (Vertex& v : graph.vertices) v.position *= scale;
}
void scaleBy(double scale, LabelledCloud& cloud) {
  cloud.origin *= scale;
  for (Point& p : cloud.points) p.getVector3fMap() *= static_cast<float>(scale);
}

}  // namespace

const FrameSource* DrawnAnswers::recordingOf(const std::string& path) {
  const auto known = recordings_.find(path);
  if (known != recordings_.end()) return known->second.get();
  std::unique_ptr<FrameSource> recording;
  try {
    InputOptions whole = input_.parsed();
    whole.frames = {};
    recording = openRecording(path, whole);
  } catch (const Error& e) {
    job_.narrate.note(fmt::format("only the poses of {} are drawn: {}", path, e.what()));
  }
  return recordings_.emplace(path, std::move(recording)).first->second.get();
}

SceneQuery DrawnAnswers::draw(const Answer& answer) {
  SceneQuery query;
  query.name = fmt::format("{} {}-{}", answer.input, answer.first_frame, answer.last_frame);
  query.status = answer.fix.status;
  query.T_map_query = answer.fix.T_map_sensor;
  query.poses = {Eigen::Isometry3d::Identity()};  // as if its odometry began there
  if (!std::filesystem::exists(answer.input)) return query;
  if (isGraph(answer.input)) {
    graphs_.push_back(readGraph(answer.input).graph);
    scaleBy(answer.fix.scale, graphs_.back());
    query.graph = &graphs_.back();
  } else if (const FrameSource* recording = recordingOf(answer.input)) {
    drawWay(*recording, answer, query);
  }
  return query;
}

void DrawnAnswers::drawWay(const FrameSource& recording, const Answer& answer, SceneQuery& query) {
  std::vector<Eigen::Isometry3d> way;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const std::int64_t number = recording.number(i);
    if (number < answer.first_frame || number > answer.last_frame) continue;
    way.push_back(recording.pose(i));
    way.back().translation() *= answer.fix.scale;
  }
  if (way.empty()) return;  // another recording than the one that was answered
  if (recording.sensor() == Sensor::lidar) query.forward = Eigen::Vector3d::UnitX();
  query.T_map_query = answer.fix.T_map_sensor * way.back().inverse();
  query.poses = std::move(way);
  if (recording.sensor() == Sensor::cloud) drawCloud(recording, answer.fix.scale, query);
}

void DrawnAnswers::drawCloud(const FrameSource& recording, double scale, SceneQuery& query) {
  LiftCounts counts;
  LabelledCloud cloud = liftAll(recording, job_, counts);
  scaleBy(scale, cloud);
  clouds_.push_back(voxel_m_ > 0 ? thinByVoxel(cloud, voxel_m_) : std::move(cloud));
  query.cloud = &clouds_.back();
  outlines_.push_back(outlineOf(clouds_.back(), query));
  query.poses.clear();  // the origin of a cloud is no place where anything was
}

}  // namespace xview::tools
