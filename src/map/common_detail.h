// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <tuple>

#include "xview/map/semantic_map.h"

namespace xview::map {

/// Detail of classes that a query and a map with different label sets have in common. Classes of
/// one of them alone are left out of both: they would count as missing everywhere, and favour
/// places of the map with few of them.
struct CommonDetail {
  bool shapes = false;      ///< the query knows shapes only, the map does not
  bool one_ground = false;  ///< one of them lacks a kind of ground that the other has: what it
                            ///< calls that ground instead is not known
  bool one_wall = false;    ///< fences are walls like those of houses
  bool one_post = false;    ///< signs and lights are poles
  std::uint32_t gone = 0;   ///< channels that one of them has no class for; bit = BevChannel

  bool isAll() const { return *this == CommonDetail{}; }
  bool operator==(const CommonDetail& o) const { return tied() == o.tied(); }
  bool operator<(const CommonDetail& o) const { return tied() < o.tied(); }

 private:
  std::tuple<bool, bool, bool, bool, std::uint32_t> tied() const {
    return {shapes, one_ground, one_wall, one_post, gone};
  }
};
CommonDetail commonDetail(const LabelSet& query, const LabelSet& map);

/// Leaves the detail in the view of a query that is common.
void reduceTo(const CommonDetail& detail, BevGrid& bev);

/// A place with the classes of `shapes` instead of its own, by their kinds: what a raw query can
/// be compared with.
void reduceToShapes(const LabelSet& shapes, Place& place);

/// The map with that detail only, for queries with the classes `of_query`. What is packed stays
/// packed and is reduced where somebody asks for it; the rest is copied.
SemanticMap reduced(const SemanticMap& map, const CommonDetail& detail, const LabelSet& of_query);

}  // namespace xview::map
