// SPDX-License-Identifier: BSD-3-Clause
#include "answer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <type_traits>

#include "answer_json.h"
#include "base/user_text.h"
#include "map/contents.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

constexpr const char* kError = "error";

Json poseOf(const Answer& answer) {
  Json pose = {{"frame", answer.last_frame}};
  pose.update(poseJson(answer.fix.T_map_sensor));
  return pose;
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

enum class Written {
  always,  ///< no answer with statistics was ever written without it
  now,     ///< older programs did not
  if_asked
};

/// visit(name, value, written) for the statistics of a verdict, in the order of the file.
template <class Values, class Visit>
void forEachStatistic(Values& s, Visit&& visit) {
  using Of = DenseEvidence::Of;
  auto& dense = s.dense;
  bool registered = dense.registered(), views = dense.of == Of::views;
  visit("likelihood_margin", s.likelihood_margin, Written::always);
  visit("score_ratio", s.score_ratio, Written::always);
  visit("vertex_inlier_ratio", s.vertex_inlier_ratio, Written::if_asked);
  visit("registered", registered, Written::always);
  visit("converged", dense.converged, Written::always);
  visit("views", views, Written::always);
  if constexpr (!std::is_const_v<Values>)
    dense.of = !registered ? Of::nothing : views ? Of::views : Of::points;
  visit("aerial", dense.aerial, Written::now);
  visit("narrow", dense.narrow, Written::now);
  visit("indoors", dense.indoors, Written::now);
  visit("of_surfaces", s.of_surfaces, Written::now);
  visit("inlier_ratio", dense.inlier_ratio, Written::always);
  visit("null_inlier_ratio", dense.null_inlier_ratio, Written::always);
  visit("map_coverage", s.map_coverage, Written::now);
  visit("dense_margin", s.dense_margin, Written::now);
  visit("wrong_place_above_null", s.wrong_place_above_null, Written::now);
  visit("wrong_place_miss_ratio", s.wrong_place_miss_ratio, Written::now);
  visit("wrong_place_spread", s.wrong_place_spread, Written::now);
  visit("sigma_m", s.sigma_m, Written::now);
  visit("conflict_ratio", dense.conflict_ratio, Written::if_asked);
  visit("obstacle_overlap", dense.obstacle_overlap, Written::if_asked);
  visit("map_overlap", dense.map_overlap, Written::if_asked);
  visit("miss_ratio", dense.miss_ratio, Written::if_asked);
  visit("self_consistency", dense.self_consistency, Written::if_asked);
  visit("free_space_violation", dense.free_space_violation, Written::if_asked);
  visit("feature_margin", s.feature_margin, Written::if_asked);
  visit("storeys", s.storeys, Written::if_asked);
  visit("other_storey", s.other_storey, Written::if_asked);
}

template <class Value>
void write(Json& json, const char* name, const Value& value) {
  json[name] = value;
}
void write(Json& json, const char* name, const std::optional<double>& value) {
  if (value) json[name] = *value;
}

/// A number that is whole and not too large; the library converts any other as well.
template <class Integer>
Integer wholeNumber(const Json& json, const char* name) {
  const Json& found = json.at(name);
  const double value = found.get<double>(), smallest = std::is_signed_v<Integer> ? -0x1p53 : 0;
  const double largest = std::min(0x1p53, static_cast<double>(std::numeric_limits<Integer>::max()));
  if (value >= smallest && value <= largest && value == std::floor(value))
    return static_cast<Integer>(value);
  throw std::invalid_argument(fmt::format("{} is {}, expected a whole number in [{}, {}]", name,
                                          found.dump(), smallest, largest));
}
template <class Integer>
Integer wholeNumber(const Json& json, const char* name, Integer fallback) {
  return json.contains(name) ? wholeNumber<Integer>(json, name) : fallback;
}

template <class Value>
void read(const Json& json, const char* name, Value& value) {
  if constexpr (std::is_integral_v<Value> && !std::is_same_v<Value, bool>)
    value = wholeNumber<Value>(json, name);
  else
    value = json.at(name).get<Value>();
}
void read(const Json& json, const char* name, std::optional<double>& value) {
  value = json.at(name).get<double>();
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
  timing["total"] = totalMs(answer.fix.timing_ms);
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
  Json json = {{"searched", track.local ? "expected" : "everywhere"},
               {"lost", track.lost},
               {"radius_m", track.radius_m}};
  if (track.jump_m > 0) json["jump_m"] = track.jump_m;
  return json;
}

Status statusFrom(const std::string& text) {
  if (const auto status = enumeratorNamed(text, Status::rejected)) return *status;
  throw std::invalid_argument("status \"" + text +
                              "\", expected accepted, ambiguous, rejected or error");
}

std::vector<double> numbersOf(const Json& json, const char* key, std::size_t count) {
  const auto numbers = json.at(key).get<std::vector<double>>();
  if (numbers.size() == count) return numbers;
  throw std::invalid_argument(
      fmt::format("{} has {} numbers, expected {}", key, numbers.size(), count));
}

Eigen::Isometry3d poseFrom(const Json& pose) {
  const auto p = numbersOf(pose, "position", 3), q = numbersOf(pose, "quaternion", 4);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3))
    throw std::invalid_argument("quaternion is not of length 1");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation.normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return T;
}

