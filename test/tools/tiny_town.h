// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "support/json_lines.h"
#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {

Outcome succeed(const std::vector<std::string>& arguments);

Eigen::Isometry3d poseIn(const Json& answer);

/// A tiny town, simulated and mapped once for all tests.
class TinyTown : public testing::Test {
 protected:
  static void SetUpTestSuite();
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string town(const std::string& session) { return *folder_ / ("town/" + session); }
  static std::string map() { return *folder_ / "town.xvm"; }
  static std::string file(const std::string& name) { return *folder_ / name; }

  void SetUp() override {
    ASSERT_EQ(simulated_.code, 0) << simulated_.err;
    ASSERT_EQ(mapped_.code, 0) << mapped_.err;
  }

  static TemporaryFolder* folder_;
  static Outcome simulated_, mapped_;
};

}  // namespace xview::test
