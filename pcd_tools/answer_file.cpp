// SPDX-License-Identifier: BSD-3-Clause
#include "answer_file.h"

#include <fmt/core.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "xview/types/error.h"

namespace xview::tools {
namespace {

using Json = nlohmann::ordered_json;

Status statusOf(const std::string& text) {
  for (const Status status : {Status::accepted, Status::ambiguous, Status::rejected}) {
    if (text == toString(status)) return status;
  }
  throw std::invalid_argument("status \"" + text + "\", expected accepted, ambiguous or rejected");
}

Eigen::Isometry3d poseOf(const Json& pose) {
  const auto p = pose.at("position").get<std::vector<double>>();
  const auto q = pose.at("quaternion").get<std::vector<double>>();
  if (p.size() != 3)
    throw std::invalid_argument(fmt::format("position has {} numbers, expected 3", p.size()));
  if (q.size() != 4)
    throw std::invalid_argument(fmt::format("quaternion has {} numbers, expected 4", q.size()));
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3))
    throw std::invalid_argument("quaternion is not of length 1");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation.normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return T;
}

Matrix6d covarianceOf(const Json& row_major) {
  const auto values = row_major.get<std::vector<double>>();
  if (values.size() != 36)
    throw std::invalid_argument(
        fmt::format("covariance has {} numbers, expected 36", values.size()));
  return Eigen::Map<const Matrix6d>(values.data()).transpose();
}

Answer parse(const std::string& line) {
  const Json json = Json::parse(line);
  const Json& query = json.at("query");
  Answer answer;
  answer.input = query.at("input").get<std::string>();
  answer.first_frame = query.at("first_frame").get<std::int64_t>();
  answer.last_frame = query.at("last_frame").get<std::int64_t>();
  answer.last_index = query.value("last_index", std::size_t{0});
  answer.last_stamp_s = query.value("last_stamp", 0.0);
  answer.frames = query.value("frames_in_input", std::size_t{0});
  answer.fix.status = statusOf(json.at("status").get<std::string>());
  answer.fix.confidence = json.at("confidence").get<double>();
  const auto pose = json.find("pose");
  if (pose != json.end() && !pose->is_null()) {
    answer.fix.T_map_sensor = poseOf(*pose);
    answer.fix.hypotheses.resize(1);
  }
  answer.fix.scale = json.value("scale", 1.0);
  if (!(answer.fix.scale > 0)) throw std::invalid_argument("scale is not positive");
  const auto covariance = json.find("covariance");
  if (covariance != json.end() && !covariance->is_null())
    answer.fix.covariance = covarianceOf(*covariance);
  const auto timing = json.find("timing_ms");
  if (timing == json.end()) return answer;
  for (const auto& [stage, ms] : timing->items()) {
    if (stage != "load_map") answer.fix.timing_ms.emplace_back(stage, ms.get<double>());
  }
  return answer;
}

}  // namespace

std::vector<Answer> readAnswers(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(path, "cannot be opened");
  std::vector<Answer> answers;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      answers.push_back(parse(line));
    } catch (const std::exception& e) {
      std::string problem = e.what();  // "[json.exception.parse_error.101] ..."
      if (problem[0] == '[') problem.erase(0, problem.find(' ') + 1);
      throw Error(fmt::format("{}:{}", path, number),
                  "expected an answer of xview localize --json; " + problem);
    }
  }
  if (file.bad()) throw Error(path, "cannot be read");
  if (answers.empty()) throw Error(path, "no answers");
  return answers;
}

}  // namespace xview::tools
