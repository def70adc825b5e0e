// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walks.h"

#include <algorithm>
#include <cmath>
#include <tuple>
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

namespace {

constexpr std::uint32_t kNowhere = 0xFFFFFFFFu;
constexpr double kRounding = 1e-12;  // shares below this are what subtraction leaves of zero

/// All walks that spell `key` so far and stand at `vertex` having come from `previous`.
struct Bundle {
  std::uint32_t vertex = 0;
  std::uint32_t previous = kNowhere;  ///< kNowhere where it does not matter
  WalkKey key = 0;
  double probability = 0;
};

struct Word {
  WalkKey key = 0;
  double probability = 0;
};

/// Adds up the probabilities of items that `same` holds equal; they are neighbours.
template <class Item, class Same>
void joinNeighbours(std::vector<Item>& items, Same same) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (kept > 0 && same(items[kept - 1], items[i])) {
      items[kept - 1].probability += items[i].probability;
    } else {
      items[kept++] = items[i];
    }
  }
  items.resize(kept);
}

void joinBundles(std::vector<Bundle>& bundles) {
  const auto id = [](const Bundle& b) { return std::make_tuple(b.vertex, b.key, b.previous); };
  std::sort(bundles.begin(), bundles.end(),
            [&](const Bundle& a, const Bundle& b) { return id(a) < id(b); });
  joinNeighbours(bundles, [&](const Bundle& a, const Bundle& b) { return id(a) == id(b); });
}

void joinWords(std::vector<Word>& words) {
  std::sort(words.begin(), words.end(), [](const Word& a, const Word& b) {
    return a.key != b.key ? a.key < b.key : a.probability < b.probability;
  });
  joinNeighbours(words, [](const Word& a, const Word& b) { return a.key == b.key; });
}

class Spectrum {
 public:
  Spectrum(const SemanticGraph& graph, const LabelAlphabet& alphabet, const WalkOptions& options)
      : graph_(graph), alphabet_(alphabet), options_(options) {}

  std::vector<Word> of(std::uint32_t start) {
    std::vector<Bundle> bundles{{start, kNowhere, code(start), 1.0}};
    for (int length = 1; length + 1 < options_.walk_length; ++length) {
      bundles = step(bundles, length);
      joinBundles(bundles);
    }
    lastStep(bundles, options_.walk_length - 1);
    joinWords(words_);
    return std::move(words_);
  }

 private:
  WalkKey code(std::uint32_t v) const { return alphabet_(graph_.vertices[v].label); }

  std::size_t choicesOf(const Bundle& bundle) const {
    return graph_.neighbours[bundle.vertex].size() - (bundle.previous != kNowhere ? 1 : 0);
  }

  /// One vertex more for walks of `length` vertices; dead ends become words.
  std::vector<Bundle> step(const std::vector<Bundle>& bundles, int length) {
    std::vector<Bundle> longer;
    for (const Bundle& bundle : bundles) {
      const std::size_t choices = choicesOf(bundle);
      if (choices == 0) words_.push_back({bundle.key, bundle.probability});
      for (const std::uint32_t v : graph_.neighbours[bundle.vertex]) {
        if (v == bundle.previous) continue;
        longer.push_back({v, options_.immediate_return ? kNowhere : bundle.vertex,
                          bundle.key | code(v) << (8 * length),
                          bundle.probability / static_cast<double>(choices)});
      }
    }
    return longer;
  }

  /// The last vertex matters by its label only. All walks with one word that stand at one vertex go
  /// on together: each label is reached from all of them by as many neighbours as bear it, less the
  /// walks that came from there. Bundles are ordered by vertex, then word.
  void lastStep(const std::vector<Bundle>& bundles, int length) {
    std::array<double, 256> neighbours_with{};
    std::vector<std::uint8_t> labels;
    for (std::size_t i = 0; i < bundles.size();) {
      const std::uint32_t vertex = bundles[i].vertex;
      labels.clear();
      for (const std::uint32_t v : graph_.neighbours[vertex]) {
        const auto label = static_cast<std::uint8_t>(code(v));
        if (neighbours_with[label]++ == 0) labels.push_back(label);
      }
      while (i < bundles.size() && bundles[i].vertex == vertex) {
        std::size_t end = i;
        while (end < bundles.size() && bundles[end].vertex == vertex &&
               bundles[end].key == bundles[i].key) {
          ++end;
        }
        lastStepTogether(&bundles[i], &bundles[end - 1] + 1, length, labels, neighbours_with);
        i = end;
      }
      for (const std::uint8_t label : labels) neighbours_with[label] = 0;
    }
  }

  void lastStepTogether(const Bundle* first, const Bundle* last, int length,
                        const std::vector<std::uint8_t>& labels,
                        const std::array<double, 256>& neighbours_with) {
    double sum = 0;
    for (const Bundle* b = first; b != last; ++b) {
      sum += b->probability;
      if (b->previous != kNowhere) came_from_[code(b->previous)] += b->probability;
    }
    const std::size_t choices = choicesOf(*first);
    if (choices == 0) words_.push_back({first->key, sum});
    for (const std::uint8_t label : labels) {
      const double ways = sum * neighbours_with[label] - came_from_[label];
      came_from_[label] = 0;
      if (ways > kRounding * sum) {
        words_.push_back(
            {first->key | WalkKey{label} << (8 * length), ways / static_cast<double>(choices)});
      }
    }
  }

  const SemanticGraph& graph_;
  const LabelAlphabet& alphabet_;
  const WalkOptions& options_;
  std::array<double, 256> came_from_{};  // by label; zero between uses
  std::vector<Word> words_;
};

}  // namespace

std::vector<WalkCount> walkSpectrum(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                                    std::uint32_t vertex, const WalkOptions& options) {
  const std::vector<Word> words = Spectrum(graph, alphabet, options).of(vertex);
  std::vector<WalkCount> spectrum;
  spectrum.reserve(words.size());
  for (const Word& word : words) {
    spectrum.push_back({word.key, static_cast<float>(word.probability * options.num_walks)});
  }
  return spectrum;
}

}  // namespace xview::match
