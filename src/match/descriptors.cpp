// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/descriptors.h"

#include <algorithm>
#include <cmath>

#include "xview/match/walk_spectrum.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"

namespace xview {
namespace {

constexpr std::size_t kBlock = 64;  // vertices per task

std::size_t classOf(const WalkCount* first) { return first->key & 0xFF; }

const WalkCount* begin(const Descriptors& d, std::size_t i) {
  return d.counts.data() + d.offsets[i];
}
const WalkCount* end(const Descriptors& d, std::size_t i) {
  return d.counts.data() + d.offsets[i + 1];
}

}  // namespace

Descriptors describe(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                     const WalkOptions& walks, const std::string& descriptor, std::uint64_t seed,
                     int threads) {
  if (descriptor != "walks" && descriptor != "spectrum") {
    throw UsageError("match.descriptor = " + descriptor + ", must be walks or spectrum");
  }
  const bool spectrum = descriptor == "spectrum";
  Descriptors result;
  result.offsets.assign(graph.size() + 1, 0);
  std::vector<std::vector<WalkCount>> blocks((graph.size() + kBlock - 1) / kBlock);
  parallelFor(blocks.size(), threads, [&](std::size_t b) {
    for (std::size_t i = b * kBlock; i < std::min(graph.size(), (b + 1) * kBlock); ++i) {
      const auto v = static_cast<std::uint32_t>(i);
      const auto counts = spectrum ? walkSpectrum(graph, alphabet, v, walks)
                                   : sampleWalks(graph, alphabet, v, walks, seed);
      result.offsets[i + 1] = static_cast<std::uint32_t>(counts.size());
      blocks[b].insert(blocks[b].end(), counts.begin(), counts.end());
    }
  });
  for (std::size_t i = 1; i < result.offsets.size(); ++i)
    result.offsets[i] += result.offsets[i - 1];
  result.counts.reserve(result.offsets.back());
  for (const auto& block : blocks) {
    result.counts.insert(result.counts.end(), block.begin(), block.end());
  }
  return result;
}

double similarity(const Descriptors& a, std::uint32_t i, const Descriptors& b, std::uint32_t j) {
  double common = 0, total_a = 0, total_b = 0;
  for (const WalkCount* x = begin(a, i); x != end(a, i); ++x) total_a += x->count;
  for (const WalkCount* y = begin(b, j); y != end(b, j); ++y) total_b += y->count;
  const WalkCount* y = begin(b, j);
  for (const WalkCount* x = begin(a, i); x != end(a, i); ++x) {
    while (y != end(b, j) && y->key < x->key) ++y;
    if (y != end(b, j) && y->key == x->key) common += std::min(x->count, y->count);
  }
  const double total = std::min(total_a, total_b);
  return total > 0 ? std::min(1.0, common / total) : 0;
}

/// Map vertices are numbered by class, in their own order within a class, so that a query vertex
/// writes to one dense range of scores. All sums run over words in increasing order and in single
/// precision: a sum of smaller terms is then never larger, which keeps similarities at or below 1
/// and makes equal descriptors give exactly 1.
struct DescriptorIndex::Postings {
  struct Word {
    WalkKey key = 0;
    std::uint32_t first = 0;  // into holders and counts
    float rarity = 1;
  };
  struct Totals {
    float plain = 0, rare = 0;  // number of walks; the same weighted by rarity
  };

  std::vector<Word> words;  // sorted by key; one more at the end closes the last list
  std::vector<std::uint32_t> holders;
  std::vector<float> counts;
  std::vector<std::uint32_t> vertex_of_slot;
  std::vector<Totals> totals;              // per slot
  std::vector<std::uint32_t> class_begin;  // 257 entries into slots

  explicit Postings(const Descriptors& map);
  const Word* find(WalkKey key) const;
  std::vector<Correspondence> best(const Descriptors& query, std::uint32_t i,
                                   const MatchOptions& options) const;

