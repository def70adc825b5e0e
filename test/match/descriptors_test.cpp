// SPDX-License-Identifier: BSD-3-Clause
#include "match/descriptors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "match/random_graph.h"

namespace xview::match {
namespace {

std::vector<Correspondence> bestMatches(const Descriptors& query, const Descriptors& map,
                                        const MatchOptions& options, int threads) {
  return DescriptorIndex(map).bestMatches(query, options, threads);
}

Descriptors describeAlone(const SemanticGraph& graph) {
  return describe(graph, LabelAlphabet(graph), {}, 1, 1);
}

/// All pairs, scored by the definition.
std::vector<Correspondence> bestByBruteForce(const Descriptors& query, const Descriptors& map,
                                             const MatchOptions& options) {
  std::map<WalkKey, double> holders;
  std::map<std::size_t, double> of_class;
  for (const std::vector<WalkCount>& list : map) {
    of_class[list.at(0).key & 255] += 1;
    for (const WalkCount& c : list) holders[c.key] += 1;
  }
  const auto weight = [&](WalkKey key) {
    if (!options.rare_words) return 1.0;
    const double held_by = holders.count(key) ? holders[key] : 1;
    return std::log(1 + of_class[key & 255] / held_by);
  };
  const auto words = [](const Descriptors& d, std::size_t v) {
    std::map<WalkKey, double> result;
    for (const WalkCount& c : d[v]) result[c.key] = c.count;
    return result;
  };
  std::vector<Correspondence> all;
  for (std::uint32_t q = 0; q < query.size(); ++q) {
    std::vector<Correspondence> list;
    for (std::uint32_t m = 0; m < map.size(); ++m) {
      double common = 0, total_q = 0, total_m = 0;
      auto a = words(query, q), b = words(map, m);
      for (const auto& [key, count] : a) {
        total_q += weight(key) * count;
        if (b.count(key)) common += weight(key) * std::min(count, b[key]);
      }
      for (const auto& [key, count] : b) total_m += weight(key) * count;
      const double share = common / std::min(total_q, total_m);
      if (common > 0) list.push_back({q, m, static_cast<float>(share)});
    }
    std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) {
      return a.similarity > b.similarity + 1e-5f;
    });
    list.resize(std::min(list.size(), static_cast<std::size_t>(options.candidates)));
    all.insert(all.end(), list.begin(), list.end());
  }
  return all;
}

bool sameMatches(const std::vector<Correspondence>& a, const std::vector<Correspondence>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.query == y.query && x.map == y.map && x.similarity == y.similarity;
  });
}

TEST(Describe, DoesNotDependOnTheNumberOfThreads) {
  const SemanticGraph graph = randomGraph(300, 5, 0.03, 1);
  const LabelAlphabet alphabet(graph);
  const Descriptors one = describe(graph, alphabet, {}, 1, 1);
  const Descriptors three = describe(graph, alphabet, {}, 1, 3);
  const auto areSame = [](const WalkCount& a, const WalkCount& b) {
    return a.key == b.key && a.count == b.count;
  };
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_TRUE(
        std::equal(one[i].begin(), one[i].end(), three[i].begin(), three[i].end(), areSame));
  }
}

TEST(Describe, EmptyGraphHasNoDescriptors) {
  const Descriptors none = describeAlone(SemanticGraph());
  EXPECT_EQ(none.size(), 0u);
  EXPECT_TRUE(bestMatches(none, describeAlone(graphOf({1}, {})), {}, 1).empty());
  EXPECT_TRUE(bestMatches(describeAlone(graphOf({1}, {})), none, {}, 1).empty());
}

TEST(Similarity, IsOneForAVertexWithItselfSymmetricAndInTheUnitInterval) {
  const Descriptors d = describeAlone(randomGraph(60, 3, 0.08, 2));
  for (std::uint32_t i = 0; i < d.size(); ++i) {
    EXPECT_EQ(similarity(d[i], d[i]), 1.0);
    for (std::uint32_t j = 0; j < d.size(); ++j) {
      const double s = similarity(d[i], d[j]);
      EXPECT_GE(s, 0.0);
      EXPECT_LE(s, 1.0);
      EXPECT_EQ(s, similarity(d[j], d[i]));
    }
  }
}

TEST(Similarity, IsZeroBetweenClasses) {
  const SemanticGraph graph = randomGraph(60, 3, 0.08, 2);
  const Descriptors d = describeAlone(graph);
  for (std::uint32_t i = 0; i < d.size(); ++i) {
    for (std::uint32_t j = 0; j < d.size(); ++j) {
      if (graph.vertices[i].label != graph.vertices[j].label) {
        EXPECT_EQ(similarity(d[i], d[j]), 0.0);
      }
    }
  }
}

