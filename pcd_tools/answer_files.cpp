// SPDX-License-Identifier: BSD-3-Clause
#include "answer_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "outputs.h"
#include "scenes.h"
#include "xview/io/atomic_file.h"
#include "xview/types/error.h"
#include "xview/view/color_mesh.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

/// Grows with the root of the way.
Matrix6d odometryCovariance(double way_m, const pose::PosteriorOptions& odometry) {
  const double root = std::sqrt(std::max(way_m, 1e-3));
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(std::pow(odometry.odometry_sigma_m * root, 2));
  covariance.diagonal().tail<3>().setConstant(std::pow(odometry.odometry_sigma_rad * root, 2));
  return covariance;
}

bool isPage(const std::string& path) { return fs::path(path).extension() == ".html"; }
bool isOneFile(const std::string& path) { return fs::path(path).extension() == ".csv"; }

/// Without ending: FILE of FILE.csv, or QUERY_FIRST-LAST in that folder.
std::string stemOf(const std::string& path, int query, const Answer& answer) {
  if (isOneFile(path)) return fs::path(path).replace_extension().string();
  return fmt::format("{}/{:04}_{}-{}", path, query, answer.first_frame, answer.last_frame);
}

std::string numberOrNothing(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : std::string();
}

std::string csvLine(const Contribution& c) {
  const Eigen::Vector3d& p = c.map_position;
  std::string line = fmt::format("{},{},{},{:.3f},{:.3f},{:.3f},{},{},",
                                 c.kind == Contribution::Kind::sample ? "sample" : "vertex", c.name,
                                 toString(c.testimony), p.x(), p.y(), p.z(),
                                 numberOrNothing(c.nats, 3), numberOrNothing(c.expected, 3));
  if (c.partner_index) line += fmt::format("{}", *c.partner_index);
  line += c.partner ? fmt::format(",{:.3f},{:.3f},{:.3f},", c.partner->x(), c.partner->y(),
                                  c.partner->z())
                    : std::string(",,,,");
  return line + numberOrNothing(c.residual_m, 3) + "\n";
}

std::string toCsv(const Answer& answer, const Explanation& explanation) {
  std::string text = fmt::format("# {}: {}; confidence {:.4f}\n", toString(answer.fix.status),
                                 answer.fix.reason, answer.fix.confidence);
  text += "kind,name,testimony,x,y,z,nats,expected_nats,map_vertex,map_x,map_y,map_z,residual_m\n";
  for (const Contribution& c : explanation.contributions) text += csvLine(c);
  return text;
}

/// How a testimony is drawn.
struct TestimonyLook {
  const char* group;
  Color color;
};
TestimonyLook lookOf(Testimony testimony) {
  if (testimony == Testimony::kept) return {"speaks for it", {30, 170, 60}};
  if (testimony == Testimony::contradicting) return {"speaks against it", {210, 40, 40}};
  return {"where the map was not seen", {150, 150, 150}};
}

std::vector<SceneMark> marksOf(const Explanation& explanation) {
  std::vector<SceneMark> marks;
  for (const Contribution& c : explanation.contributions) {
    const TestimonyLook look = lookOf(c.testimony);
    SceneMark mark{look.group, look.color, c.map_position, c.name};
    if (c.nats) mark.note += fmt::format(", {:.1f} nats", *c.nats);
    if (c.expected) mark.note += fmt::format(" of {:.1f}", *c.expected);
    if (c.residual_m) mark.note += fmt::format(", {:.2f} m from its partner", *c.residual_m);
    marks.push_back(std::move(mark));
  }
  return marks;
}

/// Each piece of the query where the pose puts it, with a line to its partner in the map.
ColorMesh meshOf(const Explanation& explanation) {
  ColorMesh mesh;
  for (const Contribution& c : explanation.contributions) {
    const bool is_vertex = c.kind == Contribution::Kind::vertex;
    const Color color = lookOf(c.testimony).color;
    addOctahedron(mesh, c.map_position, is_vertex ? 0.5 : 0.25, color);
    if (c.partner) addTube(mesh, c.map_position, *c.partner, 0.05, color);
  }
  return mesh;
}

