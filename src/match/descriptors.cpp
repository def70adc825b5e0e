// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/descriptors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "xview/types/cells.h"
#include "xview/types/parallel.h"

namespace xview::match {
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
                     const WalkOptions& walks, std::uint64_t seed, int threads) {
  Descriptors result;
  result.offsets.assign(graph.size() + 1, 0);
  std::vector<std::vector<WalkCount>> blocks((graph.size() + kBlock - 1) / kBlock);
  parallelFor(blocks.size(), threads, [&](std::size_t b) {
    for (std::size_t i = b * kBlock; i < std::min(graph.size(), (b + 1) * kBlock); ++i) {
      const auto v = static_cast<std::uint32_t>(i);
      const auto counts = sampleWalks(graph, alphabet, v, walks, seed);
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

namespace {

double sharedWords(const WalkCount* a, const WalkCount* end_a, const WalkCount* b,
                   const WalkCount* end_b) {
  double common = 0, total_a = 0, total_b = 0;
  for (const WalkCount* x = a; x != end_a; ++x) total_a += x->count;
  for (const WalkCount* y = b; y != end_b; ++y) total_b += y->count;
  for (; a != end_a; ++a) {
    while (b != end_b && b->key < a->key) ++b;
    if (b != end_b && b->key == a->key) common += std::min(a->count, b->count);
  }
  const double total = std::min(total_a, total_b);
  return total > 0 ? std::min(1.0, common / total) : 0;
}

}  // namespace

double similarity(const Descriptors& a, std::uint32_t i, const Descriptors& b, std::uint32_t j) {
  return sharedWords(begin(a, i), end(a, i), begin(b, j), end(b, j));
}

double similarity(const std::vector<WalkCount>& a, const std::vector<WalkCount>& b) {
  return sharedWords(a.data(), a.data() + a.size(), b.data(), b.data() + b.size());
}

namespace {

/// A word in a table that numbers them in the order of their first appearance.
struct Word {
  struct Key {
    WalkKey bits;
    bool operator==(const Key& o) const { return bits == o.bits; }
    std::uint64_t hash() const {
      const std::uint64_t h = bits * 0x9E3779B97F4A7C15ull;
      return h ^ (h >> 32);
    }
  } key;
};

}  // namespace

/// Map vertices are numbered by class ("slots"), in their own order within a class, so that a query
/// vertex writes to one dense range of scores. All sums run over the words of a vertex in
/// increasing order and in single precision: a sum of smaller terms is then never larger, which
/// keeps similarities at or below 1 and makes equal descriptors give exactly 1.
struct DescriptorIndex::Postings {
  struct Totals {
    float plain = 0, rare = 0;  // number of walks; the same weighted by rarity
  };
  struct Holder {
    std::uint32_t slot = 0;
    float count = 0;
  };

  CellTable<Word> words;
  std::vector<std::uint32_t> first;  // words + 1 entries into holders
  std::vector<float> rarity;         // per word
  std::vector<Holder> holders;       // of each word, by slot
  std::vector<std::uint32_t> vertex_of_slot;
  std::vector<Totals> totals;              // per slot
  std::vector<std::uint32_t> class_begin;  // 257 entries into slots

  explicit Postings(const Descriptors& map);
  std::vector<Correspondence> best(const Descriptors& query, std::uint32_t i,
                                   const MatchOptions& options) const;

 private:
  void numberByClass(const Descriptors& map);
  void fillWords(const Descriptors& map);
  float rarityOf(WalkKey key, std::size_t holders_of_word) const;
};

DescriptorIndex::Postings::Postings(const Descriptors& map) {
  numberByClass(map);
  fillWords(map);
  rarity.resize(words.size());
  for (std::size_t w = 0; w < rarity.size(); ++w) {
    rarity[w] = rarityOf(words[w].key.bits, first[w + 1] - first[w]);
  }
  totals.resize(vertex_of_slot.size());
  for (std::size_t slot = 0; slot < totals.size(); ++slot) {
    const std::uint32_t v = vertex_of_slot[slot];
    for (const WalkCount* x = begin(map, v); x != end(map, v); ++x) {
      totals[slot].plain += x->count;
      totals[slot].rare += rarity[static_cast<std::size_t>(words.find({x->key}))] * x->count;
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
  std::vector<std::uint32_t> word_of_entry;
  word_of_entry.reserve(map.counts.size());
  for (const WalkCount& x : map.counts) {
    const Word word{{x.key}};
    word_of_entry.push_back(
        static_cast<std::uint32_t>(words.numberOf(word.key, [&] { return word; })));
    if (word_of_entry.back() == first.size()) first.push_back(0);
    ++first[word_of_entry.back()];
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& f : first) sum += std::exchange(f, sum);
  first.push_back(sum);

  holders.resize(sum);
  auto next = first;
  for (std::uint32_t slot = 0; slot < vertex_of_slot.size(); ++slot) {
    const std::uint32_t v = vertex_of_slot[slot];
    for (std::uint32_t e = map.offsets[v]; e < map.offsets[v + 1]; ++e) {
      holders[next[word_of_entry[e]]++] = {slot, map.counts[e].count};
    }
  }
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
  const std::uint32_t slots_begin = class_begin[c], slots_end = class_begin[c + 1];
  std::vector<float> common(slots_end - slots_begin, 0.f);
  float total = 0;
  for (const WalkCount* x = begin(query, i); x != end(query, i); ++x) {
    const std::int32_t w = words.find({x->key});
    const bool known = w >= 0;
    const float weight = !options.rare_words ? 1.f : known ? rarity[w] : rarityOf(x->key, 1);
    total += weight * x->count;
    if (!known) continue;
    for (std::uint32_t p = first[w]; p < first[w + 1]; ++p) {
      common[holders[p].slot - slots_begin] += weight * std::min(x->count, holders[p].count);
    }
  }
  for (std::uint32_t s = slots_begin; s < slots_end; ++s) {
    const float map_total = options.rare_words ? totals[s].rare : totals[s].plain;
    const float share = common[s - slots_begin] / std::min(total, map_total);
    if (share > 0) matches.push_back({i, vertex_of_slot[s], share});
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

}  // namespace xview::match
