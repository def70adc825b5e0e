// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "xview/types/error.h"
#include "xview/types/random.h"

namespace xview::match {
LabelAlphabet::LabelAlphabet(const SemanticGraph& a, const SemanticGraph& b) {
  for (const SemanticGraph* graph : {&a, &b}) {
    for (const Vertex& vertex : graph->vertices) {
      const auto place = std::lower_bound(labels_.begin(), labels_.end(), vertex.label);
      if (place == labels_.end() || *place != vertex.label) labels_.insert(place, vertex.label);
      if (labels_.size() >= kUnknown) {
        throw UsageError("walk descriptors take at most 254 classes, the graphs have more");
      }
    }
  }
  for (std::uint32_t label = 0; label < letters_.size(); ++label) letters_[label] = letterOf(label);
}

std::uint8_t LabelAlphabet::letterOf(std::uint32_t label) const {
  const auto place = std::lower_bound(labels_.begin(), labels_.end(), label);
  if (place == labels_.end() || *place != label) return kUnknown;
  return static_cast<std::uint8_t>(1 + (place - labels_.begin()));
}

Walks::Walks(const SemanticGraph& graph, const LabelAlphabet& alphabet, const WalkOptions& options,
             std::uint64_t seed)
    : graph_(graph), options_(options), seed_(seed) {
  for (const Vertex& vertex : graph.vertices) letters_.push_back(alphabet(vertex.label));
  if (options_.num_walks > 0) return;
  around_.resize(graph.size());
  std::array<std::uint32_t, 256> counts{};
  for (std::uint32_t v = 0; v < graph.size(); ++v) {
    for (const std::uint32_t other : graph.neighbours[v]) ++counts[letters_[other]];
    for (const std::uint32_t other : graph.neighbours[v]) {
      std::uint32_t& count = counts[letters_[other]];
      if (count > 0) around_[v].push_back({letters_[other], count});
      count = 0;
    }
  }
}

/// Where a walk is, and what it has spelled so far.
struct Walks::Step {
  std::uint32_t vertex = 0;
  std::uint32_t before = 0;  ///< the vertex before that, or the vertex itself
  int length = 1;            ///< vertices so far
  WalkKey word = 0;

  WalkKey with(std::uint8_t letter) const { return word | WalkKey{letter} << (8 * length); }
};

WalkKey Walks::draw(std::uint32_t start, Random& random) const {
  Step step{start, start, 1, letters_[start]};
  while (step.length < options_.walk_length) {
    const std::vector<std::uint32_t>& next = graph_.neighbours[step.vertex];
    // A vertex is no neighbour of itself: the first step may go anywhere.
    const auto back = options_.immediate_return
                          ? next.end()
                          : std::lower_bound(next.begin(), next.end(), step.before);
    const bool skips = back != next.end() && *back == step.before;
    const std::size_t choices = next.size() - (skips ? 1 : 0);
    if (choices == 0) break;
    std::size_t chosen = random.below(static_cast<std::uint32_t>(choices));
    if (skips && chosen >= static_cast<std::size_t>(back - next.begin())) ++chosen;
    step = {next[chosen], step.vertex, step.length + 1, step.with(letters_[next[chosen]])};
  }
  return step.word;
}

/// All walks that go on from a step. The last vertex counts by its letter only, so that walks which
/// end in one class are taken together.
void Walks::spell(const Step& step, double probability,
                  std::vector<std::pair<WalkKey, double>>& words) const {
  const std::vector<std::uint32_t>& next = graph_.neighbours[step.vertex];
  const bool skips = !options_.immediate_return && step.before != step.vertex;
  const std::size_t choices = next.size() - (skips ? 1 : 0);
  if (choices == 0) {
    words.emplace_back(step.word, probability);
    return;
  }
  const double each = probability / static_cast<double>(choices);
  if (step.length + 1 == options_.walk_length) {
    for (const LetterCount& last : around_[step.vertex]) {
      const std::uint32_t count =
          last.count - (skips && letters_[step.before] == last.letter ? 1 : 0);
      if (count > 0) words.emplace_back(step.with(last.letter), each * count);
    }
    return;
  }
  for (const std::uint32_t vertex : next) {
    if (skips && vertex == step.before) continue;
    spell({vertex, step.vertex, step.length + 1, step.with(letters_[vertex])}, each, words);
  }
}

std::vector<WalkCount> Walks::from(std::uint32_t vertex) const {
  std::vector<std::pair<WalkKey, double>> words;
  if (options_.num_walks == 0) {
    spell({vertex, vertex, 1, letters_[vertex]}, 1, words);
  } else {
    Random random(seed_, vertex);
    for (int i = 0; i < options_.num_walks; ++i) words.emplace_back(draw(vertex, random), 1);
  }
  std::sort(words.begin(), words.end());
  std::vector<WalkCount> counts;
  for (auto word = words.begin(); word != words.end();) {
    double sum = 0;
    const WalkKey key = word->first;
    for (; word != words.end() && word->first == key; ++word) sum += word->second;
    counts.push_back({key, static_cast<float>(sum)});
  }
  return counts;
}

}  // namespace xview::match
