// SPDX-License-Identifier: BSD-3-Clause
#include "answer.h"

#include <fmt/core.h>

#include <array>
#include <nlohmann/json.hpp>

#include "xview/types/pose.h"

namespace xview::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Takes points of the query as they are, in its own lengths, to the map.
Eigen::Matrix4d inLengthsOfQuery(const Eigen::Isometry3d& T_map_query, double scale) {
  Eigen::Matrix4d T = T_map_query.matrix();
  T.topLeftCorner<3, 3>() *= scale;
  return T;
}

template <int N>
Json rowMajor(const Eigen::Matrix<double, N, N>& matrix) {
  Json numbers = Json::array();
  for (int row = 0; row < N; ++row) {
    for (int column = 0; column < N; ++column) numbers.push_back(matrix(row, column));
  }
  return numbers;
}

Json poseOf(const Answer& answer) {
  const Eigen::Vector3d p = answer.fix.T_map_sensor.translation();
  Eigen::Quaterniond q(answer.fix.T_map_sensor.rotation());
  if (q.w() < 0) q.coeffs() *= -1;  // q and -q are one rotation; print one of them
  return {{"frame", answer.last_frame},
          {"position", {p.x(), p.y(), p.z()}},
          {"quaternion", {q.x(), q.y(), q.z(), q.w()}}};
}

Json hypothesesOf(const Localization& fix) {
  Json list = Json::array();
  for (const Hypothesis& h : fix.hypotheses) {
    list.push_back({{"T_map_query", rowMajor<4>(inLengthsOfQuery(h.T_map_query, fix.scale))},
                    {"score", h.score},
                    {"inliers", h.inliers},
                    {"proposer", toString(h.proposer)}});
  }
  return list;
}

double timeOf(const Timings& timings, const std::string& stage) {
  double sum = 0;
  for (const auto& [name, ms] : timings) sum += name == stage ? ms : 0;
  return sum;
}

double totalOf(const Timings& timings) {
  double sum = 0;
  for (const auto& [name, ms] : timings) {
    if (name == "total") return ms;
    sum += ms;
  }
  return sum;
}

/// Every stage of the contract is present, also those that a method skips; further stages follow.
Json timingOf(const Answer& answer) {
  Json timing = Json::object();
  for (const char* stage : {"read", "lift", "blobs", "graph", "descriptors", "matching",
                            "rejection", "pose", "refine"}) {
    timing[stage] = timeOf(answer.fix.timing_ms, stage);
  }
  for (const auto& [name, ms] : answer.fix.timing_ms) {
    if (name != "total" && !timing.contains(name))
      timing[name] = timeOf(answer.fix.timing_ms, name);
  }
  timing["total"] = totalOf(answer.fix.timing_ms);
  timing["load_map"] = answer.load_map_ms;
  return timing;
}

Json sequenceOf(const SequenceAnswer& sequence) {
  return {{"windows", sequence.windows},
          {"score", sequence.score},
          {"runner_up", sequence.runner_up},
          {"restarted", sequence.restarted},
          {"alone",
           {{"status", toString(sequence.alone.status)},
            {"confidence", sequence.alone.confidence},
            {"reason", sequence.alone.reason}}}};
}

Json trackOf(const TrackAnswer& track) {
  return {{"searched", track.local ? "expected" : "everywhere"},
          {"lost", track.lost},
          {"radius_m", track.radius_m}};
}

}  // namespace

std::string toJson(const Answer& answer) {
  const Localization& fix = answer.fix;
  const bool has_pose = !fix.hypotheses.empty();
  Json json;
  json["query"] = {{"input", answer.input},           {"first_frame", answer.first_frame},
                   {"last_frame", answer.last_frame}, {"used_from_index", answer.used_from},
                   {"last_index", answer.last_index}, {"last_stamp", answer.last_stamp_s},
                   {"frames_in_input", answer.frames}};
  json["status"] = toString(fix.status);
  json["reason"] = fix.reason;
  json["confidence"] = fix.confidence;
  json["witnesses"] = {{"place", fix.witnesses.place},
                       {"correspondences", fix.witnesses.correspondences},
                       {"dense", fix.witnesses.dense}};
  json["T_map_query"] =
      has_pose ? rowMajor<4>(inLengthsOfQuery(fix.T_map_query, fix.scale)) : Json();
  json["pose"] = has_pose ? poseOf(answer) : Json();
  json["covariance"] = has_pose ? rowMajor<6>(fix.covariance) : Json();
  json["scale"] = fix.scale;
  json["gravity"] = toString(fix.gravity);
  json["gravity_reason"] = fix.gravity_reason;
  json["inliers"] = fix.inliers;
  json["vertices"] = fix.vertices;
  json["matches"] = fix.matches;
  json["hypotheses"] = hypothesesOf(fix);
  if (answer.sequence) json["sequence"] = sequenceOf(*answer.sequence);
  if (answer.track) json["track"] = trackOf(*answer.track);
  json["timing_ms"] = timingOf(answer);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);  // paths need not be UTF-8
}

std::string tableHeading() {
  return fmt::format("{:<28} {:>11}  {:<9} {:>10} {:>10} {:>8} {:>7} {:>9} {:>6} {:>7}  {}",
                     "query", "frames", "status", "x m", "y m", "z m", "yaw deg", "inliers",
                     "conf.", "ms", "reason");
}

std::string toTableLine(const Answer& answer) {
  constexpr double kDegrees = 57.29577951308232;
  const Localization& fix = answer.fix;
  const Eigen::Vector3d p = fix.T_map_sensor.translation();
  const std::string where = fix.hypotheses.empty()
                                ? fmt::format("{:>10} {:>10} {:>8} {:>7}", "-", "-", "-", "-")
                                : fmt::format("{:>10.2f} {:>10.2f} {:>8.2f} {:>7.1f}", p.x(), p.y(),
                                              p.z(), kDegrees * yawOf(fix.T_map_query.linear()));
  const std::string scale = fix.scale == 1 ? "" : fmt::format(" [scale {:.3f}]", fix.scale);
  const std::string gravity =
      fix.gravity == GravityUse::aligned
          ? ""
          : fmt::format(" [{}; {}]", toString(fix.gravity), fix.gravity_reason);
  return fmt::format("{:<28} {:>11}  {:<9} {} {:>9} {:>6.3f} {:>7.1f}  {}{}{}", answer.input,
                     fmt::format("{}-{}", answer.first_frame, answer.last_frame),
                     toString(fix.status), where, fmt::format("{}/{}", fix.inliers, fix.vertices),
                     fix.confidence, totalOf(fix.timing_ms), fix.reason, scale, gravity);
}

}  // namespace xview::tools
