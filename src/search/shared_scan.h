// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <vector>

#include "search/raster_parts.h"

namespace xview::search {

/// The best keep_cells candidates of the first level in these tiles, best first.
std::vector<Candidate> scanTiles(const RasterLevels& levels,
                                 const std::vector<OutputTile>& outputs);

/// What of one scan the helpers do, if there are any and nobody else has them.
class SharedScan {
 public:
  /// Takes their tiles out of `outputs`.
  SharedScan(const RasterLevels& levels, const PreparedSamples& prepared,
             std::vector<OutputTile>& outputs);
  ~SharedScan();  ///< what they have not answered yet is waited for
  SharedScan(const SharedScan&) = delete;
  SharedScan& operator=(const SharedScan&) = delete;

  /// Adds what they have found.
  void collect(BestCandidates& best);

 private:
  std::unique_lock<std::mutex> lock_;
  int asked_ = 0, answered_ = 0;  ///< helpers
};

}  // namespace xview::search
