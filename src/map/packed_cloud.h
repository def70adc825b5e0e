// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "map_tiles.h"
#include "xview/map/semantic_map.h"

namespace xview::map {

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
  using Key = std::pair<std::int32_t, std::int32_t>;  ///< (y, x)
  using Unpacked = std::pair<Key, std::shared_ptr<const LabelledCloud>>;

  std::vector<Tile> tiles_;
  std::string file_;
  std::size_t points_ = 0;
  std::map<Key, std::vector<std::size_t>> tiles_of_;  ///< by column, from the lowest
  mutable std::mutex mutex_;
  mutable std::list<Unpacked> recent_;  ///< the columns that were asked for last
};

/// unpackPoints(), but throws Damage.
void unpackAll(SemanticMap& map);

}  // namespace xview::map