TEST(BestMatches, EqualTheComparisonOfAllPairs) {
  const SemanticGraph map = randomGraph(150, 4, 0.04, 3), query = randomGraph(30, 5, 0.15, 4);
  const LabelAlphabet alphabet(query, map);
  const Descriptors m = describe(map, alphabet, {}, 1, 1);
  const Descriptors q = describe(query, alphabet, {}, 2, 1);
  for (const bool rare_words : {false, true}) {
    for (const int k : {1, 7, 1000}) {
      MatchOptions options;
      options.rare_words = rare_words;
      options.candidates = k;
      const auto expected = bestByBruteForce(q, m, options);
      const auto found = bestMatches(q, m, options, 1);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].query, expected[i].query);
        EXPECT_NEAR(found[i].similarity, expected[i].similarity, 2e-5);
      }
    }
  }
}

TEST(BestMatches, WithoutRarityAreTheSimilarityOfThePaper) {
  const Descriptors d = describeAlone(randomGraph(80, 3, 0.06, 5));
  MatchOptions options;
  options.rare_words = false;
  options.candidates = 1000;
  const auto matches = bestMatches(d, d, options, 1);
  ASSERT_FALSE(matches.empty());
  for (const Correspondence& c : matches) {
    EXPECT_NEAR(c.similarity, similarity(d[c.query], d[c.map]), 1e-6);
  }
}

TEST(BestMatches, FindEachVertexInItsOwnGraphWithSimilarityOne) {
  const SemanticGraph graph = randomGraph(200, 6, 0.03, 11);
  const Descriptors d = describeAlone(graph);
  const auto matches = bestMatches(d, d, {}, 1);
  std::vector<bool> itself(graph.size(), false);
  for (const Correspondence& c : matches) {
    EXPECT_GT(c.similarity, 0.f);
    EXPECT_LE(c.similarity, 1.f);
    if (c.query == c.map) {
      EXPECT_EQ(c.similarity, 1.f);
      itself[c.query] = true;
    }
  }
  EXPECT_GT(std::count(itself.begin(), itself.end(), true), 190);  // others lose a tie
}

TEST(BestMatches, PreferEarlierMapVerticesWhenTied) {
  // All labels equal on a ring: every vertex looks like every other one.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ring;
  for (std::uint32_t i = 0; i < 12; ++i) ring.emplace_back(i, (i + 1) % 12);
  const Descriptors d = describeAlone(graphOf(std::vector<std::uint32_t>(12, 1), ring));
  MatchOptions options;
  options.candidates = 3;
  const auto matches = bestMatches(d, d, options, 1);
  ASSERT_EQ(matches.size(), 36u);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].query, i / 3);
    EXPECT_EQ(matches[i].map, i % 3);
    EXPECT_EQ(matches[i].similarity, 1.f);
  }
}

TEST(BestMatches, WeighRareWordsMore) {
  // Query 0 shares a common word with map vertex 0 and a rare one with map vertex 5.
  const WalkKey common = 0x0201, rare = 0x0301;
  const Descriptors query = {{{common, 1}, {rare, 1}}};
  Descriptors map;
  for (int i = 0; i < 5; ++i)
    map.push_back({{common, 1}, {0x0401u + (static_cast<WalkKey>(i) << 8), 1}});
  map.push_back({{rare, 1}, {0x0A01, 1}});
  MatchOptions options;
  const auto weighted = bestMatches(query, map, options, 1);
  ASSERT_FALSE(weighted.empty());
  EXPECT_EQ(weighted[0].map, 5u);
  options.rare_words = false;
  const auto plain = bestMatches(query, map, options, 1);
  ASSERT_FALSE(plain.empty());
  EXPECT_EQ(plain[0].map, 0u);  // tied, so the first
}

TEST(BestMatches, DoNotDependOnTheNumberOfThreads) {
  const Descriptors d = describeAlone(randomGraph(150, 4, 0.05, 3));
  const DescriptorIndex index(d);
  EXPECT_TRUE(sameMatches(index.bestMatches(d, {}, 1), index.bestMatches(d, {}, 3)));
}

TEST(BestMatches, OfClassesTheMapDoesNotHaveAreNone) {
  const SemanticGraph map = graphOf({1, 2, 1}, {{0, 1}, {1, 2}});
  const SemanticGraph query = graphOf({9, 1}, {{0, 1}});
  const LabelAlphabet alphabet(map);
  const Descriptors m = describe(map, alphabet, {}, 1, 1);
  const Descriptors q = describe(query, alphabet, {}, 1, 1);
  EXPECT_TRUE(bestMatches(q, m, {}, 1).empty());
}

TEST(BestMatches, OfSingleVerticesMatchByLabel) {
  const SemanticGraph single = graphOf({5}, {});
  const Descriptors d = describeAlone(single);
  const auto matches = bestMatches(d, d, {}, 1);
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].similarity, 1.f);
}

}  // namespace
}  // namespace xview::match
