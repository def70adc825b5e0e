// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "match/random_graph.h"
#include "xview/types/error.h"

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

std::vector<WalkKey> allWalks(const SemanticGraph& graph, std::uint32_t start,
                              const WalkOptions& options) {
  std::vector<WalkKey> words;
  for (const SpelledWalk& walk : spelledWalks(graph, start, options)) words.push_back(walk.key);
  return words;
}

int total(const std::vector<WalkCount>& counts) {
  float sum = 0;
  for (const WalkCount& c : counts) sum += c.count;
  return static_cast<int>(sum);
}

std::vector<WalkCount> sample(const SemanticGraph& graph, std::uint32_t vertex,
                              const WalkOptions& options, std::uint64_t seed = 1) {
  return sampleWalks(graph, LabelAlphabet(graph), vertex, options, seed);
}

WalkOptions walkOptions(int n, int m, bool immediate_return, bool duplicates) {
  WalkOptions options;
  options.num_walks = n;
  options.walk_length = m;
  options.immediate_return = immediate_return;
  options.duplicates = duplicates;
  return options;
}

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

TEST(Walks, AreWordsOfRealWalksThatStartAtTheVertex) {
  for (const bool immediate_return : {false, true}) {
    for (const bool duplicates : {false, true}) {
      const auto options = walkOptions(60, 4, immediate_return, duplicates);
      const SemanticGraph graph = randomGraph(25, 4, 0.15, 3);
      for (std::uint32_t v = 0; v < graph.size(); ++v) {
        const auto possible = allWalks(graph, v, options);
        const std::set<WalkKey> words(possible.begin(), possible.end());
        for (const WalkCount& c : sample(graph, v, options)) {
          EXPECT_TRUE(words.count(c.key)) << "vertex " << v;
        }
      }
    }
  }
}

TEST(Walks, WithoutDuplicatesAreAsManyAsTheNeighbourhoodOffersUpToN) {
  for (const int n : {1, 5, 40, 200, 1000}) {
    const auto options = walkOptions(n, 4, false, false);
    const SemanticGraph graph = randomGraph(40, 3, 0.12, 8);
    for (std::uint32_t v = 0; v < graph.size(); ++v) {
      const int offered = static_cast<int>(allWalks(graph, v, options).size());
      EXPECT_EQ(total(sample(graph, v, options)), std::min(n, offered)) << "vertex " << v;
    }
  }
}

TEST(Walks, WithoutDuplicatesNeverRepeatAWalkOfVertices) {
  // Every vertex is a class of its own: a word tells the walk.
  for (const double density : {0.08, 0.15, 0.4}) {  // listed, thinned, drawn
    SemanticGraph graph = randomGraph(60, 1, density, 2);
    for (std::uint32_t i = 0; i < 60; ++i) graph.vertices[i].label = i;
    for (const WalkCount& c : sample(graph, 7, walkOptions(200, 4, false, false))) {
      EXPECT_EQ(c.count, 1);
    }
  }
}

TEST(Walks, AreAllListedWhenTheyAreNoMoreThanN) {
  const SemanticGraph graph = randomGraph(30, 4, 0.1, 5);
  const auto options = walkOptions(100000, 5, false, false);
  auto expected = allWalks(graph, 3, options);
  std::map<WalkKey, float> counts;
  for (const WalkKey key : expected) counts[key] += 1;
  const auto walks = sample(graph, 3, options);
  ASSERT_EQ(walks.size(), counts.size());
  for (const WalkCount& c : walks) EXPECT_EQ(c.count, counts[c.key]);
}

TEST(Walks, DrawnWithoutReplacementFavourProbableWalks) {
  // From 0 to the leaf 1, or by the hub 2 to one of 30 leaves: half of all walks are 0-1.
  std::vector<std::uint32_t> labels(33, 3);
  labels[0] = 1;
  labels[1] = 2;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges{{0, 1}, {0, 2}};
  for (std::uint32_t leaf = 3; leaf < 33; ++leaf) edges.emplace_back(2, leaf);
  const SemanticGraph graph = graphOf(labels, edges);
  int with_leaf = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const auto walks = sample(graph, 0, walkOptions(10, 3, false, false), seed);
    for (const WalkCount& c : walks) with_leaf += c.key == (1u | 2u << 8) ? 1 : 0;
    EXPECT_EQ(total(walks), 10);
  }
  EXPECT_GT(with_leaf, 390);  // missed with probability 2^-10 each
}

