// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "outputs.h"
#include "place/lift.h"
#include "scenes.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

/// Frames whose points are drawn: of one answer, and of all together. More would take minutes and
/// hide one another.
constexpr std::size_t kFramesOfAnswer = 8, kFramesOfAll = 160;

/// Thinning a small cloud would only take the room or the desk from it.
LabelledCloud thinned(LabelledCloud cloud, double voxel_m) {
  constexpr std::size_t kSmall = 100000;
  if (voxel_m <= 0 || cloud.size() <= kSmall) return cloud;
  return thinByVoxel(cloud, voxel_m);
}

bool isBareCloud(const std::string& path) { return io::readCloudHeader(path).label_field.empty(); }

/// A cloud without labels, in grey.
Place greyCloud(const std::string& path, double voxel_m) {
  ClassInfo grey;
  grey.id = 1;
  grey.name = "without label";
  grey.color = {150, 150, 150};
  grey.role = Role::surface;
  grey.kind = Kind::other_surface;
  Place place;
  place.labels = LabelSet("none");
  place.labels.add(grey);
  place.cloud = io::readCloud(path, {}, false);
  for (Point& p : place.cloud.points) p.label = grey.id;
  place.cloud = thinned(std::move(place.cloud), voxel_m);
  return place;
}

}  // namespace

Place readDrawable(const std::string& path, io::InputOptions input, const Job& job,
                   double voxel_m) {
  constexpr std::size_t kFewest = 1000, kMost = 5000000;  // points whose shapes are looked for
  if (auto stored = readStored(path, input, job)) return std::move(*stored);
  const bool is_bare = io::recogniseInput(path, input) == io::InputKind::cloud && isBareCloud(path);
  if (is_bare) {
    const std::size_t points = io::readCloudHeader(path).points;
    if (points < kFewest || points > kMost) return greyCloud(path, voxel_m);
  }
  Place place;
  try {
    const auto source = openInput(path, input, job);
    place.labels = source->labels();
    // A cloud of its own was seen from nowhere in particular.
    const bool is_way = source->size() > 1 || source->sensor() != Sensor::cloud;
    for (std::size_t i = 0; is_way && i < source->size(); ++i)
      place.poses.push_back(source->pose(i));
    place.cloud = source->size() == 1 ? thinned(liftAll(*source, job, 0), voxel_m)
                                      : liftAll(*source, job, voxel_m);
  } catch (const Error&) {
    if (!is_bare) throw;  // one wants to see a cloud in millimetres, too
    return greyCloud(path, voxel_m);
  }
  return place;
}

std::string foundPath(const std::string& input, const std::string& answers_path,
                      const std::vector<std::string>& given) {
  if (fs::exists(input)) return input;
  for (fs::path folder = fs::absolute(answers_path).parent_path();; folder = folder.parent_path()) {
    if (fs::exists(folder / input)) return (folder / input).string();
    if (!folder.has_relative_path()) break;
  }
  const auto same = [&](const std::string& path) {
    return fs::path(path).filename() == fs::path(input).filename();
  };
  const auto found = std::find_if(given.begin(), given.end(), same);
  return found == given.end() ? input : *found;
}

std::string DrawnAnswers::mapBehind(const std::string& answers_path) const {
  const std::vector<Answer> answers = readAnswers(answers_path);
  for (const std::string& file : given_) {
    const std::string ending = endingOf(file);
    const bool is_query = std::any_of(answers.begin(), answers.end(), [&](const Answer& answer) {
      std::error_code problem;
      return fs::equivalent(file, foundPath(answer.input, answers_path, given_), problem);
    });
    if (!is_query && ending != ".jsonl" && ending != ".tum" && ending != ".txt") return {};
  }
  const std::string& map = answers[0].map;
  const std::string path = foundPath(map, answers_path, given_);
  if (!map.empty() && fs::exists(path)) {
    job_.narrate.note(fmt::format("{} is drawn, in which {} was answered", path, answers_path));
    return path;
  }
  job_.narrate.note(fmt::format("no map is drawn: {}; give it before {}",
                                map.empty() ? answers_path + " names none" : map + " is not found",
                                answers_path));
  return {};
}

bool DrawnAnswers::isQuery(const std::string& path) const {
  return std::any_of(drawn_.begin(), drawn_.end(), [&](const std::string& drawn) {
    std::error_code problem;
    return fs::equivalent(path, drawn, problem);
  });
}

const FrameSource* DrawnAnswers::recordingOf(const std::string& path) {
  const auto known = recordings_.find(path);
  if (known != recordings_.end()) return known->second.get();
  std::unique_ptr<FrameSource> recording;
  try {
    io::InputOptions whole = input_.parsed();
    whole.frames = {};
    recording = io::openRecording(path, whole);
  } catch (const Error& e) {
    job_.narrate.note(fmt::format("only the poses of {} are drawn: {}", path, e.what()));
  }
  return recordings_.emplace(path, std::move(recording)).first->second.get();
}

