// SPDX-License-Identifier: BSD-3-Clause
#include "match/walks.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/random.h"
#include "xview/base/error.h"

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
  double probability = 1;

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

/// The last letters, most of the work, are counted in a table with a row for all that walks have
/// spelled before them. Read by column it gives the words in increasing order.
void Walks::spell(std::uint32_t start, std::vector<std::pair<WalkKey, double>>& words) const {
  std::vector<Step> steps{{start, start, 1, letters_[start], 1}}, longer;
  // The probability of every further vertex. A walk that can go nowhere is a word.
  const auto shareOf = [&](const Step& step) {
    const bool skips = !options_.immediate_return && step.before != step.vertex;
    const std::size_t choices = graph_.neighbours[step.vertex].size() - (skips ? 1 : 0);
    if (choices == 0) words.emplace_back(step.word, step.probability);
    return choices > 0 ? step.probability / static_cast<double>(choices) : 0;
  };
  for (int length = 2; length < options_.walk_length; ++length) {
    for (const Step& step : steps) {
      const double share = shareOf(step);
      for (const std::uint32_t next : graph_.neighbours[step.vertex]) {
        if (next == step.before && !options_.immediate_return) continue;
        longer.push_back({next, step.vertex, length, step.with(letters_[next]), share});
      }
    }
    steps.swap(longer);
    longer.clear();
  }
  std::sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) {
    return std::tie(a.word, a.vertex, a.before) < std::tie(b.word, b.vertex, b.before);
  });
  std::array<bool, 256> occurs{};
  for (const Step& step : steps) {
    for (const LetterCount& last : around_[step.vertex]) occurs[last.letter] = true;
  }
  std::array<std::size_t, 256> column_of{};
  std::vector<std::uint8_t> letters;
  for (std::size_t letter = 0; letter < occurs.size(); ++letter) {
    column_of[letter] = letters.size();
    if (occurs[letter]) letters.push_back(static_cast<std::uint8_t>(letter));
  }
  std::vector<const Step*> rows;
  std::vector<double> sums;
  for (const Step& step : steps) {
    if (rows.empty() || rows.back()->word != step.word) {
      rows.push_back(&step);
      sums.resize(sums.size() + letters.size());
    }
    double* row = sums.data() + sums.size() - letters.size();
    const double share = shareOf(step);
    const bool skips = !options_.immediate_return && step.before != step.vertex;
    for (const LetterCount& last : around_[step.vertex])
      row[column_of[last.letter]] +=
          share * (last.count - (skips && last.letter == letters_[step.before] ? 1 : 0));
  }
  for (std::size_t column = 0; column < letters.size(); ++column) {
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const double sum = sums[row * letters.size() + column];
      if (sum > 0) words.emplace_back(rows[row]->with(letters[column]), sum);
    }
  }
}

std::vector<WalkCount> Walks::from(std::uint32_t vertex) const {
  std::vector<std::pair<WalkKey, double>> words;
  if (options_.num_walks == 0) {
    spell(vertex, words);
  } else {
    Random random(seed_, vertex);
    for (int i = 0; i < options_.num_walks; ++i) words.emplace_back(draw(vertex, random), 1);
  }
  if (!std::is_sorted(words.begin(), words.end())) std::sort(words.begin(), words.end());
  std::vector<WalkCount> counts;
  counts.reserve(words.size());
  for (auto word = words.begin(); word != words.end();) {
    double sum = 0;
    const WalkKey key = word->first;
    for (; word != words.end() && word->first == key; ++word) sum += word->second;
    counts.push_back({key, static_cast<float>(sum)});
  }
  return counts;
}

}  // namespace xview::match
