// SPDX-License-Identifier: BSD-3-Clause
// Answers as JSON lines: what is read of them is what was written.
#include "answer.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <nlohmann/json.hpp>

#include "round_trips/generators.h"
#include "support/test_data.h"

namespace xview::tools {
namespace {

namespace gen = rc::gen;

std::optional<double> maybeShare() {
  return *gen::arbitrary<bool>() ? std::optional(*test::anyNumber(1)) : std::nullopt;
}

Statistics anyStatistics() {
  Statistics s;
  s.likelihood_margin = *test::anyLength(1e4);
  s.score_ratio = *test::anyLength(1);
  s.vertex_inlier_ratio = *test::anyLength(1);
  s.map_coverage = *test::anyLength(1);
  s.dense_margin = *test::anyNumber(50);
  s.wrong_place_above_null = *test::anyNumber(1);
  s.wrong_place_miss_ratio = *test::anyLength(1);
  s.wrong_place_spread = *test::anyLength(1);
  s.sigma_m = *test::anyLength(9);
  s.dense.of = *gen::element(DenseEvidence::Of::nothing, DenseEvidence::Of::points,
                             DenseEvidence::Of::views);
  s.dense.converged = *gen::arbitrary<bool>();
  s.dense.aerial = *gen::arbitrary<bool>();
  s.dense.narrow = *gen::arbitrary<bool>();
  s.dense.indoors = *gen::arbitrary<bool>();
  s.dense.inlier_ratio = *test::anyLength(1);
  s.dense.null_inlier_ratio = *test::anyLength(1);
  for (auto* share :
       {&s.dense.conflict_ratio, &s.dense.obstacle_overlap, &s.dense.map_overlap,
        &s.dense.miss_ratio, &s.dense.self_consistency, &s.dense.free_space_violation})
    *share = maybeShare();
  return s;
}

/// Scales are powers of two, which change no digit of a rotation.
Answer anyAnswer() {
  Answer answer;
  answer.input = *test::anyText();
  answer.map = *test::anyText();
  answer.first_frame = *gen::inRange(0, 1000);
  answer.last_frame = answer.first_frame + *gen::inRange(0, 1000);
  answer.last_index = *gen::inRange<std::size_t>(0, 1000);
  answer.frames = *gen::inRange<std::size_t>(0, 1000);
  answer.last_stamp_s = *test::anyNumber(2e9);
  Localization& fix = answer.fix;
  fix.status = *gen::element(Status::accepted, Status::ambiguous, Status::rejected);
  fix.reason = *test::anyText();
  fix.confidence = *test::anyLength(1);
  fix.statistics = anyStatistics();
  fix.timing_ms = {{"read", *test::anyLength(1e5)}, {"pose", *test::anyLength(1e5)}};
  fix.scale = *gen::element(0.5, 1.0, 2.0);
  for (int i = *gen::inRange(0, 4); i > 0; --i)
    fix.hypotheses.push_back({*test::anyPose(), *test::anyNumber(1e4), *gen::inRange(0, 99), {}});
  if (fix.hypotheses.empty()) return answer;
  fix.T_map_query = *test::anyPose();
  fix.T_map_sensor = *test::anyPose();
  for (double& number : fix.covariance.reshaped()) number = *test::anyNumber(9);
  return answer;
}

nlohmann::json statisticsIn(const Answer& answer) {
  return nlohmann::json::parse(toJson(answer))["statistics"];
}

void requireSame(const Answer& read, const Answer& answer) {
  RC_ASSERT(read.input == answer.input);
  RC_ASSERT(read.map == answer.map);
  RC_ASSERT(read.first_frame == answer.first_frame);
  RC_ASSERT(read.last_frame == answer.last_frame);
  RC_ASSERT(read.last_index == answer.last_index);
  RC_ASSERT(read.frames == answer.frames);
  RC_ASSERT(read.last_stamp_s == answer.last_stamp_s);
  const Localization &a = read.fix, &b = answer.fix;
  RC_ASSERT(a.status == b.status);
  RC_ASSERT(a.reason == b.reason);
  RC_ASSERT(a.confidence == b.confidence);
  RC_ASSERT(read.whole_statistics ==
            (!b.statistics.dense.map_overlap || b.statistics.dense.miss_ratio));
  RC_ASSERT(statisticsIn(read) == statisticsIn(answer));
  RC_ASSERT(timeOf(a.timing_ms, "read") == timeOf(b.timing_ms, "read"));
  RC_ASSERT(timeOf(a.timing_ms, "pose") == timeOf(b.timing_ms, "pose"));
  RC_ASSERT(a.scale == b.scale);
  RC_ASSERT(a.covariance == b.covariance);
  RC_ASSERT(a.T_map_query.matrix() == b.T_map_query.matrix());
  RC_ASSERT((a.T_map_sensor.matrix() - b.T_map_sensor.matrix()).cwiseAbs().maxCoeff() < 1e-12);
  RC_ASSERT(a.hypotheses.size() == b.hypotheses.size());
  for (std::size_t i = 0; i < b.hypotheses.size(); ++i) {
    RC_ASSERT(a.hypotheses[i].T_map_query.matrix() == b.hypotheses[i].T_map_query.matrix());
    RC_ASSERT(a.hypotheses[i].score == b.hypotheses[i].score);
    RC_ASSERT(a.hypotheses[i].inliers == b.hypotheses[i].inliers);
  }
}

RC_GTEST_PROP(Answers, ComeBackFromTheirLines, ()) {
  std::vector<Answer> answers;
  for (int i = *gen::inRange(1, 4); i > 0; --i) answers.push_back(anyAnswer());
  std::string lines;
  for (const Answer& answer : answers) lines += toJson(answer) + "\n";
  test::writeText(test::scratch("answers.jsonl"), lines);
  const std::vector<Answer> read = readAnswers(test::scratch("answers.jsonl"));
  RC_ASSERT(read.size() == answers.size());
  for (std::size_t i = 0; i < answers.size(); ++i) requireSame(read[i], answers[i]);
}

}  // namespace
}  // namespace xview::tools
