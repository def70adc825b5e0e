// SPDX-License-Identifier: BSD-3-Clause
// A proposer of one's own: one class, and one line that names it as a method.
#include "localizer/proposer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "localizer/localizer_index.h"
#include "localizer/simulated_drive.h"
#include "xview/base/error.h"

namespace xview {
namespace {

using test::simulatedDrive;

/// Proposes that the robot is where the map was made, in either direction.
class KeyframeProposer final : public PlaceProposer {
 public:
  explicit KeyframeProposer(const ProposerInputs& inputs) : inputs_(inputs) {}

  Candidates propose(const Query& query, const Priors& priors, Timings&) const override {
    Candidates found;
    found.in_field = inputs_.fields.prepare(query);
    const Eigen::Isometry3d T_sensor_query = query.poses.back().inverse();
    std::vector<search::PlaceHypothesis> all;
    for (std::size_t i = 0; i < inputs_.map.poses.size(); i += 3) {
      const Eigen::Isometry3d& keyframe = inputs_.map.poses[i];
      for (const double yaw : {0.0, M_PI}) {
        Eigen::Isometry3d T_map_sensor = poseFromYaw(keyframe.translation(), yaw);
        T_map_sensor.linear() *= keyframe.linear();
        all.push_back(found.in_field->verify(T_map_sensor * T_sensor_query));
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.score() > b.score(); });
    for (const search::PlaceHypothesis& place : all) {
      const auto isSame = [&](const search::PlaceHypothesis& better) {
        return std::hypot(place.centre.x - better.centre.x, place.centre.y - better.centre.y) < 10;
      };
      if (satisfies(priors, query.sensor, place.T_map_query * query.poses.back()) &&
          std::none_of(found.places.begin(), found.places.end(), isSame))
        found.places.push_back(place);
    }
    found.to_register = countClose(found.places);
    return found;
  }

 private:
  const ProposerInputs inputs_;
};

constexpr Method kKeyframes = {
    "keyframes", true, true,
    [](const ProposerInputs& inputs) -> std::unique_ptr<const PlaceProposer> {
      return std::make_unique<const KeyframeProposer>(inputs);
    }};

TEST(Proposer, AThirdOneIsRegisteredAndJudgedAsTheOthersAre) {
  const auto& drive = simulatedDrive();
  const Query query = drive.query("rear", 10, 40);
  const PlaceIndex index(drive.map, {}, kKeyframes);
  const Localization fix = index.localize(query, {}),
                     searched = Localizer(drive.map).localize(query);
  EXPECT_EQ(fix.status, Status::accepted) << fix.reason;
  EXPECT_LT((fix.T_map_sensor.translation() - searched.T_map_sensor.translation()).norm(), 0.1);
  EXPECT_FALSE(fix.kept.empty()) << "the chain pairs the vertices at its places, too";

  const ExpectedPose elsewhere{
      Eigen::Translation3d(0, 200, 0) * drive.map.poses[0] * query.poses.back().inverse(), 20, 0.2};
  EXPECT_NE(index.localize(query, {&elsewhere}).status, Status::accepted);
}

TEST(Proposer, MethodsAreKnownByName) {
  Options options;
  for (const char* name : {"auto", "search", "walks"}) {
    options.method = name;
    EXPECT_STREQ(methodOf(options).name, name);
  }
  options.method = "keyframes";
  EXPECT_THROW(methodOf(options), UsageError);
}

}  // namespace
}  // namespace xview
