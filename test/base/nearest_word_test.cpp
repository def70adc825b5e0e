// SPDX-License-Identifier: BSD-3-Clause
#include "base/user_text.h"

#include <gtest/gtest.h>

namespace xview {
namespace {

TEST(NearestWord, CountsInsertedDeletedAndReplacedLetters) {
  const std::vector<std::string> words = {"walks", "blobs", "edges"};
  EXPECT_EQ(nearestWord("walk", words), "walks");
  EXPECT_EQ(nearestWord("wallks", words), "walks");
  EXPECT_EQ(nearestWord("bloks", words), "blobs");
  EXPECT_EQ(nearestWord("edges", words), "edges");
}

TEST(NearestWord, TakesTheFirstOfEqualsAndNothingOfNothing) {
  EXPECT_EQ(nearestWord("b", {"a", "c"}), "a");
  EXPECT_EQ(nearestWord("", {"abc", "d"}), "d");
  EXPECT_EQ(nearestWord("a", {}), "");
}

TEST(NearestWord, IsNotFarFetched) {
  EXPECT_EQ(nearestWord("town.xvm", {"fuse", "graph", "view"}), "");
  EXPECT_EQ(nearestWord("localise", {"evaluate", "localize"}), "localize");
}

TEST(KnownWordsHint, NamesTheNearestElseFewElseNothing) {
  EXPECT_EQ(knownWordsHint("wallks", {"walks", "blobs"}), "; the nearest known one is walks");
  EXPECT_EQ(knownWordsHint("banana", {"walks", "blobs"}), "; known are walks, blobs");
  EXPECT_EQ(knownWordsHint("banana", std::vector<std::string>(21, "walks")), "");
}

}  // namespace
}  // namespace xview
