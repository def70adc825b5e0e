// SPDX-License-Identifier: BSD-3-Clause
#include "answer_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "base/in_order.h"
#include "base/pose.h"
#include "map/contents.h"
#include "outputs.h"
#include "place/odometry_check.h"
#include "pose_text.h"
#include "process/atomic_file.h"
#include "scenes.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

/// How the support of a contribution is drawn.
struct SupportStyle {
  const char* group;
  Color color;
};
SupportStyle styleOf(Support support) {
  if (support == Support::kept) return {"speaks for it", {30, 170, 60}};
  if (support == Support::contradicting) return {"speaks against it", {210, 40, 40}};
  return {"where the map was not seen", {150, 150, 150}};
}

std::vector<SceneMark> marksOf(const Explanation& explanation) {
  std::vector<SceneMark> marks;
  for (const Contribution& c : explanation.contributions) {
    const SupportStyle style = styleOf(c.support);
    SceneMark mark{style.group, style.color, c.map_position, c.name};
    if (c.nats) mark.note += fmt::format(", {:.1f} nats", *c.nats);
    if (c.expected) mark.note += fmt::format(" of {:.1f}", *c.expected);
    if (c.residual_m) mark.note += fmt::format(", {:.2f} m from its partner", *c.residual_m);
    marks.push_back(std::move(mark));
  }
  return marks;
}

/// More than odometry can drift from one fix to the next: somebody carried the robot.
bool isCarried(const pose::TrajectoryFix& a, const pose::TrajectoryFix& b,
               const std::vector<Eigen::Isometry3d>& T_odom_sensor, const Job& job) {
  constexpr double kSigmas = 3, kLeast_m = 3;
  const OdometryOptions& odometry = job.options.odometry;
  double way_m = 0, longest_m = 0;
  for (std::size_t i = a.index + 1; i <= b.index; ++i) {
    const double step_m =
        (T_odom_sensor[i].translation() - T_odom_sensor[i - 1].translation()).norm();
    way_m += step_m;
    longest_m = std::max(longest_m, step_m);
  }
  way_m -= longest_m;  // it may be the odometry's jump, which nobody drove
  const double sigma_m = pose::sigmaBetween(a, b);
  const double heading_rad = std::sqrt(std::max(0.0, a.covariance(5, 5))) * kSigmas +
                             odometry.drift_deg_per_m * M_PI / 180 * way_m;
  return pose::offBetween(a, b, T_odom_sensor) >
         kLeast_m * parseSize(job.options.size).value_or(kTownScale) + kSigmas * sigma_m +
             (odometry.drift + heading_rad) * way_m;
}

/// Way before the first and after the last fix along which frames of a window lie where it was
/// found: windows are bent by as much as the odometry errs, at the rate that the fixes show; 1 m of
/// a town at most. Fixes that are one, or near one another, show no rate.
double reachOfFixes(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                    const std::vector<double>& way_m, const std::vector<pose::TrajectoryFix>& fixes,
                    const Job& job) {
  constexpr double kMostError_m = 1, kLeastWay_m = 10;
  const double size = parseSize(job.options.size).value_or(kTownScale);
  double rate = 0;
  for (std::size_t k = 1; k < fixes.size(); ++k) {
    const pose::TrajectoryFix &a = fixes[k - 1], &b = fixes[k];
    const double between_m = way_m[b.index] - way_m[a.index];
    if (between_m < kLeastWay_m * size) continue;
    rate = std::max(
        {rate, job.options.odometry.drift, pose::offBetween(a, b, T_odom_sensor) / between_m});
  }
  return rate > 0 ? kMostError_m * size / rate : INFINITY;
}

