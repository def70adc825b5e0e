// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "xview/types/graph.h"
#include "xview/types/option_field.h"

namespace xview::match {

struct WalkOptions {
  int num_walks = 200;            ///< n (paper: 200)
  int walk_length = 4;            ///< m, vertices per walk including the first (paper: 3 to 5)
  bool immediate_return = false;  ///< may a walk step back to where it just came from (paper: no)
  bool duplicates = false;  ///< may one vertex hold the same walk of vertices twice (paper: no)
};

template <class Visitor>
void visit(WalkOptions& o, Visitor&& field) {
  field("num_walks", o.num_walks, Range{1, 100000}, "random walks per vertex, n of the paper");
  field("walk_length", o.walk_length, Range{2, 8},
        "vertices per walk including its start, m of the paper");
  field("immediate_return", o.immediate_return,
        "allow a walk to step back to the vertex it just left");
  field("duplicates", o.duplicates,
        "allow one walk (sequence of vertices) several times at a vertex");
}

/// A walk as a word of class labels: labels are numbered 1, 2, … per alphabet and packed 8 bits
/// each, first label lowest, so that up to 8 vertices fit without overflow; 0 stands behind the
/// last one.
using WalkKey = std::uint64_t;

/// Dense numbering of labels in increasing order.
class LabelAlphabet {
 public:
  static constexpr std::uint8_t kUnknown = 255;

  /// The labels of both graphs; throws UsageError if there are more than 254.
  LabelAlphabet(const SemanticGraph& a, const SemanticGraph& b);
  /// The labels of a map, known before any query. Others are kUnknown: they match nothing in the
  /// map.
  explicit LabelAlphabet(const SemanticGraph& map) : LabelAlphabet(map, SemanticGraph()) {}

  std::uint8_t operator()(std::uint32_t label) const {
    return label < letters_.size() ? letters_[label] : letterOf(label);
  }
  std::size_t size() const { return labels_.size(); }

 private:
  std::uint8_t letterOf(std::uint32_t label) const;

  std::vector<std::uint32_t> labels_;      ///< sorted
  std::array<std::uint8_t, 256> letters_;  ///< of the labels that most label sets are made of
};

/// The walks of one vertex as sorted (word, multiplicity).
struct WalkCount {
  WalkKey key = 0;
  float count = 0;  ///< multiplicity
};

/// num_walks random walks from `vertex` over the graph, as words in increasing order; seeded per
/// vertex, so that neither the order of calls nor threads matter. A walk that can go nowhere ends
/// early (a shorter word). Without duplicates the walks are drawn one after the other by their
/// probability, those seen before put aside; a neighbourhood that offers no more than num_walks
/// gives each of its walks once. Where a few improbable walks are all that is left the draw gives
/// up after 20 num_walks tries, with fewer walks.
std::vector<WalkCount> sampleWalks(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                                   std::uint32_t vertex, const WalkOptions& options,
                                   std::uint64_t seed);

}  // namespace xview::match
