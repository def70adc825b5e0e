// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "xview/base/graph.h"

namespace xview {

/// The vertices of a map that are packed as in its file, and unpacked where somebody asks for them.
/// Their numbers are those of a SemanticGraph. Thread-safe; throws Error if the file was damaged.
class StoredVertices {
 public:
  using Visit = std::function<void(std::uint32_t number, const Vertex& vertex)>;

  virtual ~StoredVertices() = default;
  virtual std::size_t size() const = 0;
  /// Throws std::out_of_range for a number that none has.
  virtual Vertex at(std::uint32_t number) const = 0;
  /// Around all of them [m].
  virtual Eigen::AlignedBox3d bounds() const = 0;
  /// Calls visit for all of them, in the order of their numbers.
  virtual void forAll(const Visit& visit) const = 0;
  /// The same for all that lie in a box, from above [m].
  virtual void forAllIn(const Eigen::AlignedBox2d& box, const Visit& visit) const = 0;
  /// All of them, without edges.
  virtual SemanticGraph whole() const = 0;
};

/// The vertices of a graph, wherever they are; it must outlive this.
class AllVertices {
 public:
  AllVertices(const SemanticGraph& graph) : graph_(&graph) {}
  AllVertices(const StoredVertices& stored) : stored_(&stored) {}

  std::size_t size() const { return stored_ ? stored_->size() : graph_->size(); }
  Vertex at(std::uint32_t number) const {
    return stored_ ? stored_->at(number) : graph_->vertices.at(number);
  }
  Eigen::AlignedBox3d bounds() const {
    Eigen::AlignedBox3d box;
    if (graph_) forEach([&](std::uint32_t, const Vertex& v) { box.extend(v.position); });
    return graph_ ? box : stored_->bounds();
  }
  /// Calls visit(number, vertex) for all of them, in the order of their numbers. Throws Error.
  template <class Visit>
  void forEach(const Visit& visit) const {
    if (stored_) return stored_->forAll(visit);
    std::uint32_t number = 0;
    for (const Vertex& v : graph_->vertices) visit(number++, v);
  }

 private:
  const SemanticGraph* graph_ = nullptr;
  const StoredVertices* stored_ = nullptr;
};

}  // namespace xview
