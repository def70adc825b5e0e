// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

#include "match/random_graph.h"

namespace xview::match {
namespace {

/// Probability of each word by recursion over all walks.
void spell(const SemanticGraph& graph, const LabelAlphabet& alphabet, const WalkOptions& options,
           std::vector<std::uint32_t>& walk, WalkKey key, double probability,
           std::map<WalkKey, double>& words) {
  key |= WalkKey{alphabet(graph.vertices[walk.back()].label)} << (8 * (walk.size() - 1));
  std::vector<std::uint32_t> next;
  if (static_cast<int>(walk.size()) < options.walk_length) {
    for (const std::uint32_t v : graph.neighbours[walk.back()]) {
      if (options.immediate_return || walk.size() < 2 || v != walk[walk.size() - 2]) {
        next.push_back(v);
      }
    }
  }
  if (next.empty()) words[key] += probability;
  for (const std::uint32_t v : next) {
    walk.push_back(v);
    spell(graph, alphabet, options, walk, key, probability / static_cast<double>(next.size()),
          words);
    walk.pop_back();
  }
}

TEST(WalkSpectrum, EqualsTheEnumerationOfAllWalks) {
  for (const bool immediate_return : {false, true}) {
    for (const int length : {2, 3, 4, 5, 6}) {
      for (const double density : {0.05, 0.12, 0.25}) {
        WalkOptions options;
        options.walk_length = length;
        options.immediate_return = immediate_return;
        const SemanticGraph graph = randomGraph(18, 3, density, 4);
        const LabelAlphabet alphabet(graph);
        for (std::uint32_t v = 0; v < graph.size(); ++v) {
          std::vector<std::uint32_t> walk{v};
          std::map<WalkKey, double> expected;
          spell(graph, alphabet, options, walk, 0, 1.0, expected);
          const auto spectrum = walkSpectrum(graph, alphabet, v, options);
          ASSERT_EQ(spectrum.size(), expected.size());
          for (const WalkCount& c : spectrum) {
            EXPECT_NEAR(c.count, expected[c.key] * options.num_walks, 1e-4);
          }
        }
      }
    }
  }
}

TEST(WalkSpectrum, IsTheLimitOfManySampledWalks) {
  const SemanticGraph graph = randomGraph(30, 4, 0.15, 6);
  const LabelAlphabet alphabet(graph);
  WalkOptions options;
  options.num_walks = 100000;
  options.duplicates = true;
  for (std::uint32_t v = 0; v < graph.size(); ++v) {
    std::map<WalkKey, double> sampled;
    for (const WalkCount& c : sampleWalks(graph, alphabet, v, options, 1)) sampled[c.key] = c.count;
    for (const WalkCount& c : walkSpectrum(graph, alphabet, v, options)) {
      EXPECT_NEAR(sampled[c.key], c.count, 6 * std::sqrt(c.count + 1));
      sampled.erase(c.key);
    }
    EXPECT_TRUE(sampled.empty());
  }
}

TEST(WalkSpectrum, DoesNotDependOnTheNumberingOfVertices) {
  const SemanticGraph graph = randomGraph(25, 4, 0.2, 9);
  std::vector<std::uint32_t> order(graph.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = (7 * i + 3) % 25;
  const SemanticGraph other = renumbered(graph, order);
  const LabelAlphabet alphabet(graph);
  for (std::uint32_t v = 0; v < graph.size(); ++v) {
    const auto a = walkSpectrum(graph, alphabet, v, {});
    const auto b = walkSpectrum(other, alphabet, order[v], {});
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].key, b[i].key);
      EXPECT_NEAR(a[i].count, b[i].count, 1e-4);
    }
  }
}

TEST(WalkSpectrum, OfAnIsolatedVertexIsItsLabel) {
  const SemanticGraph graph = graphOf({3}, {});
  const auto spectrum = walkSpectrum(graph, LabelAlphabet(graph), 0, {});
  ASSERT_EQ(spectrum.size(), 1u);
  EXPECT_EQ(spectrum[0].key, 1u);
  EXPECT_FLOAT_EQ(spectrum[0].count, 200);
}

TEST(WalkSpectrum, OfALeafNeverReturnsToTheLeaf) {
  // 0 - 1 - 2, all of other classes: from 0 the only word is 1 2 3.
  const SemanticGraph chain = graphOf({1, 2, 3}, {{0, 1}, {1, 2}});
  const auto spectrum = walkSpectrum(chain, LabelAlphabet(chain), 0, {});
  ASSERT_EQ(spectrum.size(), 1u);
  EXPECT_EQ(spectrum[0].key, 0x030201u);
}

}  // namespace
}  // namespace xview::match
