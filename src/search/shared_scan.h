// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "search/raster_parts.h"
#include "types/conversation.h"

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

/// Scans its part of the maps that another process searches in.
class ScanHelper {
 public:
  /// Of a request of SharedScan. Throws Error for anything else.
  std::string answer(const std::string& request);
  /// Tiles of rasters that are kept, 4 kB each.
  std::size_t tiles() const;

 private:
  struct Known {
    std::uint64_t id;
    std::unique_ptr<LikelihoodRaster> raster;
  };
  std::list<Known> known_;  ///< the last asked for first
};

}  // namespace xview::search
