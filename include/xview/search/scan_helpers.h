// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>

namespace xview::search {

class LikelihoodRaster;

/// Other processes on machines of the same kind, each with a ScanHelper. They scan parts of large
/// maps for the exhaustive search of this one. Called from one thread at a time.
class ScanHelpers {
 public:
  virtual ~ScanHelpers() = default;
  virtual int count() const = 0;
  /// Must not wait for the helper to have worked. Throws Error if the helper is gone.
  virtual void send(int helper, const std::string& request) = 0;
  /// The answer to the last request. Throws Error if the helper is gone.
  virtual std::string receive(int helper) = 0;
};

/// From now on; null = all is done here again. They must outlive all searches. The results of a
/// search are the same for any number of helpers. No search may run meanwhile.
void shareScans(ScanHelpers* helpers);

/// Scans its part of the maps that another process searches in.
class ScanHelper {
 public:
  ScanHelper();
  ~ScanHelper();
  ScanHelper(const ScanHelper&) = delete;
  ScanHelper& operator=(const ScanHelper&) = delete;

  /// Of a request that a process has sent to its ScanHelpers. Throws Error for anything else.
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
