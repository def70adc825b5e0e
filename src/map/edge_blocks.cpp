// SPDX-License-Identifier: BSD-3-Clause
// A block, before compression: per vertex the number of neighbours with a larger index, and each as
// difference to the one before.
#include "edge_blocks.h"

#include <algorithm>

#include "damage.h"

namespace xview {
namespace {

constexpr std::size_t kBlock = 4096;

EdgeBlock blockFrom(std::size_t first, const SemanticGraph& graph) {
  EdgeBlock block;
  block.first_vertex = static_cast<std::int64_t>(first);
  ByteWriter out;
  for (std::size_t i = first; i < std::min(first + kBlock, graph.size()); ++i) {
    const auto& list = graph.neighbours[i];
    const auto larger = std::upper_bound(list.begin(), list.end(), static_cast<std::uint32_t>(i));
    out.unsignedInteger(static_cast<std::uint64_t>(list.end() - larger));
    std::uint32_t previous = static_cast<std::uint32_t>(i);
    for (auto j = larger; j != list.end(); ++j) {
      out.unsignedInteger(*j - previous);
      previous = *j;
      ++block.edges;
    }
  }
  block.data = compressed(out.bytes());
  return block;
}

/// Compressed rows: the larger neighbours of vertex i are others[start[i]] … others[start[i + 1]].
struct LargerNeighbours {
  std::vector<std::size_t> start;
  std::vector<std::uint32_t> others;
};

void readVertex(std::size_t vertex, std::size_t vertices, ByteReader& in,
                std::vector<std::uint32_t>& others) {
  std::uint64_t previous = vertex;
  for (std::size_t left = in.itemCount(); left > 0; --left) {
    const std::uint64_t step = in.unsignedInteger();
    if (step == 0 || step >= vertices || previous + step >= vertices)
      throw Damage("edge to a vertex that does not exist");
    previous += step;
    others.push_back(static_cast<std::uint32_t>(previous));
  }
}

void readBlock(const EdgeBlock& block, std::size_t vertices, LargerNeighbours& larger) {
  const Bytes raw = decompressed(block.data);
  ByteReader in(raw);
  const std::size_t before = larger.others.size(),
                    first = static_cast<std::size_t>(block.first_vertex);
  for (std::size_t i = first; i < std::min(first + kBlock, vertices); ++i) {
    larger.start[i] = larger.others.size();
    readVertex(i, vertices, in, larger.others);
    larger.start[i + 1] = larger.others.size();
  }
  if (in.remaining() > 0 || larger.others.size() - before != block.edges) {
    throw Damage("block with another number of edges than announced");
  }
}

LargerNeighbours readBlocks(const std::vector<EdgeBlock>& blocks, std::size_t vertices) {
  LargerNeighbours larger;
  larger.start.assign(vertices + 1, 0);
  std::size_t next = 0;  // first vertex without a list yet
  for (const EdgeBlock& block : blocks) {
    const auto first = static_cast<std::size_t>(block.first_vertex);
    if (block.first_vertex < 0 || first % kBlock != 0 || first < next || first >= vertices) {
      throw Damage("block of edges out of place");
    }
    std::fill(larger.start.begin() + static_cast<std::ptrdiff_t>(next),
              larger.start.begin() + static_cast<std::ptrdiff_t>(first), larger.others.size());
    readBlock(block, vertices, larger);
    next = std::min(first + kBlock, vertices);
  }
  std::fill(larger.start.begin() + static_cast<std::ptrdiff_t>(next), larger.start.end(),
            larger.others.size());
  return larger;
}

}  // namespace

std::vector<EdgeBlock> toBlocks(const SemanticGraph& graph) {
  std::vector<EdgeBlock> blocks;
  for (std::size_t first = 0; first < graph.size(); first += kBlock) {
    EdgeBlock block = blockFrom(first, graph);
    if (block.edges > 0) blocks.push_back(std::move(block));
  }
  return blocks;
}

void setEdges(const std::vector<EdgeBlock>& blocks, SemanticGraph& graph) {
  const LargerNeighbours larger = readBlocks(blocks, graph.size());
  std::vector<std::uint32_t> degree(graph.size(), 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    degree[i] += static_cast<std::uint32_t>(larger.start[i + 1] - larger.start[i]);
  }
  for (const std::uint32_t j : larger.others) ++degree[j];

  graph.neighbours.assign(graph.size(), {});
  for (std::size_t i = 0; i < graph.size(); ++i) graph.neighbours[i].reserve(degree[i]);
  // In ascending order of i every list receives first its smaller, then its larger neighbours:
  // sorted without sorting.
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (std::size_t k = larger.start[i]; k < larger.start[i + 1]; ++k) {
      graph.neighbours[i].push_back(larger.others[k]);
      graph.neighbours[larger.others[k]].push_back(static_cast<std::uint32_t>(i));
    }
  }
}

}  // namespace xview
