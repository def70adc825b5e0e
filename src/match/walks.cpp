// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walks.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "xview/types/error.h"
#include "xview/types/random.h"

namespace xview::match {
namespace {

constexpr int kMaxLength = 8;
constexpr int kMaxTriesPerWalk = 20;   // rejected duplicates before the draw gives up
constexpr std::size_t kEnumerate = 4;  // times num_walks: up to here walks are listed, not drawn

/// The vertices of a walk; unused places hold the start vertex's own number, which `length` hides.
struct Walk {
  std::array<std::uint32_t, kMaxLength> vertices{};
  int length = 0;
  bool operator==(const Walk& o) const { return length == o.length && vertices == o.vertices; }
};

/// Where a walk may go: the neighbours of its last vertex, without the one before if it must not
/// return at once. `skip` is the position of that one, or the number of neighbours.
struct Choices {
  const std::vector<std::uint32_t>& neighbours;
  std::size_t skip;
  std::size_t size() const { return neighbours.size() - (skip < neighbours.size() ? 1 : 0); }
  std::uint32_t operator[](std::size_t i) const { return neighbours[i + (i >= skip ? 1 : 0)]; }
};

class Walker {
 public:
  Walker(const SemanticGraph& graph, const LabelAlphabet& alphabet, const WalkOptions& options)
      : graph_(graph), alphabet_(alphabet), options_(options) {}

  Walk draw(std::uint32_t start, Random& random) const {
    Walk walk = from(start);
    while (walk.length < options_.walk_length) {
      const Choices next = choices(walk);
      if (next.size() == 0) break;
      push(walk, next[random.below(static_cast<std::uint32_t>(next.size()))]);
    }
    return walk;
  }

  /// All walks with their probabilities, or the first limit + 1 of them.
  void enumerate(const Walk& walk, double probability, std::size_t limit, std::vector<Walk>& walks,
                 std::vector<double>& probabilities) const {
    if (walks.size() > limit) return;
    const Choices next = choices(walk);
    if (walk.length == options_.walk_length || next.size() == 0) {
      walks.push_back(walk);
      probabilities.push_back(probability);
      return;
    }
    for (std::size_t i = 0; i < next.size(); ++i) {
      Walk longer = walk;
      push(longer, next[i]);
      enumerate(longer, probability / static_cast<double>(next.size()), limit, walks,
                probabilities);
    }
  }

  static Walk from(std::uint32_t start) {
    Walk walk;
    push(walk, start);
    return walk;
  }

  WalkKey word(const Walk& walk) const {
    WalkKey key = 0;
    for (int i = 0; i < walk.length; ++i) {
      key |= WalkKey{alphabet_(graph_.vertices[walk.vertices[i]].label)} << (8 * i);
    }
    return key;
  }

 private:
  static void push(Walk& walk, std::uint32_t vertex) {
    walk.vertices[static_cast<std::size_t>(walk.length++)] = vertex;
  }

  Choices choices(const Walk& walk) const {
    const auto& list = graph_.neighbours[walk.vertices[walk.length - 1]];
    std::size_t skip = list.size();
    if (!options_.immediate_return && walk.length > 1) {
      const auto previous =
          std::lower_bound(list.begin(), list.end(), walk.vertices[walk.length - 2]);
      skip = static_cast<std::size_t>(previous - list.begin());
    }
    return {list, skip};
  }

  const SemanticGraph& graph_;
  const LabelAlphabet& alphabet_;
  const WalkOptions& options_;
};

struct HashOfWalk {
  std::size_t operator()(const Walk& walk) const {
    std::uint64_t h = static_cast<std::uint64_t>(walk.length);
    for (int i = 0; i < walk.length; ++i) h = (h ^ walk.vertices[i]) * 0x9E3779B97F4A7C15ull;
    return static_cast<std::size_t>(h ^ (h >> 32));
  }
};

/// Draws `count` of the walks without replacement, each time by probability: the smallest of
/// exponential waiting times (Efraimidis & Spirakis 2006).
void keepRandom(std::vector<Walk>& walks, const std::vector<double>& probabilities,
                std::size_t count, Random& random) {
  struct Waiting {
    double time;
    std::uint32_t walk;
  };
  std::vector<Waiting> waiting(walks.size());
  for (std::uint32_t i = 0; i < waiting.size(); ++i) {
    waiting[i] = {-std::log(1.0 - random.uniform()) / probabilities[i], i};
  }
  std::nth_element(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count),
                   waiting.end(), [](const Waiting& a, const Waiting& b) {
                     return a.time != b.time ? a.time < b.time : a.walk < b.walk;
                   });
  std::vector<Walk> kept(count);
  for (std::size_t i = 0; i < count; ++i) kept[i] = walks[waiting[i].walk];
  walks = std::move(kept);
}

std::vector<Walk> drawDistinct(const Walker& walker, std::uint32_t vertex, std::size_t count,
                               Random& random) {
  std::vector<Walk> walks;
  std::vector<double> probabilities;
  walker.enumerate(Walker::from(vertex), 1.0, kEnumerate * count, walks, probabilities);
  if (walks.size() <= count) return walks;
  if (walks.size() <= kEnumerate * count) {
    keepRandom(walks, probabilities, count, random);
    return walks;
  }
  std::unordered_set<Walk, HashOfWalk> distinct(2 * count);
  for (std::size_t i = 0; i < kMaxTriesPerWalk * count && distinct.size() < count; ++i)
    distinct.insert(walker.draw(vertex, random));
  return {distinct.begin(), distinct.end()};
}

std::vector<WalkCount> countWords(std::vector<WalkKey>& keys) {
  std::sort(keys.begin(), keys.end());
  std::vector<WalkCount> counts;
  for (const WalkKey key : keys) {
    if (counts.empty() || counts.back().key != key) counts.push_back({key, 0});
    counts.back().count += 1;
  }
  return counts;
}

}  // namespace

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

std::vector<WalkCount> sampleWalks(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                                   std::uint32_t vertex, const WalkOptions& options,
                                   std::uint64_t seed) {
  const Walker walker(graph, alphabet, options);
  const auto count = static_cast<std::size_t>(options.num_walks);
  Random random(seed, vertex);
  std::vector<WalkKey> keys;
  keys.reserve(count);
  if (options.duplicates) {
    for (std::size_t i = 0; i < count; ++i)
      keys.push_back(walker.word(walker.draw(vertex, random)));
  } else {
    for (const Walk& walk : drawDistinct(walker, vertex, count, random)) {
      keys.push_back(walker.word(walk));
    }
  }
  return countWords(keys);
}

}  // namespace xview::match
