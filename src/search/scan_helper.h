// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>

namespace xview::search {

class LikelihoodRaster;

/// Scans its part of the maps that another process searches in.
class ScanHelper {
 public:
  ScanHelper();
  ~ScanHelper();
  ScanHelper(const ScanHelper&) = delete;
  ScanHelper& operator=(const ScanHelper&) = delete;

  /// Of a request with HelperTask::scan. Throws Error for anything else.
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
