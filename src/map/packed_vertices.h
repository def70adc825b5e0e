// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/stored_vertices.h"
#include "packed_cloud.h"

namespace xview::map {

/// Vertices as their file has them.
class StoredBlocks final : public StoredVertices {
 public:
  /// All blocks of a file of that name, in order. Throws Damage if some are out of place.
  StoredBlocks(std::vector<VertexBlock> blocks, std::string file);

  std::size_t size() const override { return size_; }
  Vertex at(std::uint32_t number) const override;
  Eigen::AlignedBox3d bounds() const override;
  void forAll(const Visit& visit) const override;
  void forAllIn(const Eigen::AlignedBox2d& box, const Visit& visit) const override;
  SemanticGraph whole() const override;
  const std::vector<VertexBlock>& blocks() const { return blocks_; }

 private:
  std::shared_ptr<const std::vector<Vertex>> unpacked(std::size_t block) const;
  const std::vector<Eigen::AlignedBox3d>& boxes() const;

  std::vector<VertexBlock> blocks_;
  std::string file_;
  std::size_t size_ = 0;
  mutable Recent<std::size_t, std::vector<Vertex>> recent_;
  mutable std::once_flag boxes_made_;
  mutable std::vector<Eigen::AlignedBox3d> boxes_;  ///< around the vertices of each block
};

/// The blocks of a file whose vertices were unpacked. Those that hold what they held then need not
/// be packed anew.
class PackedVertices {
 public:
  PackedVertices(std::shared_ptr<const StoredBlocks> blocks, const std::vector<Vertex>& vertices);
  /// The block that holds these vertices from there on, or null.
  const VertexBlock* find(const std::vector<Vertex>& vertices, std::size_t first,
                          std::size_t count) const;

 private:
  std::shared_ptr<const StoredBlocks> blocks_;
  std::vector<std::uint64_t> checksums_;
};

/// The packed vertices of a map; null if they are unpacked.
const StoredBlocks* storedBlocksOf(const SemanticMap& map);

}  // namespace xview::map
