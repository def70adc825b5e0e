// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "xview/base/graph.h"
#include "xview/options.h"

namespace xview {
class Random;
}

namespace xview::match {

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

/// A word of the walks of one vertex, and how many of them, or which share, it is.
struct WalkCount {
  WalkKey key = 0;
  float count = 0;
};

/// The words of the walks from single vertices of a graph, in increasing order. Drawn walks are
/// seeded per vertex, so that neither the order of calls nor threads matter; one that is drawn
/// twice counts twice. A walk that can go nowhere ends early (a shorter word).
class Walks {
 public:
  /// The graph must outlive the walks.
  Walks(const SemanticGraph& graph, const LabelAlphabet& alphabet, const WalkOptions& options,
        std::uint64_t seed);
  std::vector<WalkCount> from(std::uint32_t vertex) const;

 private:
  /// Neighbours with one letter.
  struct LetterCount {
    std::uint8_t letter = 0;
    std::uint32_t count = 0;
  };
  struct Step;

  WalkKey draw(std::uint32_t start, Random& random) const;
  void spell(std::uint32_t start, std::vector<std::pair<WalkKey, double>>& words) const;

  const SemanticGraph& graph_;
  const WalkOptions options_;
  std::uint64_t seed_;
  std::vector<std::uint8_t> letters_;             ///< of the vertices
  std::vector<std::vector<LetterCount>> around_;  ///< of the neighbours of each vertex
};

}  // namespace xview::match