/// T_map_query without the scale that it holds in the file.
Eigen::Isometry3d transformFrom(const Json& json, double scale) {
  const auto numbers = numbersOf(json, "T_map_query", 16);
  Eigen::Isometry3d T;
  T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  T.linear() /= scale;
  return T;
}

/// All places of an answer as xview wrote them; none if the file has no list.
std::vector<Hypothesis> hypothesesFrom(const Json& json, double scale) {
  std::vector<Hypothesis> hypotheses;
  const auto list = json.find("hypotheses");
  for (std::size_t i = 0; list != json.end() && i < list->size(); ++i) {
    Hypothesis hypothesis;
    hypothesis.T_map_query = transformFrom((*list)[i], scale);
    hypothesis.score = (*list)[i].value("score", 0.0);
    hypothesis.inliers = wholeNumber<decltype(hypothesis.inliers)>((*list)[i], "inliers", 0);
    hypothesis.proposer = enumeratorNamed((*list)[i].value("proposer", ""), Proposer::search)
                              .value_or(hypothesis.proposer);
    hypotheses.push_back(hypothesis);
  }
  return hypotheses;
}

/// Keys that a file of another program may lack, or mean otherwise: then they say nothing.
void readDetails(const Json& json, Answer& answer) {
  const auto textIn = [&](const char* key) {
    const auto text = json.find(key);
    return text != json.end() && text->is_string() ? text->get<std::string>() : "";
  };
  const auto number = [](const Json& in, const char* key, auto& value) {
    if (const auto found = in.find(key); found != in.end() && found->is_number())
      value = found->get<std::decay_t<decltype(value)>>();
  };
  Localization& fix = answer.fix;
  fix.reason_code =
      enumeratorNamed(textIn("reason_code"), ReasonCode::not_comparable).value_or(fix.reason_code);
  answer.budget_exhausted = textIn("budget_exhausted");
  answer.size = textIn("size");
  number(json, "inliers", fix.inliers);
  number(json, "vertices", fix.vertices);
  const auto witnesses = json.find("witnesses");
  if (witnesses == json.end() || !witnesses->is_object()) return;
  number(*witnesses, "place", fix.witnesses.place);
  number(*witnesses, "correspondences", fix.witnesses.correspondences);
  number(*witnesses, "dense", fix.witnesses.dense);
}

