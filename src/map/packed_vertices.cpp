// SPDX-License-Identifier: BSD-3-Clause
#include "packed_vertices.h"
#include "map/contents.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace xview::map {
namespace {

constexpr std::size_t kMostRecentBlocks = 64;  ///< 6 MB

}  // namespace

StoredBlocks::StoredBlocks(std::vector<VertexBlock> blocks, std::string file)
    : blocks_(std::move(blocks)), file_(std::move(file)), recent_(kMostRecentBlocks) {
  for (const VertexBlock& block : blocks_) {
    if (block.first_vertex != static_cast<std::int64_t>(size_) || block.vertices == 0)
      throw Damage("block of vertices out of place");
    size_ += block.vertices;
  }
}

std::shared_ptr<const std::vector<Vertex>> StoredBlocks::unpacked(std::size_t block) const {
  return recent_.findOrMake(block, [&] {
    auto vertices = std::make_shared<std::vector<Vertex>>();
    rethrowDamage(file_, [&] { unpack(blocks_[block], *vertices); });
    return vertices;
  });
}

const std::vector<Eigen::AlignedBox3d>& StoredBlocks::boxes() const {
  std::call_once(boxes_made_, [&] {
    rethrowDamage(file_, [&] {
      std::vector<Eigen::AlignedBox3d> boxes;
      for (const VertexBlock& block : blocks_) boxes.push_back(boxOf(block));
      boxes_ = std::move(boxes);
    });
  });
  return boxes_;
}

Vertex StoredBlocks::at(std::uint32_t number) const {
  if (number >= size_) throw std::out_of_range("no vertex of that number");
  const auto after = std::upper_bound(
      blocks_.begin(), blocks_.end(), static_cast<std::int64_t>(number),
      [](std::int64_t value, const VertexBlock& block) { return value < block.first_vertex; });
  const VertexBlock& block = *(after - 1);
  return unpacked(static_cast<std::size_t>(after - 1 - blocks_.begin()))
      ->at(static_cast<std::size_t>(number - block.first_vertex));
}

Eigen::AlignedBox3d StoredBlocks::bounds() const {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::AlignedBox3d& box : boxes()) bounds.extend(box);
  return bounds;
}

void StoredBlocks::forAll(const Visit& visit) const {
  std::vector<Vertex> vertices;
  std::uint32_t number = 0;
  for (const VertexBlock& block : blocks_) {
    vertices.clear();
    rethrowDamage(file_, [&] { unpack(block, vertices); });
    for (const Vertex& v : vertices) visit(number++, v);
  }
}

void StoredBlocks::forAllIn(const Eigen::AlignedBox2d& box, const Visit& visit) const {
  const std::vector<Eigen::AlignedBox3d>& around = boxes();
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Eigen::AlignedBox2d from_above(around[i].min().head<2>(), around[i].max().head<2>());
    if (!from_above.intersects(box)) continue;
    auto number = static_cast<std::uint32_t>(blocks_[i].first_vertex);
    for (const Vertex& v : *unpacked(i)) {
      if (box.contains(v.position.head<2>())) visit(number, v);
      ++number;
    }
  }
}

SemanticGraph StoredBlocks::whole() const {
  SemanticGraph graph;
  rethrowDamage(file_, [&] {
    graph.vertices.reserve(size_ + size_ / 16);  // room for those of a drive that is added
    for (const VertexBlock& block : blocks_) appendVertices(block, graph.vertices);
  });
  return graph;
}

PackedVertices::PackedVertices(std::shared_ptr<const StoredBlocks> blocks,
                               const std::vector<Vertex>& vertices)
    : blocks_(std::move(blocks)) {
  for (const VertexBlock& block : blocks_->blocks())
    checksums_.push_back(
        checksumOf(vertices, static_cast<std::size_t>(block.first_vertex), block.vertices));
}

const VertexBlock* PackedVertices::find(const std::vector<Vertex>& vertices, std::size_t first,
                                        std::size_t count) const {
  const std::size_t number = first / kVertexBlock;
  if (first % kVertexBlock != 0 || number >= checksums_.size()) return nullptr;
  const VertexBlock& block = blocks_->blocks()[number];
  const bool is_same = block.first_vertex == static_cast<std::int64_t>(first) &&
                       block.vertices == count &&
                       checksums_[number] == checksumOf(vertices, first, count);
  return is_same ? &block : nullptr;
}

const StoredBlocks* storedBlocksOf(const SemanticMap& map) {
  return dynamic_cast<const StoredBlocks*>(map.stored_vertices.get());
}

void unpackVertices(SemanticMap& map) {
  if (!map.stored_vertices) return;
  map.graph.vertices = map.stored_vertices->whole().vertices;
  if (auto blocks = std::dynamic_pointer_cast<const StoredBlocks>(map.stored_vertices))
    map.packed_vertices =
        std::make_shared<const PackedVertices>(std::move(blocks), map.graph.vertices);
  map.stored_vertices.reset();
}

}  // namespace xview::map
