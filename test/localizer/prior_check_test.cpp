// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>
#include <utility>

#include "base/pose.h"
#include "localizer/two_streets.h"
#include "verdict/verdict.h"

namespace xview {
namespace {

/// A verdict that believes whatever it looked at closely, which tells these streets apart.
std::string credulousModel() {
  verdict::VerdictModel model = verdict::defaultVerdictModel();
  model.registered = {};
  model.registered[verdict::kConstant] = 5;
  const std::string path = testing::TempDir() + "/credulous_verdict.txt";
  std::ofstream(path) << verdict::toText(model);
  return path;
}

Localization localizeNear(const char* circle, double x, const std::string& verdict_model = "") {
  const test::BevTown town = test::twoStreets(false);
  const map::SemanticMap map = test::mapOf(town);
  Options options;
  options.threads = 1;
  options.prior.near = circle;
  options.verdict.model = verdict_model;
  const Query query = test::queryAt(town, x, 0, poseFromYaw({310, -40, 5}, 2.3));
  return Localizer(map, options).localize(query);
}

TEST(Prior, IsRefutedByAFarBetterPlaceElsewhere) {
  EXPECT_FALSE(localizeNear("-7,200,6", -7).accepted());
  const Localization fix = localizeNear("-7,200,6", -7, credulousModel());
  EXPECT_FALSE(fix.accepted());
  EXPECT_EQ(fix.reason.rfind("a place outside of the prior is", 0), 0u) << fix.reason;
}

TEST(Prior, DecidesBetweenTwoPlacesThatAreAlike) {
  for (const auto& [circle, y] : {std::pair{"60,200,15", 200.0}, {"60,0,15", 0.0}}) {
    const Localization fix = localizeNear(circle, 60);
    EXPECT_TRUE(fix.accepted()) << fix.reason;
    EXPECT_LT(test::errorOf(fix, 60, y), 0.5);
  }
}

}  // namespace
}  // namespace xview
