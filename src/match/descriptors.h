// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "match/walks.h"
#include "xview/base/graph.h"
#include "xview/options.h"

namespace xview::match {

/// Walk descriptors of all vertices of a graph: their words, rising, with counts.
using Descriptors = std::vector<std::vector<WalkCount>>;

/// The walks of all vertices.
Descriptors describe(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                     const WalkOptions& options, std::uint64_t seed, int threads);

/// Share of identical walks of two vertices in [0, 1] (paper section III-D): sum of
/// min(count_a, count_b) over common words divided by the smaller number of walks. 1 for a vertex
/// with itself.
double similarity(const std::vector<WalkCount>& a, const std::vector<WalkCount>& b);

/// The words of a map with the vertices that hold them, so that a query vertex meets only map
/// vertices that share a word with it, hence its class. Both sides must use one alphabet.
class DescriptorIndex {
 public:
  explicit DescriptorIndex(const Descriptors& map);

  /// The k best map vertices of each query vertex. Ordered by query vertex, then by falling
  /// similarity; ties by map vertex. Never similarity 0. With rare_words each word weighs
  /// log(1 + vertices of its class in the map / vertices that hold the word), on both sides of the
  /// quotient that `similarity` forms.
  std::vector<Correspondence> bestMatches(const Descriptors& query, const MatchOptions& options,
                                          int threads) const;

 private:
  struct Holder {
    WalkKey word;
    std::uint32_t vertex;
    float count;
  };
  struct Totals {
    float plain = 0, rare = 0;  ///< number of walks; the same weighted by rarity
  };
  std::vector<Correspondence> best(const std::vector<WalkCount>& words, std::uint32_t query,
                                   const MatchOptions& options) const;
  float rarityOf(WalkKey word, std::ptrdiff_t holders_of_word) const;

  std::vector<Holder> holders_;  ///< by word, then by vertex
  std::vector<Totals> totals_;   ///< per vertex
  std::array<std::uint32_t, 256> vertices_of_class_{};
};

}  // namespace xview::match