/// FILE.csv and FILE.ply; a folder is made if it is missing.
void writeExplanation(const std::string& path, int query, const Answer& answer,
                      const Explanation& explanation) {
  if (!isOneFile(path)) makeFolder(path);
  const std::string stem = stemOf(path, query, answer);
  writeFile(stem + ".csv", toCsv(answer, explanation));
  writeMesh(stem + ".ply", meshOf(explanation));
}

/// What ros2 topic pub and a YAML reader take as geometry_msgs/PoseWithCovarianceStamped: the pose
/// of the sensor, in the frame "map".
std::string initialPose(const pose::TrajectoryFix& fix, double stamp_s) {
  const Eigen::Vector3d p = fix.T_map_sensor.translation();
  const Eigen::Quaterniond q(fix.T_map_sensor.linear());
  const double whole_s = std::floor(stamp_s);
  std::string text = fmt::format(
      "header:\n  stamp: {{sec: {:.0f}, nanosec: {:.0f}}}\n  frame_id: map\npose:\n  pose:\n"
      "    position: {{x: {}, y: {}, z: {}}}\n    orientation: {{x: {}, y: {}, z: {}, w: {}}}\n"
      "  covariance: [",
      whole_s, std::floor(1e9 * (stamp_s - whole_s)), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
      q.w());
  for (Eigen::Index i = 0; i < 36; ++i)
    text += fmt::format("{}{}", i == 0 ? "" : ", ", fix.covariance(i / 6, i % 6));
  return text + "]\n";
}

}  // namespace

void AnswerFiles::declare(Flags& flags) {
  flags.add(
      "--explain", explain_,
      "what speaks for and against an answer: FILE.csv and FILE.ply, a folder of them for several "
      "queries, or FILE.html, a page for any number");
  flags.add("--tum", tum_, "file for accepted poses, as TUM lines");
  flags.add("--trajectory", trajectory_,
            "file for every pose of the QUERY in the map, as TUM lines");
  flags.add("--matrix", matrix_, "file for T_map_query, 4 x 4 (CloudCompare, PDAL)");
  flags.add("--initialpose", initial_pose_,
            "file for the last accepted pose, as YAML of PoseWithCovarianceStamped (ROS)");
  flags.rare().add("--g2o", graph_, "file for its pose graph, odometry and matches (g2o)");
}

void AnswerFiles::check(std::size_t inputs, bool is_cut) const {
  const bool of_way =
      !(trajectory_.empty() && graph_.empty() && matrix_.empty() && initial_pose_.empty());
  if (isOneFile(explain_) && (is_cut || inputs > 1))
    throw UsageError("--explain " + explain_ + " is for one query; name a folder for several");
  if (isOneFile(explain_) || isPage(explain_)) io::requireWritable(explain_);
  if (of_way && inputs > 1)
    throw UsageError(fmt::format(
        "--trajectory, --g2o, --matrix and --initialpose are for one QUERY, found {}", inputs));
  for (const std::string& path : {tum_, trajectory_, graph_, matrix_, initial_pose_})
    io::requireWritable(path);
}

void AnswerFiles::begin() {
  T_odom_sensor_.clear();
  stamps_s_.clear();
  fixes_.clear();
}

void AnswerFiles::take(const QueryInput& input) {
  for (const FrameDigest& frame : input.frames) {
    T_odom_sensor_.push_back(frame.T_odom_sensor);
    stamps_s_.push_back(frame.stamp_s);
  }
  if (!input.frames.empty()) return;
  T_odom_sensor_ = input.whole->poses;
  for (std::size_t i = 0; i < T_odom_sensor_.size(); ++i)
    stamps_s_.push_back(static_cast<double>(i));
}

void AnswerFiles::explain(const Answer& answer, const Query& query,
                          const Explanation& explanation) {
  if (!isPage(explain_)) return writeExplanation(explain_, answers_, answer, explanation);
  explained_.push_back(query);
  explained_.back().plan = {};  // the page shows points and vertices
  SceneQuery shown = queryWith(explained_.back(), answer.fix);
  shown.name = nameOf(answer);
  shown.marks = marksOf(explanation);
  on_page_.push_back(std::move(shown));
}