Answer answerFrom(const std::string& line) {
  const Json json = Json::parse(line);
  const Json& query = json.at("query");
  Answer answer;
  answer.input = query.at("input").get<std::string>();
  answer.map = json.value("map", "");
  answer.map_checksum = json.value("map_checksum", "");
  if (json.at("status") == kError) {
    answer.error = json.value("reason", "could not be read");
    return answer;
  }
  answer.first_frame = wholeNumber<std::int64_t>(query, "first_frame");
  answer.last_frame = wholeNumber<std::int64_t>(query, "last_frame");
  answer.last_index = wholeNumber<std::size_t>(query, "last_index", 0);
  answer.last_stamp_s = query.value("last_stamp", 0.0);
  answer.frames = wholeNumber<std::size_t>(query, "frames_in_input", 0);
  answer.fix.status = statusFrom(json.at("status").get<std::string>());
  answer.fix.confidence = json.at("confidence").get<double>();
  answer.fix.reason = json.value("reason", "");
  readDetails(json, answer);
  answer.fix.scale = json.value("scale", 1.0);
  if (!(answer.fix.scale > 0)) throw std::invalid_argument("scale is not positive");
  const auto pose = json.find("pose");
  if (pose != json.end() && !pose->is_null()) {
    answer.fix.T_map_sensor = poseFrom(*pose);
    answer.fix.hypotheses = hypothesesFrom(json, answer.fix.scale);
    if (answer.fix.hypotheses.empty()) answer.fix.hypotheses.resize(1);
    answer.fix.T_map_query = json.contains("T_map_query")
                                 ? transformFrom(json, answer.fix.scale)
                                 : answer.fix.T_map_sensor;  // as if its odometry began there
  }
  if (json.contains("right")) answer.right = json.at("right").get<bool>();
  answer.make = json.value("make", "");
  if (const auto s = json.find("statistics"); s != json.end()) {
    answer.whole_statistics = true;
    forEachStatistic(answer.fix.statistics, [&](const char* name, auto& value, Written written) {
      const bool is_there = s->contains(name);
      if (written == Written::always || is_there) read(*s, name, value);
      if (written == Written::now) answer.whole_statistics &= is_there;
    });
    // Older programs did not write it; it decides where nothing was registered.
    if (!answer.fix.statistics.dense.registered() && !answer.fix.statistics.of_surfaces)
      answer.whole_statistics &= s->contains("vertex_inlier_ratio");
    // Asked together; older programs asked for the first only.
    if (answer.fix.statistics.dense.map_overlap)
      answer.whole_statistics &= answer.fix.statistics.dense.miss_ratio.has_value();
  }
  const auto covariance = json.find("covariance");
  if (covariance != json.end() && !covariance->is_null())
    answer.fix.covariance =
        Eigen::Map<const Matrix6d>(numbersOf(json, "covariance", 36).data()).transpose();
  const auto timing = json.find("timing_ms");
  if (timing == json.end()) return answer;
  for (const auto& [stage, ms] : timing->items()) {
    if (stage != "load_map") answer.fix.timing_ms.emplace_back(stage, ms.get<double>());
  }
  return answer;
}

}  // namespace

Answer unansweredIn(const map::SemanticMap& map, const std::string& path, double load_map_ms) {
  Answer answer;
  answer.map = path;
  answer.map_checksum = fmt::format("{:016x}", map::checksumOf(map));
  answer.size = sizeText(map.size);
  answer.load_map_ms = load_map_ms;
  return answer;
}

Json poseJson(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d p = T.translation();
  Eigen::Quaterniond q(T.rotation());
  if (q.w() < 0) q.coeffs() *= -1;  // q and -q are one rotation; print one of them
  return {{"position", {p.x(), p.y(), p.z()}}, {"quaternion", {q.x(), q.y(), q.z(), q.w()}}};
}

