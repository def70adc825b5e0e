// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "process/helpers.h"
#include "search/raster_parts.h"

namespace xview::search {

/// The best keep_cells candidates of the first level in these tiles, best first.
std::vector<Candidate> scanTiles(const RasterLevels& levels,
                                 const std::vector<OutputTile>& outputs);

/// What of one scan the helpers do, if there are any and nobody else has them.
class SharedScan {
 public:
  /// Takes their tiles out of `outputs`. Ends when what they were asked for is answered.
  SharedScan(const RasterLevels& levels, const PreparedSamples& prepared,
             std::vector<OutputTile>& outputs);
  /// Adds what they have found.
  void collect(BestCandidates& best);

 private:
  Conversation helpers_;  ///< each is asked once
};

}  // namespace xview::search