/// The poses of a recording in the map. Between two fixes that its odometry does not connect, and
/// beyond what was found, nothing is known, and there are none.
std::vector<io::StampedPose> knownTrajectory(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                                             const std::vector<double>& stamps_s,
                                             const std::vector<pose::TrajectoryFix>& fixes,
                                             std::vector<bool> is_known,
                                             const std::vector<std::size_t>& jumps,
                                             const Job& job) {
  const std::vector<double> way_m = pathLengths(T_odom_sensor);
  const double reach_m = reachOfFixes(T_odom_sensor, way_m, fixes, job);
  for (std::size_t i = 0; i < is_known.size(); ++i) {
    if (way_m[fixes.front().index] - way_m[i] > reach_m ||
        way_m[i] - way_m[fixes.back().index] > reach_m)
      is_known[i] = false;
  }
  std::fill(is_known.begin() + static_cast<std::ptrdiff_t>(fixes.front().index),
            is_known.begin() + static_cast<std::ptrdiff_t>(fixes.back().index) + 1, true);
  for (std::size_t k = 1; k < fixes.size(); ++k) {
    const std::size_t from = fixes[k - 1].index, to = fixes[k].index;
    if (to <= from + 1 || !isCarried(fixes[k - 1], fixes[k], T_odom_sensor, job)) continue;
    std::fill(is_known.begin() + static_cast<std::ptrdiff_t>(from + 1),
              is_known.begin() + static_cast<std::ptrdiff_t>(to), false);
    job.narrate.note(fmt::format(
        "--trajectory has no pose between stamps {} and {}: it was lost there, {} frames",
        stamps_s[from], stamps_s[to], to - from - 1));
  }
  const auto poses = pose::trajectoryThrough(T_odom_sensor, fixes, jumps);
  std::vector<io::StampedPose> known;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (is_known[i] && poses[i]) known.push_back({stamps_s[i], *poses[i]});
  }
  if (known.size() < poses.size())
    job.narrate.note(fmt::format(
        "--trajectory has {} of {} poses: of the others the odometry does not tell where they were",
        known.size(), poses.size()));
  return known;
}

/// From p to the nearest of some points, if who saw them cannot have been at p. Else 0.
template <class PointAt>
double offFrom(const Eigen::Vector3d& p, std::size_t count, const PointAt& pointAt) {
  constexpr double kNoSensor_m = 10;
  double nearest = std::numeric_limits<double>::infinity();
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < count; ++i) {
    nearest = std::min(nearest, (pointAt(i) - p).norm());
    box.extend(pointAt(i));
  }
  const bool can_be = box.isEmpty() || nearest < std::max(kNoSensor_m, box.sizes().norm());
  return can_be ? 0 : nearest;
}

}  // namespace

double offFromSensor(const Query& query, const Eigen::Vector3d& sensor) {
  const std::vector<Vertex>& vertices = query.graph.vertices;
  return query.cloud.empty()
             ? offFrom(sensor, vertices.size(), [&](std::size_t i) { return vertices[i].position; })
             : offFromSensor(query.cloud, sensor);
}

double offFromSensor(const LabelledCloud& cloud, const Eigen::Vector3d& sensor) {
  return offFrom(sensor, cloud.size(), [&](std::size_t i) { return cloud.position(i); });
}

std::string noSensorText(const std::string& input, double off_m) {
  return fmt::format(
      "--initialpose: {} is a cloud whose points are {:.0f} m and more from the origin of its "
      "frame, so no sensor was there; --matrix of xview localize has the pose of that frame",
      input, off_m);
}

std::string stemOf(const std::string& query) {
  const fs::path path(query);
  const std::string ending = path.extension().string();
  const std::size_t setup = ending.find('#');
  if (setup != std::string::npos && io::isCloudFile(query))  // "site.e57#2" -> "site_2"
    return path.stem().string() + "_" + ending.substr(setup + 1);
  return (path.has_filename() ? path : path.parent_path()).stem().string();
}

void requireDistinct(const std::vector<std::string>& queries) {
  std::map<std::string, std::string> query_of;
  for (const std::string& query : queries) {
    const auto [at, is_new] = query_of.emplace(stemOf(query), query);
    if (!is_new)
      throw UsageError(
          fmt::format("{} and {} would write one file: {}", at->second, query, at->first));
  }
}

