// SPDX-License-Identifier: BSD-3-Clause
#include "live.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "answer_files.h"
#include "answer_json.h"
#include "xview/base/error.h"

namespace xview::tools {

std::string toJson(const LiveFrame& frame, const FollowAnswer& answer, double latency_ms,
                   const std::string& error) {
  Json json = {{"frame", frame.number},
               {"input", frame.input},
               {"stamp", frame.stamp_s ? Json(*frame.stamp_s) : Json()},
               {"state", toString(answer.state)},
               {"source", nullptr},
               {"confidence", 0.0},
               {"pose", nullptr},
               {"T_map_odom", nullptr},
               {"covariance", nullptr}};
  if (answer.found()) {
    json["source"] = toString(answer.source);
    json["confidence"] = answer.confidence;
    json["pose"] = poseJson(answer.T_map_sensor);
    if (frame.has_odometry) json["T_map_odom"] = rowMajor<4>(answer.T_map_odom.matrix());
    json["covariance"] = rowMajor<6>(answer.covariance);
    if (answer.jump_m > 0) json["jump_m"] = std::round(1000 * answer.jump_m) / 1000;
  }
  json["reason"] = answer.reason;
  if (!answer.budget_exhausted.empty()) json["budget_exhausted"] = answer.budget_exhausted;
  if (!error.empty()) json["error"] = error;
  json["latency_ms"] = std::round(1000 * latency_ms) / 1000;
  return toText(json);
}

std::string jumpText(const FollowAnswer& answer) {
  if (answer.jump_m <= 0) return {};
  return fmt::format("{:.1f} m from where the odometry put it since the last pose", answer.jump_m);
}

FollowAnswer follow(Follower& follower, const QueryInput& input, LiveFrame& about,
                    const std::optional<Eigen::Isometry3d>& T_odom_sensor) {
  if (input.whole) {
    about.sensor_off_m = offFromSensor(*input.whole, input.whole->poses.back().translation());
    return follower.add(*input.whole);
  }
  if (input.size() != 1)
    throw Error(about.input, fmt::format("expected one frame, found {}", input.size()));
  Frame frame = input.source->read(0);
  frame.number = about.number;
  if (frame.sensor == Sensor::cloud && !T_odom_sensor)
    about.sensor_off_m = offFromSensor(frame.cloud, Eigen::Vector3d::Zero());
  if (T_odom_sensor) {
    frame.T_odom_sensor = *T_odom_sensor;
    frame.sensor = Sensor::lidar;
  }
  return follower.add(std::move(frame), input.labels, about.has_odometry);
}

}  // namespace xview::tools
