// SPDX-License-Identifier: BSD-3-Clause
#include "match/walks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "match/random_graph.h"
#include "xview/base/error.h"

namespace xview::match {
namespace {

/// A walk as a word, and how probable it is.
struct SpelledWalk {
  WalkKey key = 0;
  double probability = 0;
};

/// Every walk of vertices that the rules allow.
void listWalks(const SemanticGraph& graph, const LabelAlphabet& alphabet,
               const WalkOptions& options, double probability, std::vector<std::uint32_t>& walk,
               std::vector<SpelledWalk>& walks) {
  std::vector<std::uint32_t> next;
  if (static_cast<int>(walk.size()) < options.walk_length) {
    for (const std::uint32_t v : graph.neighbours[walk.back()]) {
      if (options.immediate_return || walk.size() < 2 || walk[walk.size() - 2] != v)
        next.push_back(v);
    }
  }
  for (const std::uint32_t v : next) {
    walk.push_back(v);
    listWalks(graph, alphabet, options, probability / static_cast<double>(next.size()), walk,
              walks);
    walk.pop_back();
  }
  if (!next.empty()) return;
  WalkKey key = 0;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    key |= WalkKey{alphabet(graph.vertices[walk[i]].label)} << (8 * i);
  }
  walks.push_back({key, probability});
}

std::vector<SpelledWalk> spelledWalks(const SemanticGraph& graph, std::uint32_t start,
                                      const WalkOptions& options) {
  std::vector<std::uint32_t> walk{start};
  std::vector<SpelledWalk> walks;
  listWalks(graph, LabelAlphabet(graph), options, 1, walk, walks);
  return walks;
}

float total(const std::vector<WalkCount>& counts) {
  float sum = 0;
  for (const WalkCount& c : counts) sum += c.count;
  return sum;
}

std::vector<WalkCount> walksFrom(const SemanticGraph& graph, std::uint32_t vertex,
                                 const WalkOptions& options, std::uint64_t seed = 1) {
  const LabelAlphabet alphabet(graph);
  return Walks(graph, alphabet, options, seed).from(vertex);
}

WalkOptions walkOptions(int n, int m, bool immediate_return = false) {
  WalkOptions options;
  options.num_walks = n;
  options.walk_length = m;
  options.immediate_return = immediate_return;
  return options;
}

constexpr int kAll = 0;

TEST(LabelAlphabet, NumbersTheLabelsOfBothGraphsFromOne) {
  const LabelAlphabet alphabet(graphOf({70000, 5}, {}), graphOf({5, 9}, {}));
  EXPECT_EQ(alphabet.size(), 3u);
  EXPECT_EQ(alphabet(5), 1);
  EXPECT_EQ(alphabet(9), 2);
  EXPECT_EQ(alphabet(70000), 3);
  EXPECT_EQ(alphabet(6), LabelAlphabet::kUnknown);
}

TEST(LabelAlphabet, Takes254ClassesAndRefusesMore) {
  SemanticGraph graph;
  for (std::uint32_t i = 0; i < 254; ++i) graph.vertices.emplace_back().label = 3 * i;
  EXPECT_EQ(LabelAlphabet(graph)(3 * 253), 254);
  graph.vertices.emplace_back().label = 1;
  EXPECT_THROW(LabelAlphabet{graph}, UsageError);
}

/// The probability of every word, by listing all walks.
std::map<WalkKey, double> wordsOf(const SemanticGraph& graph, std::uint32_t vertex,
                                  const WalkOptions& options) {
  std::map<WalkKey, double> words;
  for (const SpelledWalk& walk : spelledWalks(graph, vertex, options))
    words[walk.key] += walk.probability;
  return words;
}

TEST(Walks, CountEveryWordByItsProbability) {
  for (const bool immediate_return : {false, true}) {
    for (const int length : {2, 3, 4, 6}) {
      const auto options = walkOptions(kAll, length, immediate_return);
      const SemanticGraph graph = randomGraph(25, 4, 0.15, 3);
      for (std::uint32_t v = 0; v < graph.size(); ++v) {
        const auto expected = wordsOf(graph, v, options);
        const auto walks = walksFrom(graph, v, options);
        ASSERT_EQ(walks.size(), expected.size()) << "vertex " << v << ", " << length;
        auto word = expected.begin();
        for (const WalkCount& c : walks) {
          EXPECT_EQ(c.key, word->first);
          EXPECT_NEAR(c.count, word->second, 1e-6);
          ++word;
        }
      }
    }
  }
}

TEST(Walks, DrawnOnesOccurAsOftenAsTheyAreProbable) {
  const SemanticGraph graph = randomGraph(30, 4, 0.15, 6);
  const auto options = walkOptions(100000, 4);
  for (std::uint32_t v = 0; v < graph.size(); ++v) {
    std::map<WalkKey, double> drawn;
    for (const WalkCount& c : walksFrom(graph, v, options)) drawn[c.key] = c.count;
    for (const auto& [key, probability] : wordsOf(graph, v, options)) {
      const double expected = probability * options.num_walks;
      EXPECT_NEAR(drawn[key], expected, 6 * std::sqrt(expected + 1));
      drawn.erase(key);
    }
    EXPECT_TRUE(drawn.empty());
  }
}

TEST(Walks, DependOnTheSeedOnlyIfDrawnAndOnNothingBeyondTheNeighbourhood) {
  const SemanticGraph graph = randomGraph(30, 4, 0.3, 5);
  SemanticGraph larger = graph;
  for (std::uint32_t i = 0; i < 20; ++i) {
    larger.vertices.emplace_back().label = 10;
    larger.neighbours.emplace_back();
  }
  const LabelAlphabet alphabet(larger);
  const auto counts = [&](const SemanticGraph& g, int n, std::uint64_t seed) {
    std::vector<std::pair<WalkKey, float>> result;
    for (const WalkCount& c : Walks(g, alphabet, walkOptions(n, 4), seed).from(4))
      result.emplace_back(c.key, c.count);
    return result;
  };
  for (const int n : {kAll, 50}) EXPECT_EQ(counts(graph, n, 1), counts(larger, n, 1));
  EXPECT_NE(counts(graph, 50, 1), counts(graph, 50, 2));
  EXPECT_EQ(counts(graph, kAll, 1), counts(graph, kAll, 2));
}

TEST(Walks, IsolatedVertexHasItsOwnLabelAsItsOnlyWord) {
  const SemanticGraph graph = graphOf({4, 7}, {});
  for (const int n : {kAll, 200}) {
    const auto walks = walksFrom(graph, 1, walkOptions(n, 4));
    ASSERT_EQ(walks.size(), 1u);
    EXPECT_EQ(walks[0].key, 2u);
    EXPECT_EQ(total(walks), std::max(n, 1));
  }
}

TEST(Walks, EndEarlyInADeadEndUnlessTheyMayReturn) {
  const SemanticGraph chain = graphOf({1, 2}, {{0, 1}});
  for (const int n : {kAll, 10}) {
    const auto stuck = walksFrom(chain, 0, walkOptions(n, 4));
    ASSERT_EQ(stuck.size(), 1u);
    EXPECT_EQ(stuck[0].key, 0x0201u);
    const auto back_and_forth = walksFrom(chain, 0, walkOptions(n, 4, true));
    ASSERT_EQ(back_and_forth.size(), 1u);
    EXPECT_EQ(back_and_forth[0].key, 0x02010201u);
  }
}

TEST(Walks, OfEightVerticesFitTheWord) {
  std::vector<std::uint32_t> labels;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < 254; ++i) {
    labels.push_back(i);
    if (i > 0) edges.emplace_back(i - 1, i);
  }
  const auto walks = walksFrom(graphOf(labels, edges), 246, walkOptions(kAll, 8));
  ASSERT_EQ(walks.size(), 2u);
  EXPECT_EQ(walks[1].key, 0xFEFDFCFBFAF9F8F7ull);
}

}  // namespace
}  // namespace xview::match