std::string toText(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Eigen::Matrix4d inLengthsOfQuery(const Eigen::Isometry3d& T_map_query, double scale) {
  Eigen::Matrix4d T = T_map_query.matrix();
  T.topLeftCorner<3, 3>() *= scale;
  return T;
}

std::string toJson(const Answer& answer) {
  const Localization& fix = answer.fix;
  const bool is_read = answer.error.empty();
  const bool has_pose = !fix.hypotheses.empty();
  Json json;
  json["query"] = {{"input", answer.input},           {"first_frame", answer.first_frame},
                   {"last_frame", answer.last_frame}, {"used_from_index", answer.used_from},
                   {"last_index", answer.last_index}, {"last_stamp", answer.last_stamp_s},
                   {"frames_in_input", answer.frames}};
  if (!is_read) json["query"]["first_frame"] = json["query"]["last_frame"] = nullptr;
  json["status"] = is_read ? toString(fix.status) : kError;
  json["reason"] = is_read ? fix.reason : answer.error;
  json["reason_code"] = is_read ? toString(fix.reason_code) : kError;
  if (!answer.budget_exhausted.empty()) json["budget_exhausted"] = answer.budget_exhausted;
  json["confidence"] = fix.confidence;
  json["p_wrong"] = 1 - fix.confidence;
  json["witnesses"] = {{"place", fix.witnesses.place},
                       {"correspondences", fix.witnesses.correspondences},
                       {"dense", fix.witnesses.dense}};
  forEachStatistic(fix.statistics, [&](const char* name, const auto& value, Written) {
    write(json["statistics"], name, value);
  });
  json["size"] = answer.size;
  json["map"] = answer.map;
  json["map_checksum"] = answer.map_checksum;
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
  if (std::isfinite(fix.consensus_m)) json["consensus_m"] = fix.consensus_m;
  json["hypotheses"] = hypothesesOf(fix);
  if (answer.sequence) json["sequence"] = sequenceOf(*answer.sequence);
  if (answer.track) json["track"] = trackOf(*answer.track);
  json["timing_ms"] = timingOf(answer);
  return toText(json);
}

Answer answerIn(const std::string& line, const std::string& where) {
  try {
    return answerFrom(line);
  } catch (const std::exception& e) {
    std::string problem = e.what();  // "[json.exception.parse_error.101] ..."
    if (problem[0] == '[') problem.erase(0, problem.find(' ') + 1);
    throw Error(where, "expected an answer of xview localize --json; " + problem);
  }
}

std::vector<Answer> readAnswers(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(path, "cannot be opened");
  std::vector<Answer> answers;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (Answer answer = answerIn(line, fmt::format("{}:{}", path, number)); answer.error.empty())
      answers.push_back(std::move(answer));
  }
  if (file.bad()) throw Error(path, "cannot be read");
  if (answers.empty()) throw Error(path, "no answers");
  return answers;
}

const Eigen::Isometry3d& Truth::poseFor(const Answer& answer) const {
  if (answer.frames == poses_.size() && answer.last_index < poses_.size())
    return poses_[answer.last_index].T_frame_sensor;
  if (const io::StampedPose* stamped = withStamp(answer)) return stamped->T_frame_sensor;
  const auto number = static_cast<std::size_t>(answer.last_frame);
  if (answer.last_frame >= 0 && number < poses_.size()) return poses_[number].T_frame_sensor;
  throw Error(path_, fmt::format("expected a pose of frame {} of {}, found {} poses",
                                 answer.last_frame, answer.input, poses_.size()));
}

const io::StampedPose* Truth::withStamp(const Answer& answer) const {
  if (answer.last_stamp_s == static_cast<double>(answer.last_index))
    return nullptr;  // a mere count
  const auto same = [&](const io::StampedPose& p) {
    return std::abs(p.stamp_s - answer.last_stamp_s) < 1e-4;
  };
  const auto found = std::find_if(poses_.begin(), poses_.end(), same);
  return found == poses_.end() ? nullptr : &*found;
}

}  // namespace xview::tools
