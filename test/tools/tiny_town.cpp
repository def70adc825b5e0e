// SPDX-License-Identifier: BSD-3-Clause
#include "tools/tiny_town.h"

namespace xview::test {

Outcome succeed(const std::vector<std::string>& arguments) {
  const Outcome outcome = runXview(arguments, {120, 0, ""});
  EXPECT_EQ(outcome.code, 0) << arguments[0] << ": " << outcome.err;
  return outcome;
}

Eigen::Isometry3d poseIn(const Json& answer) {
  Eigen::Matrix4d T;
  for (Eigen::Index i = 0; i < 16; ++i)
    T(i / 4, i % 4) = answer["T_map_query"][static_cast<std::size_t>(i)].get<double>();
  return Eigen::Isometry3d(T);
}

void TinyTown::SetUpTestSuite() {
#ifndef XVIEW_WITH_SIM
  GTEST_SKIP() << "this build has no simulator";
#endif
  folder_ = new TemporaryFolder;
  simulated_ =
      runXview({"simulate", "-q", town(""), "--seed", "5", "--route_length_m", "84", "--width",
                "160", "--height", "120", "--sessions.elsewhere", "--sessions.lidar"},
               {120, 0, ""});
  mapped_ = runXview({"map", "-q", town("forward"), map()}, {120, 0, ""});
}

TemporaryFolder* TinyTown::folder_ = nullptr;
Outcome TinyTown::simulated_, TinyTown::mapped_;

}  // namespace xview::test
