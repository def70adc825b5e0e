// SPDX-License-Identifier: BSD-3-Clause
#include "process/module.h"

#include <gtest/gtest.h>

#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {
namespace {

TEST(Modules, ThatAreMissingAreNamedWithTheirUseAndTheirPlace) {
  const std::string said =
      test::messageOf<Error>([] { moduleFunction("xview_absent", "f", "holograms"); });
  EXPECT_EQ(said.find("xview_absent.so: is missing; it is for holograms"), 0u) << said;
  EXPECT_NE(said.find("lib"), std::string::npos) << said;
}

}  // namespace
}  // namespace xview
