// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "map/contents.h"
#include "map_tiles.h"
#include "xview/base/error.h"
#include "xview/map/semantic_map.h"

namespace xview::map {

/// Runs `work`; damage of the file becomes an Error, if it has a name.
template <class Work>
void rethrowDamage(const std::string& file, const Work& work) {
  try {
    work();
  } catch (const Damage& e) {
    if (file.empty()) throw;
    throw Error(file, std::string("damaged map file: ") + e.what());
  }
}

/// What was unpacked last. Thread-safe.
template <class Key, class Content>
class Recent {
 public:
  explicit Recent(std::size_t most) : most_(most) {}

  /// What is kept, or else what make() returns.
  template <class Make>
  std::shared_ptr<const Content> findOrMake(const Key& key, const Make& make) {
    if (auto known = find(key)) return known;
    std::shared_ptr<const Content> made = make();
    const std::lock_guard<std::mutex> lock(mutex_);
    contents_.emplace_front(key, made);
    if (contents_.size() > most_) contents_.pop_back();
    return made;
  }

 private:
  /// Null if it is not kept.
  std::shared_ptr<const Content> find(const Key& key) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (auto known = contents_.begin(); known != contents_.end(); ++known) {
      if (!(known->first == key)) continue;
      contents_.splice(contents_.begin(), contents_, known);
      return known->second;
    }
    return nullptr;
  }

  std::size_t most_;
  std::mutex mutex_;
  std::list<std::pair<Key, std::shared_ptr<const Content>>> contents_;
};

/// Columns of 64 m.
template <class Content>
using RecentColumns = Recent<PlaneCell, Content>;

/// Tiles by the column they are in.
class TilesOfColumns {
 public:
  explicit TilesOfColumns(const std::vector<Tile>& tiles);

  std::vector<PlaneCell> columns() const;
  /// Positions in the tiles, from the lowest one.
  const std::vector<std::size_t>& in(const PlaneCell& column) const;

 private:
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::size_t>> tiles_of_;  ///< (y, x)
};

class PackedCloud final : public StoredCloud {
 public:
  /// In the order of toTiles(), of a file of that name.
  PackedCloud(std::vector<Tile> tiles, std::string file);

  std::size_t size() const override { return points_; }
  std::vector<PlaneCell> columns() const override;
  /// Throws Error if the file was damaged.
  std::shared_ptr<const LabelledCloud> pointsOf(const PlaneCell& column) const override;
  const std::vector<Tile>& tiles() const { return tiles_; }
  const std::string& file() const { return file_; }

 private:
  std::vector<Tile> tiles_;
  std::string file_;
  std::size_t points_ = 0;
  TilesOfColumns tiles_of_;
  mutable RecentColumns<LabelledCloud> recent_;
};

/// The bird's-eye view of a map as its file has it.
class PackedBev final : public StoredView {
 public:
  /// `grid`: without samples and seen cells. `samples`, `fingerprint`: of the whole view.
  PackedBev(std::vector<Tile> tiles, BevGrid grid, std::string file, std::size_t samples,
            std::uint64_t fingerprint);

  std::vector<PlaneCell> columns() const override { return tiles_of_.columns(); }
  std::shared_ptr<const BevGrid> partOf(const PlaneCell& column) const override;
  const BevGrid& whole() const override;
  std::size_t sampleCount() const override { return samples_; }
  std::uint64_t fingerprint() const override { return fingerprint_; }
  const std::vector<Tile>& tiles() const { return tiles_; }
  /// The view with `now` in those columns in place of `former`, both gathered() from there. Null if
  /// something of `now` lies elsewhere.
  std::shared_ptr<const PackedBev> changed(const CellIndex& columns, const BevGrid& former,
                                           const BevGrid& now) const;

 private:
  std::vector<Tile> tiles_;
  BevGrid grid_;
  std::string file_;
  std::size_t samples_;
  std::uint64_t fingerprint_;
  TilesOfColumns tiles_of_;
  mutable RecentColumns<BevGrid> recent_;
  mutable std::once_flag unpacked_;
  mutable BevGrid whole_;
};

/// As a file has them, so that they can be written again: null if they are unpacked or reduced.
const PackedBev* packedBevOf(const SemanticMap& map);
const PackedCloud* packedCloudOf(const SemanticMap& map);

}  // namespace xview::map
