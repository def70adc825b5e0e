// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/walk_spectrum.h"

#include <algorithm>
#include <tuple>

namespace xview {
namespace {

/// All walks that spell `key` so far and stand at `vertex` having come from `previous`.
struct Bundle {
  WalkKey key = 0;
  std::uint32_t vertex = 0;
  std::uint32_t previous = 0;
  double probability = 0;
};

struct Word {
  WalkKey key = 0;
  double probability = 0;
};

/// Joins neighbouring items that `same` holds equal, after sorting by `order`.
template <class Item, class Order, class Same>
void joinEqual(std::vector<Item>& items, Order order, Same same) {
  std::sort(items.begin(), items.end(), order);
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
  const auto id = [](const Bundle& b) { return std::make_tuple(b.key, b.vertex, b.previous); };
  joinEqual(
      bundles, [&](const Bundle& a, const Bundle& b) { return id(a) < id(b); },
      [&](const Bundle& a, const Bundle& b) { return id(a) == id(b); });
}

void joinWords(std::vector<Word>& words) {
  joinEqual(
      words,
      [](const Word& a, const Word& b) {
        return a.key != b.key ? a.key < b.key : a.probability < b.probability;
      },
      [](const Word& a, const Word& b) { return a.key == b.key; });
}

}  // namespace

std::vector<WalkCount> walkSpectrum(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                                    std::uint32_t vertex, const WalkOptions& options) {
  const auto code = [&](std::uint32_t v) { return WalkKey{alphabet(graph.vertices[v].label)}; };
  constexpr std::uint32_t kNowhere = 0xFFFFFFFFu;
  std::vector<Word> words;
  std::vector<Bundle> bundles{{code(vertex), vertex, kNowhere, 1.0}}, longer;
  for (int length = 1; length < options.walk_length; ++length) {
    longer.clear();
    for (const Bundle& bundle : bundles) {
      const auto& next = graph.neighbours[bundle.vertex];
      const bool returns = !options.immediate_return && bundle.previous != kNowhere;
      const std::size_t choices = next.size() - (returns ? 1 : 0);
      if (choices == 0) {
        words.push_back({bundle.key, bundle.probability});
        continue;
      }
      for (const std::uint32_t v : next) {
        if (returns && v == bundle.previous) continue;
        const std::uint32_t previous = options.immediate_return ? kNowhere : bundle.vertex;
        longer.push_back({bundle.key | code(v) << (8 * length), v, previous,
                          bundle.probability / static_cast<double>(choices)});
      }
    }
    // Walks of one origin can agree in word, vertex and predecessor from their fourth vertex on
    // (third, where the predecessor does not matter).
    if (length >= (options.immediate_return ? 2 : 3)) joinBundles(longer);
    std::swap(bundles, longer);
  }
  for (const Bundle& bundle : bundles) words.push_back({bundle.key, bundle.probability});
  joinWords(words);

  std::vector<WalkCount> spectrum;
  spectrum.reserve(words.size());
  for (const Word& word : words) {
    spectrum.push_back({word.key, static_cast<float>(word.probability * options.num_walks)});
  }
  return spectrum;
}

}  // namespace xview
