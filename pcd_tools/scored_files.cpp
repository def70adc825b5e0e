// SPDX-License-Identifier: BSD-3-Clause
#include "scored_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "answer.h"
#include "xview/base/error.h"
#include "xview/io/pose_files.h"

namespace xview::tools {
namespace {

/// The true pose of each stamp: that of the nearest stamp within 10 ms, as evo_ape pairs them;
/// else, of two files of the same length whose stamps have nothing in common, that of the same
/// line.
std::vector<const io::StampedPose*> partnersOf(const std::vector<io::StampedPose>& found,
                                               const std::vector<io::StampedPose>& truth) {
  constexpr double kSame_s = 0.01;
  std::vector<const io::StampedPose*> partners;
  bool is_any = false;
  for (const io::StampedPose& pose : found) {
    const auto gap = [&](const io::StampedPose& p) { return std::abs(p.stamp_s - pose.stamp_s); };
    const auto nearest = std::min_element(
        truth.begin(), truth.end(), [&](const auto& a, const auto& b) { return gap(a) < gap(b); });
    const bool has_one = nearest != truth.end() && gap(*nearest) <= kSame_s;
    partners.push_back(has_one ? &*nearest : nullptr);
    is_any = is_any || has_one;
  }
  for (std::size_t i = 0; !is_any && found.size() == truth.size() && i < found.size(); ++i)
    partners[i] = &truth[i];
  return partners;
}

std::vector<ScoredQuery> scoredTrajectory(const std::string& path, const std::string& truth_path,
                                          const Narrative& narrate) {
  const std::vector<io::StampedPose> found = io::readPoses(path), truth = io::readPoses(truth_path);
  const std::vector<const io::StampedPose*> partners = partnersOf(found, truth);
  std::vector<ScoredQuery> queries;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!partners[i]) continue;
    ScoredQuery query;
    query.input = path;
    query.first_frame = query.last_frame = static_cast<std::int64_t>(i);
    query.fix = acceptedPose(found[i].T_frame_sensor);
    query.truth = partners[i]->T_frame_sensor;
    queries.push_back(query);
  }
  if (queries.empty())
    throw Error(path, fmt::format("none of its {} stamps is one of the {} of {} (within 0.01 s)",
                                  found.size(), truth.size(), truth_path));
  if (queries.size() < found.size())
    narrate.note(fmt::format("{} of {} poses have no true one within 0.01 s and are left out",
                             found.size() - queries.size(), found.size()));
  return queries;
}

}  // namespace

bool isTrajectory(const std::string& path) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && line[first] != '#') return line[first] != '{';
  }
  return false;
}

Localization acceptedPose(const Eigen::Isometry3d& T_map_sensor) {
  Localization fix;
  fix.status = Status::accepted;
  fix.confidence = 1;
  fix.hypotheses.resize(1);
  fix.T_map_sensor = T_map_sensor;
  return fix;
}

std::vector<ScoredQuery> scoredFile(const std::string& results, const std::string& truth_path,
                                    const Narrative& narrate) {
  if (isTrajectory(results)) return scoredTrajectory(results, truth_path, narrate);
  const Truth truth(truth_path);
  std::vector<ScoredQuery> queries;
  for (const Answer& answer : readAnswers(results))
    queries.push_back({answer.input, answer.first_frame, answer.last_frame, answer.fix, false,
                       truth.poseFor(answer)});
  return queries;
}

}  // namespace xview::tools