std::vector<SceneQuery> DrawnAnswers::draw(const std::string& answers_path, JoinedLabels& joined,
                                           bool with_recordings) {
  const std::vector<Answer> answers = readAnswers(answers_path);
  const std::size_t frames =
      std::clamp<std::size_t>(kFramesOfAll / answers.size(), 1, kFramesOfAnswer);
  const std::size_t step = 1 + (answers.size() - 1) / kFramesOfAll;  // answers with a cloud
  if (step > 1)
    job_.narrate.note(
        fmt::format("{}: one answer of {} is drawn with its points", answers_path, step));
  std::vector<SceneQuery> queries;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const Answer& answer = answers[i];
    SceneQuery query = queryOf(answer.fix);
    query.name = nameOf(answer);
    query.T_map_query = answer.fix.T_map_sensor;
    query.poses = {Eigen::Isometry3d::Identity()};  // as if its odometry began there
    const std::string path = foundPath(answer.input, answers_path, given_);
    const bool is_drawn = query.has_pose && with_recordings;
    if (is_drawn && fs::exists(path)) {
      drawn_.push_back(path);
      const io::InputKind kind = io::recogniseInput(path, input_.parsed());
      if (kind == io::InputKind::graph || kind == io::InputKind::map ||
          (kind == io::InputKind::cloud && isBareCloud(path)))
        drawPlace(path, kind, answer, joined, query);
      else if (const FrameSource* recording = recordingOf(path))
        drawRecording(*recording, answer, i % step == 0 ? frames : 0, joined, query);
    } else if (is_drawn) {
      job_.narrate.note(fmt::format("only the poses of {} are drawn: it is not found", path));
    }
    queries.push_back(std::move(query));
  }
  return queries;
}

/// `arrow`: in the frame of the query, in lengths of the map.
void DrawnAnswers::place(const Eigen::Isometry3d& arrow, const Answer& answer, SceneQuery& query) {
  query.T_map_query = answer.fix.T_map_query;
  query.poses = {arrow};
  if (!answer.fix.covariance.isZero())
    query.sigma_m =
        positionSigma(movedTo(arrow.translation() / answer.fix.scale, answer.fix).covariance);
}

void DrawnAnswers::keep(Place drawn, JoinedLabels& joined, SceneQuery& query) {
  joined.adopt(drawn);
  places_.push_back(std::move(drawn));
  if (!places_.back().graph.empty()) query.graph = &places_.back().graph;
  if (!places_.back().cloud.empty()) query.cloud = &places_.back().cloud;
}

/// What is one thing in one frame: a graph, a map, a cloud.
void DrawnAnswers::drawPlace(const std::string& path, io::InputKind kind, const Answer& answer,
                             JoinedLabels& joined, SceneQuery& query) {
  io::InputOptions input = input_.parsed();
  if (kind == io::InputKind::graph) input.map_labels = joined.labels();
  Place drawn = readDrawable(path, input, job_, voxel_m_);
  query.forward = Eigen::Vector3d::UnitX();
  if (kind != io::InputKind::map) {
    drawn.poses = {Eigen::Isometry3d::Identity()};
    scaleLengths(answer.fix.scale, drawn);
    place(arrowPose(drawn), answer, query);
  } else if (!drawn.poses.empty()) {
    query.forward = Eigen::Vector3d::UnitZ();
    query.T_map_query = answer.fix.T_map_query;
    query.poses = drawn.poses;
  }
  if (kind == io::InputKind::map) drawn.graph = {};  // its points show more
  keep(std::move(drawn), joined, query);
}

void DrawnAnswers::drawRecording(const FrameSource& recording, const Answer& answer,
                                 std::size_t most_frames, JoinedLabels& joined, SceneQuery& query) {
  std::vector<std::size_t> window;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const std::int64_t number = recording.number(i);
    if (number >= answer.first_frame && number <= answer.last_frame) window.push_back(i);
  }
  if (window.empty()) return;  // another recording than the one that was answered
  if (recording.sensor() != Sensor::camera) query.forward = Eigen::Vector3d::UnitX();
  query.poses.clear();
  for (const std::size_t i : window) {
    query.poses.push_back(recording.pose(i));
    query.poses.back().translation() *= answer.fix.scale;
  }
  query.T_map_query = answer.fix.T_map_query;
  Place drawn;
  drawn.labels = recording.labels();
  LabelledCloud& cloud = drawn.cloud;
  const std::size_t count = std::min(most_frames, window.size());
  for (std::size_t k = 0; k < count; ++k) {  // evenly, the last one always
    const Frame frame = recording.read(window[window.size() - 1 - k * window.size() / count]);
    const auto& labels = drawn.labels;
    cloud.append(voxel_m_ > 0
                     ? liftThin(frame, labels, job_.options.lift, voxel_m_, WholeClasses::none).thin
                     : lift(frame, labels, job_.options.lift));
  }
  if (count > 1 && voxel_m_ > 0) cloud = thinByVoxel(cloud, voxel_m_);
  if (cloud.empty()) return;
  scaleLengths(answer.fix.scale, cloud);
  if (recording.sensor() == Sensor::cloud && window.size() == 1)
    place(arrowPose(cloud, query.poses[0]), answer, query);
  keep(std::move(drawn), joined, query);
}

}  // namespace xview::tools
