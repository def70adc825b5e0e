// SPDX-License-Identifier: BSD-3-Clause
#include "base/user_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {
namespace {

TEST(PriorText, CircleIsInMetres) {
  const PlacePrior::Circle circle = parseCircle("--near", "12.5,-3e1,0.5");
  EXPECT_EQ(circle.x, 12.5);
  EXPECT_EQ(circle.y, -30);
  EXPECT_EQ(circle.radius, 0.5);
}

TEST(PriorText, HeadingIsInDegrees) {
  const PlacePrior::Heading heading = parseHeading("--yaw", "-90,45");
  EXPECT_DOUBLE_EQ(heading.yaw, -M_PI / 2);
  EXPECT_DOUBLE_EQ(heading.tolerance, M_PI / 4);
}

TEST(PriorText, WhatMakesNoSenseIsRefusedUnderTheNameThatWasWritten) {
  for (const char* text : {"", "1", "1,2", "1,2,3,4", "1,2,x", "1,2,3m", "1,,3", "1,2,0", "1,2,-3",
                           "nan,2,3", "1,inf,3", "1,2,nan", "1e999,2,3"}) {
    const std::string refusal = test::messageOf<UsageError>([&] { parseCircle("--near", text); });
    EXPECT_EQ(refusal.rfind(std::string("--near = ") + text, 0), 0u) << text << ": " << refusal;
  }
  for (const char* text : {"", "1", "north,5", "1,0", "1,-5", "1,2,3", "nan,5", "5,nan"}) {
    const std::string refusal =
        test::messageOf<UsageError>([&] { parseHeading("prior.yaw", text); });
    EXPECT_EQ(refusal.rfind(std::string("prior.yaw = ") + text, 0), 0u) << text << ": " << refusal;
  }
}

}  // namespace
}  // namespace xview