 private:
  void numberByClass(const Descriptors& map);
  void fillWords(const Descriptors& map);
  float rarityOf(WalkKey key, std::size_t holders_of_word) const;
  float rarityOf(const Word& word, const Word& next) const {
    return rarityOf(word.key, next.first - word.first);
  }
};

DescriptorIndex::Postings::Postings(const Descriptors& map) {
  numberByClass(map);
  fillWords(map);
  totals.assign(vertex_of_slot.size(), {});
  for (std::size_t w = 0; w + 1 < words.size(); ++w) {
    words[w].rarity = rarityOf(words[w], words[w + 1]);
    for (std::uint32_t p = words[w].first; p < words[w + 1].first; ++p) {
      totals[holders[p]].plain += counts[p];
      totals[holders[p]].rare += words[w].rarity * counts[p];
    }
  }
}

void DescriptorIndex::Postings::numberByClass(const Descriptors& map) {
  class_begin.assign(257, 0);
  for (std::size_t v = 0; v < map.size(); ++v) {
    if (begin(map, v) != end(map, v)) ++class_begin[classOf(begin(map, v)) + 1];
  }
  for (std::size_t c = 1; c < class_begin.size(); ++c) class_begin[c] += class_begin[c - 1];
  vertex_of_slot.resize(class_begin.back());
  auto next = class_begin;
  for (std::size_t v = 0; v < map.size(); ++v) {
    if (begin(map, v) == end(map, v)) continue;
    vertex_of_slot[next[classOf(begin(map, v))]++] = static_cast<std::uint32_t>(v);
  }
}

void DescriptorIndex::Postings::fillWords(const Descriptors& map) {
  std::vector<WalkKey> keys;
  keys.reserve(map.counts.size());
  for (const WalkCount& count : map.counts) keys.push_back(count.key);
  std::sort(keys.begin(), keys.end());
  for (std::uint32_t k = 0; k < keys.size(); ++k) {
    if (k == 0 || keys[k] != keys[k - 1]) words.push_back({keys[k], k, 1});
  }
  const auto total = static_cast<std::uint32_t>(keys.size());
  words.push_back({~WalkKey{0}, total, 0});

  std::vector<std::uint32_t> next(words.size());
  for (std::size_t w = 0; w < words.size(); ++w) next[w] = words[w].first;
  holders.resize(total);
  counts.resize(total);
  for (std::uint32_t slot = 0; slot < vertex_of_slot.size(); ++slot) {
    const std::uint32_t v = vertex_of_slot[slot];
    for (const WalkCount* x = begin(map, v); x != end(map, v); ++x) {
      const std::uint32_t p = next[static_cast<std::size_t>(find(x->key) - words.data())]++;
      holders[p] = slot;
      counts[p] = x->count;
    }
  }
}

const DescriptorIndex::Postings::Word* DescriptorIndex::Postings::find(WalkKey key) const {
  const auto last = words.end() - 1;
  const auto place = std::lower_bound(words.begin(), last, key,
                                      [](const Word& w, WalkKey k) { return w.key < k; });
  return place != last && place->key == key ? &*place : nullptr;
}

/// A word that no map vertex holds counts as held by one.
float DescriptorIndex::Postings::rarityOf(WalkKey key, std::size_t holders_of_word) const {
  const std::size_t c = key & 0xFF;
  const double in_class = class_begin[c + 1] - class_begin[c];
  return static_cast<float>(std::log1p(in_class / std::max<double>(1, holders_of_word)));
}

std::vector<Correspondence> DescriptorIndex::Postings::best(const Descriptors& query,
                                                            std::uint32_t i,
                                                            const MatchOptions& options) const {
  std::vector<Correspondence> matches;
  if (begin(query, i) == end(query, i)) return matches;
  const std::size_t c = classOf(begin(query, i));
  const std::uint32_t first = class_begin[c], last = class_begin[c + 1];
  std::vector<float> common(last - first, 0.f);
  float total = 0;
  for (const WalkCount* x = begin(query, i); x != end(query, i); ++x) {
    const Word* word = find(x->key);
    const float rarity = !options.rare_words ? 1.f : word ? word->rarity : rarityOf(x->key, 1);
    total += rarity * x->count;
    if (!word) continue;
    for (std::uint32_t p = word[0].first; p < word[1].first; ++p) {
      common[holders[p] - first] += rarity * std::min(x->count, counts[p]);
    }
  }
  for (std::uint32_t s = first; s < last; ++s) {
    const float map_total = options.rare_words ? totals[s].rare : totals[s].plain;
    const float share = common[s - first] / std::min(total, map_total);
    if (share > static_cast<float>(options.min_similarity)) {
      matches.push_back({i, vertex_of_slot[s], share});
    }
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

DescriptorIndex::DescriptorIndex(const Descriptors& map)
    : postings_(std::make_unique<Postings>(map)) {}
DescriptorIndex::~DescriptorIndex() = default;
DescriptorIndex::DescriptorIndex(DescriptorIndex&&) noexcept = default;
DescriptorIndex& DescriptorIndex::operator=(DescriptorIndex&&) noexcept = default;

std::vector<Correspondence> DescriptorIndex::bestMatches(const Descriptors& query,
                                                         const MatchOptions& options,
                                                         int threads) const {
  std::vector<std::vector<Correspondence>> of_vertex(query.size());
  parallelFor(query.size(), threads, [&](std::size_t i) {
    of_vertex[i] = postings_->best(query, static_cast<std::uint32_t>(i), options);
  });
  std::vector<Correspondence> matches;
  for (const auto& list : of_vertex) matches.insert(matches.end(), list.begin(), list.end());
  return matches;
}

std::size_t DescriptorIndex::bytes() const {
  return postings_->words.size() * sizeof(Postings::Word) +
         postings_->holders.size() * (sizeof(std::uint32_t) + sizeof(float)) +
         postings_->vertex_of_slot.size() * (sizeof(std::uint32_t) + sizeof(Postings::Totals));
}

std::vector<Correspondence> bestMatches(const Descriptors& query, const Descriptors& map,
                                        const MatchOptions& options, int threads) {
  return DescriptorIndex(map).bestMatches(query, options, threads);
}

}  // namespace xview