std::string initialPose(const Eigen::Isometry3d& T_map_sensor, const Matrix6d& covariance_of_sensor,
                        double stamp_s, const std::optional<Eigen::Isometry3d>& T_sensor_base) {
  const Eigen::Isometry3d T_map_base = T_sensor_base ? T_map_sensor * *T_sensor_base : T_map_sensor;
  const Eigen::Vector3d p = T_map_base.translation();
  const Matrix6d covariance =
      T_sensor_base ? pose::movedCovariance(covariance_of_sensor, T_map_sensor.translation(), p)
                    : covariance_of_sensor;
  const Eigen::Quaterniond q(T_map_base.linear());
  const auto stamp_us = std::llround(1e6 * stamp_s);  // a double has no more of a stamp of today
  std::string text = T_sensor_base
                         ? "# pose of the base of the robot\n"
                         : "# pose of the sensor, not of base_link: of a camera it is that of the "
                           "optical frame, z forward; --T_sensor_base gives the base\n";
  text += fmt::format(
      "header:\n  stamp: {{sec: {}, nanosec: {}}}\n  frame_id: map\npose:\n  pose:\n"
      "    position: {{x: {}, y: {}, z: {}}}\n    orientation: {{x: {}, y: {}, z: {}, w: {}}}\n"
      "  covariance: [",
      stamp_us / 1000000, stamp_us % 1000000 * 1000, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
      q.w());
  for (Eigen::Index i = 0; i < 36; ++i)
    text += fmt::format("{}{}", i == 0 ? "" : ", ", covariance(i / 6, i % 6));
  return text + "]\n";
}

void AnswerFiles::declare(Flags& flags) {
  flags.addOutput("--explain", explain_,
                  "what speaks for and against the answers: a page, FILE.html");
  flags.addOutput("--tum", tum_, "file for accepted poses, as TUM lines");
  flags.addOutput("--trajectory", trajectory_,
                  "file for every pose of the QUERY in the map, as TUM lines");
  flags.addOutput("--matrix", matrix_,
                  "file for T_map_query, 4 x 4 (CloudCompare, PDAL); of several QUERYs a folder");
  flags.addOutput("--initialpose", initial_pose_,
                  "file for the last accepted pose, as YAML of PoseWithCovarianceStamped (ROS)");
  flags.rare().add(kSensorBaseFlag, sensor_base_, kSensorBaseHelp);
}

void AnswerFiles::check(const std::vector<std::string>& queries) {
  if (!explain_.empty() && fs::path(explain_).extension() != ".html")
    throw UsageError("--explain " + explain_ + ": a page ends with .html");
  parseSensorBase(sensor_base_);
  are_several_ = queries.size() > 1;
  for (const std::string& path : {explain_, tum_}) requireWritable(path);
  for (const std::string& path : {trajectory_, matrix_, initial_pose_}) {
    if (!are_several_) {
      requireWritable(path);
    } else if (!path.empty()) {
      requireDistinct(queries);
      std::error_code failed;
      if (!fs::is_directory(path, failed) && !fs::create_directories(path, failed))
        throw Error(path, "with several QUERYs it is a folder, which cannot be made" +
                              (failed ? ": " + failed.message() : std::string()));
    }
  }
}

void AnswerFiles::removeOld(const std::vector<std::string>& queries, const Job& job,
                            bool what_else) {
  for (const std::string& query : queries) {
    begin(query);
    if (what_else)
      end(job);
    else
      removeStale(pathOf(initial_pose_, ".yaml"), job.narrate, kUntilItIsFound);
  }
  if (what_else) removeStale(tum_, job.narrate);
}

void AnswerFiles::begin(const std::string& query) {
  query_ = query;
  stamps_s_.clear();
  fixes_.clear();
  found_ = {};
  was_found_.clear();
  jumps_.clear();
}

std::string AnswerFiles::pathOf(const std::string& flag, const char* ending) const {
  return flag.empty() || !are_several_ ? flag
                                       : (fs::path(flag) / (stemOf(query_) + ending)).string();
}

void AnswerFiles::take(const QueryInput& input) {
  found_ = FoundFrames(input.source ? input.poses() : input.whole->poses);
  for (std::size_t i = 0; i < found_.is_found.size(); ++i)
    stamps_s_.push_back(input.source ? input.source->stamp(i) : static_cast<double>(i));
}

void AnswerFiles::explain(const Answer& answer, const Query& query,
                          const Explanation& explanation) {
  explained_.push_back(query);
  explained_.back().bev = {};  // the page shows points and vertices
  SceneQuery shown = queryWith(explained_.back(), answer.fix);
  shown.name = nameOf(answer);
  shown.marks = marksOf(explanation);
  on_page_.push_back(std::move(shown));
}