void AnswerFiles::writePage(const map::SemanticMap& map, const Job& job) const {
  Scene scene = sceneOf(map);
  scene.queries = on_page_;
  scene.title = outcomeOf(on_page_);
  scene.caption =
      fmt::format("what speaks for and against {} in {}",
                  on_page_.size() == 1 ? "the answer" : "the answers", job.operands.back());
  scene.made_by = madeBy(job);
  std::vector<std::pair<std::string, std::size_t>> counts;  // of marks by group
  for (const SceneQuery& query : on_page_) {
    for (const SceneMark& mark : query.marks) {
      const auto of_group = [&](const auto& count) { return count.first == mark.group; };
      const auto known = std::find_if(counts.begin(), counts.end(), of_group);
      if (known == counts.end())
        counts.emplace_back(mark.group, 1);
      else
        ++known->second;
    }
  }
  for (const auto& [group, count] : counts) scene.facts.emplace_back(group, std::to_string(count));
  writeFile(explain_, htmlPage(scene));
}

void AnswerFiles::add(const Answer& answer, const Query& query,
                      const std::function<Explanation()>& explain_answer) {
  ++answers_;
  if (!explain_.empty()) explain(answer, query, explain_answer());
  const Localization& fix = answer.fix;
  if (!fix.accepted()) return;
  accepted_.push_back({answer.last_stamp_s, fix.T_map_sensor});
  const std::size_t last = T_odom_sensor_.size() - 1;
  // A graph or map is one query; its answer is that of its last pose.
  const std::size_t index = answer.frames == T_odom_sensor_.size() ? answer.last_index : last;
  fixes_.push_back(
      {index, fix.T_map_query, fix.T_map_sensor, fix.scale, fix.covariance, fix.confidence});
}

const pose::TrajectoryFix& AnswerFiles::surest() const {
  return *std::max_element(fixes_.begin(), fixes_.end(),
                           [](const pose::TrajectoryFix& a, const pose::TrajectoryFix& b) {
                             return a.confidence < b.confidence;
                           });
}

void AnswerFiles::end(const Job& job) const {
  if (fixes_.empty()) {
    for (const std::string& path : {trajectory_, graph_, matrix_, initial_pose_})
      removeStale(path, job.narrate);
    return;
  }
  if (!trajectory_.empty()) writeTrajectory();
  if (!graph_.empty()) writeGraph(job.options.posterior);
  if (!matrix_.empty()) io::writeMatrix(matrix_, surest().T_map_query, surest().scale);
  if (!initial_pose_.empty())
    writeFile(initial_pose_, initialPose(fixes_.back(), accepted_.back().stamp_s));
}

void AnswerFiles::writeTrajectory() const {
  std::vector<io::StampedPose> stamped;
  for (const Eigen::Isometry3d& T : pose::trajectoryThrough(T_odom_sensor_, fixes_))
    stamped.push_back({stamps_s_[stamped.size()], T});
  io::writeTumPoses(trajectory_, stamped);
}

/// Vertex 0 is the map (fixed), the others are the poses of the QUERY; edges of the odometry, and
/// from the map to each answered pose.
void AnswerFiles::writeGraph(const pose::PosteriorOptions& odometry) const {
  io::PoseGraph graph;
  graph.poses = pose::trajectoryThrough(T_odom_sensor_, fixes_);
  graph.poses.insert(graph.poses.begin(), Eigen::Isometry3d::Identity());
  graph.fixed = {0};
  for (std::size_t i = 0; i + 1 < T_odom_sensor_.size(); ++i) {
    Eigen::Isometry3d step = T_odom_sensor_[i].inverse() * T_odom_sensor_[i + 1];
    step.translation() *= surest().scale;
    graph.edges.push_back(
        {i + 1, i + 2, step, odometryCovariance(step.translation().norm(), odometry)});
  }
  for (const pose::TrajectoryFix& fix : fixes_)
    graph.edges.push_back({0, fix.index + 1, fix.T_map_sensor, fix.covariance});
  io::writePoseGraph(graph_, graph);
}

void AnswerFiles::finish(const map::SemanticMap& map, const Job& job) const {
  if (!on_page_.empty()) writePage(map, job);
  if (tum_.empty()) return;
  if (accepted_.empty()) return removeStale(tum_, job.narrate);
  io::writeTumPoses(tum_, accepted_);
}

}  // namespace xview::tools
