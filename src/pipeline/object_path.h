// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <optional>

#include "xview/localizer.h"
#include "xview/match/object_places.h"
#include "xview/types/place.h"

namespace xview {

/// Object search, for graphs without surfaces.
class ObjectPath {
 public:
  /// All must outlive the path.
  ObjectPath(const SemanticMap& map, const PlacePrior& prior, const Options& options) : map_(map), prior_(prior), options_(options) {}

  /// Fills everything but the refined pose and its covariance. Makes the index of the map at the first call.
  void localize(const Query& query, Localization& answer) const;

 private:
  const ObjectPlaceIndex& index() const;

  const SemanticMap& map_;
  const PlacePrior& prior_;
  const Options& options_;
  mutable std::once_flag made_;
  mutable std::optional<ObjectPlaceIndex> index_;
};

}  // namespace xview