void AnswerFiles::writePage(const map::SemanticMap& packed, const Job& job) const {
  const map::SemanticMap map = map::unpacked(packed);
  Scene scene = sceneOf(map);
  scene.queries = on_page_;
  scene.title = outcomeOf(on_page_);
  scene.caption =
      fmt::format("what speaks for and against {} in {}",
                  on_page_.size() == 1 ? "the answer" : "the answers", job.operands.back());
  scene.made_by = madeBy(job);
  std::vector<std::pair<std::string, std::size_t>> counts;  // of marks by group
  for (const SceneQuery& query : on_page_) {
    for (const SceneMark& mark : query.marks) ++valueOf(counts, mark.group);
  }
  for (const auto& [group, count] : counts) scene.facts.emplace_back(group, std::to_string(count));
  writeFile(explain_, htmlPage(scene));
}

void AnswerFiles::add(const Answer& answer, const Query& query,
                      const std::function<Explanation()>& explain_answer) {
  if (!explain_.empty()) explain(answer, query, explain_answer());
  const Localization& fix = answer.fix;
  if (!fix.accepted()) return;
  accepted_.push_back({answer.last_stamp_s, fix.T_map_sensor});
  const std::size_t count = found_.is_found.size();
  // A graph or map is one query; its answer is that of its last pose.
  const std::size_t index = answer.frames == count ? answer.last_index : count - 1;
  fixes_.push_back(pose::fixOf(fix, index));
  const bool may_have_none = query.sensor == Sensor::cloud && fix.scale == 1;
  sensor_off_m_ =
      may_have_none ? offFromSensor(query, found_.T_odom_sensor[index].translation()) : 0;
  found_.fixes.push_back(fixes_.back());
  found_.take(query, index);
}

void AnswerFiles::complete(const QueryInput& input, const Localizer& localizer, const Job& job) {
  if (!initial_pose_.empty() && !fixes_.empty())
    T_sensor_base_ = sensorBaseOf(sensor_base_, input.path, input.options);
  if (trajectory_.empty() || !input.source || fixes_.empty() || !job.options.scale.empty()) return;
  // Odometry leads back from the end of a QUERY of one piece, whatever part of it was looked for.
  was_found_ = found_.is_found;
  if (job.options.odometry.check) {
    for (const OdometryJump& jump : findJumps(*input.source, job.options))
      jumps_.push_back(jump.position);
  }
  if (input.whole) found_.is_found.assign(found_.is_found.size(), true);
  addFixes(input, localizer, job, found_);
}

const pose::TrajectoryFix& AnswerFiles::surest() const {
  return *std::max_element(fixes_.begin(), fixes_.end(),
                           [](const pose::TrajectoryFix& a, const pose::TrajectoryFix& b) {
                             return a.confidence < b.confidence;
                           });
}

void AnswerFiles::end(const Job& job) const {
  const std::string trajectory = pathOf(trajectory_, ".txt"), matrix = pathOf(matrix_, ".txt"),
                    initial_pose = pathOf(initial_pose_, ".yaml");
  if (fixes_.empty()) {
    for (const std::string& path : {trajectory, matrix, initial_pose})
      removeStale(path, job.narrate);
    return;
  }
  if (!trajectory.empty())
    io::writeTumPoses(trajectory, knownTrajectory(found_.T_odom_sensor, stamps_s_, found_.fixes,
                                                  was_found_.empty() ? found_.is_found : was_found_,
                                                  jumps_, job));
  if (!matrix.empty()) io::writeMatrix(matrix, surest().T_map_query, surest().scale);
  if (initial_pose.empty()) return;
  if (sensor_off_m_ > 0) {
    job.narrate.note(noSensorText(query_, sensor_off_m_));
    removeStale(initial_pose, job.narrate);
  } else {
    writeFile(initial_pose, initialPose(fixes_.back().T_map_sensor, fixes_.back().covariance,
                                        accepted_.back().stamp_s, T_sensor_base_));
  }
}

void AnswerFiles::finish(const map::SemanticMap& map, const Job& job) const {
  if (!on_page_.empty()) writePage(map, job);
  if (tum_.empty()) return;
  if (accepted_.empty()) return removeStale(tum_, job.narrate);
  const bool has_stamps = std::any_of(accepted_.begin(), accepted_.end(),
                                      [](const auto& pose) { return pose.stamp_s != 0; });
  if (accepted_.size() > 1 && !has_stamps)
    job.narrate.note(
        "--tum: the QUERYs have no stamps, so all lines have 0; they are in the order "
        "of the QUERYs");
  io::writeTumPoses(tum_, accepted_);
}

}  // namespace xview::tools
