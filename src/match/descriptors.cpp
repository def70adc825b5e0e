// SPDX-License-Identifier: BSD-3-Clause
#include "match/descriptors.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/parallel.h"

namespace xview::match {
namespace {

std::size_t classOf(WalkKey word) { return word & 0xFF; }

}  // namespace

Descriptors describe(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                     const WalkOptions& options, std::uint64_t seed, int threads) {
  const Walks walks(graph, alphabet, options, seed);
  Descriptors words(graph.size());
  parallelFor(graph.size(), threads,
              [&](std::size_t i) { words[i] = walks.from(static_cast<std::uint32_t>(i)); });
  return words;
}

double similarity(const std::vector<WalkCount>& a, const std::vector<WalkCount>& b) {
  double common = 0, total_a = 0, total_b = 0;
  for (const WalkCount& x : a) total_a += x.count;
  for (const WalkCount& y : b) total_b += y.count;
  auto y = b.begin();
  for (const WalkCount& x : a) {
    while (y != b.end() && y->key < x.key) ++y;
    if (y != b.end() && y->key == x.key) common += std::min(x.count, y->count);
  }
  const double total = std::min(total_a, total_b);
  return total > 0 ? std::min(1.0, common / total) : 0;
}

/// All sums run over the words of a vertex in increasing order and in single precision: a sum of
/// smaller terms is then never larger, which keeps similarities at or below 1 and makes equal
/// descriptors give exactly 1.
DescriptorIndex::DescriptorIndex(const Descriptors& map) : totals_(map.size()) {
  for (std::uint32_t v = 0; v < map.size(); ++v) {
    if (!map[v].empty()) ++vertices_of_class_[classOf(map[v].front().key)];
    for (const WalkCount& x : map[v]) holders_.push_back({x.key, v, x.count});
  }
  std::sort(holders_.begin(), holders_.end(), [](const Holder& a, const Holder& b) {
    return std::tie(a.word, a.vertex) < std::tie(b.word, b.vertex);
  });
  for (auto first = holders_.begin(); first != holders_.end();) {
    const auto last =
        std::find_if(first, holders_.end(), [&](const Holder& h) { return h.word != first->word; });
    const float rarity = rarityOf(first->word, last - first);
    for (; first != last; ++first) {
      totals_[first->vertex].plain += first->count;
      totals_[first->vertex].rare += rarity * first->count;
    }
  }
}

/// A word that no map vertex holds counts as held by one.
float DescriptorIndex::rarityOf(WalkKey word, std::ptrdiff_t holders_of_word) const {
  const double in_class = vertices_of_class_[classOf(word)];
  return static_cast<float>(
      std::log1p(in_class / std::max(1.0, static_cast<double>(holders_of_word))));
}

std::vector<Correspondence> DescriptorIndex::best(const std::vector<WalkCount>& words,
                                                  std::uint32_t query,
                                                  const MatchOptions& options) const {
  std::vector<float> common(totals_.size(), 0.f);
  float total = 0;
  auto last = holders_.begin();
  for (const WalkCount& x : words) {
    const auto first = std::lower_bound(
        last, holders_.end(), x.key, [](const Holder& h, WalkKey word) { return h.word < word; });
    last = std::find_if(first, holders_.end(), [&](const Holder& h) { return h.word != x.key; });
    const float weight = options.rare_words ? rarityOf(x.key, last - first) : 1.f;
    total += weight * x.count;
    for (auto h = first; h != last; ++h) common[h->vertex] += weight * std::min(x.count, h->count);
  }
  std::vector<Correspondence> matches;
  for (std::uint32_t v = 0; v < common.size(); ++v) {
    if (common[v] <= 0) continue;
    const float map_total = options.rare_words ? totals_[v].rare : totals_[v].plain;
    matches.push_back({query, v, common[v] / std::min(total, map_total)});
  }
  const auto k = std::min(matches.size(), static_cast<std::size_t>(options.candidates));
  std::partial_sort(matches.begin(), matches.begin() + static_cast<std::ptrdiff_t>(k),
                    matches.end(), [](const Correspondence& a, const Correspondence& b) {
                      return a.similarity != b.similarity ? a.similarity > b.similarity
                                                          : a.map < b.map;
                    });
  matches.resize(k);
  return matches;
}

std::vector<Correspondence> DescriptorIndex::bestMatches(const Descriptors& query,
                                                         const MatchOptions& options,
                                                         int threads) const {
  std::vector<std::vector<Correspondence>> of_vertex(query.size());
  parallelFor(query.size(), threads, [&](std::size_t i) {
    of_vertex[i] = best(query[i], static_cast<std::uint32_t>(i), options);
  });
  std::vector<Correspondence> matches;
  for (const auto& list : of_vertex) matches.insert(matches.end(), list.begin(), list.end());
  return matches;
}

}  // namespace xview::match
