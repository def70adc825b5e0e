// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walk_spectrum.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace xview {
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

}  // namespace xview