TEST(Walks, WithDuplicatesOccurAsOftenAsTheyAreProbable) {
  const SemanticGraph graph = randomGraph(30, 4, 0.15, 6);
  const LabelAlphabet alphabet(graph);
  WalkOptions options;
  options.num_walks = 100000;
  options.duplicates = true;
  for (std::uint32_t v = 0; v < graph.size(); ++v) {
    std::map<WalkKey, double> words, sampled;
    for (const SpelledWalk& walk : spelledWalks(graph, v, options))
      words[walk.key] += walk.probability;
    for (const WalkCount& c : sampleWalks(graph, alphabet, v, options, 1)) sampled[c.key] = c.count;
    for (const auto& [key, probability] : words) {
      const double expected = probability * options.num_walks;
      EXPECT_NEAR(sampled[key], expected, 6 * std::sqrt(expected + 1));
      sampled.erase(key);
    }
    EXPECT_TRUE(sampled.empty());
  }
}

TEST(Walks, DependOnTheSeedAndOnNothingBeyondTheNeighbourhood) {
  const auto options = walkOptions(50, 4, false, false);
  const SemanticGraph graph = randomGraph(30, 4, 0.3, 5);
  SemanticGraph larger = graph;
  for (std::uint32_t i = 0; i < 20; ++i) {
    larger.vertices.emplace_back().label = 10;
    larger.neighbours.emplace_back();
  }
  const LabelAlphabet alphabet(larger);
  const auto keys = [&](const SemanticGraph& g, std::uint64_t seed) {
    std::vector<WalkKey> result;
    for (const WalkCount& c : sampleWalks(g, alphabet, 4, options, seed)) result.push_back(c.key);
    return result;
  };
  EXPECT_EQ(keys(graph, 1), keys(graph, 1));
  EXPECT_EQ(keys(graph, 1), keys(larger, 1));
  EXPECT_NE(keys(graph, 1), keys(graph, 2));
}

TEST(Walks, IsolatedVertexHasItsOwnLabelAsItsOnlyWord) {
  const SemanticGraph graph = graphOf({4, 7}, {});
  const auto unique = sample(graph, 1, walkOptions(200, 4, false, false));
  ASSERT_EQ(unique.size(), 1u);
  EXPECT_EQ(unique[0].key, 2u);
  EXPECT_EQ(unique[0].count, 1);
  const auto repeated = sample(graph, 1, walkOptions(200, 4, false, true));
  ASSERT_EQ(repeated.size(), 1u);
  EXPECT_EQ(repeated[0].count, 200);
}

TEST(Walks, EndEarlyInADeadEndUnlessTheyMayReturn) {
  const SemanticGraph chain = graphOf({1, 2}, {{0, 1}});
  const auto stuck = sample(chain, 0, walkOptions(10, 4, false, true));
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].key, 0x0201u);
  const auto back_and_forth = sample(chain, 0, walkOptions(10, 4, true, true));
  ASSERT_EQ(back_and_forth.size(), 1u);
  EXPECT_EQ(back_and_forth[0].key, 0x02010201u);
}

TEST(Walks, OfEightVerticesFitTheWord) {
  std::vector<std::uint32_t> labels;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < 254; ++i) {
    labels.push_back(i);
    if (i > 0) edges.emplace_back(i - 1, i);
  }
  const auto walks = sample(graphOf(labels, edges), 246, walkOptions(10, 8, false, false));
  ASSERT_EQ(walks.size(), 2u);
  EXPECT_EQ(walks[1].key, 0xFEFDFCFBFAF9F8F7ull);
}

TEST(Walks, AreBoundedWorkWhereManyAreImprobable) {
  // 2 leaves of the start and a hub behind a hub: nearly all distinct walks are hard to reach.
  std::vector<std::uint32_t> labels(1200, 1);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges{{0, 1}};
  for (std::uint32_t i = 2; i < 400; ++i) edges.emplace_back(0, i);
  for (std::uint32_t i = 400; i < 1200; ++i) edges.emplace_back(1, i);
  const auto walks = sample(graphOf(labels, edges), 0, walkOptions(1000, 3, false, false));
  EXPECT_GT(total(walks), 398);
  EXPECT_LE(total(walks), 1000);
}

}  // namespace
}  // namespace xview::match
