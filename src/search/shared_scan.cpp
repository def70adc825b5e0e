// SPDX-License-Identifier: BSD-3-Clause
#include "search/shared_scan.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "process/message.h"
#include "search/scan_helper.h"

namespace xview::search {
namespace {

constexpr std::size_t kRastersKept = 8;  ///< by helpers: two view-points, coarse and fine, and some

// ---- whose a tile is

/// Place of a tile along a Hilbert curve, on which neighbours are near one another.
std::uint64_t alongCurve(std::int64_t tx, std::int64_t ty) {
  constexpr int kBits = 21;
  constexpr std::int64_t kSide = std::int64_t{1} << kBits;
  auto x = static_cast<std::uint64_t>(std::clamp<std::int64_t>(tx + kSide / 2, 0, kSide - 1));
  auto y = static_cast<std::uint64_t>(std::clamp<std::int64_t>(ty + kSide / 2, 0, kSide - 1));
  std::uint64_t place = 0;
  for (std::uint64_t side = kSide / 2; side > 0; side /= 2) {
    const bool right = (x & side) != 0, upper = (y & side) != 0;
    place += side * side * ((right ? 3 : 0) ^ (upper ? 1 : 0));
    if (upper) continue;
    if (right) {
      x = kSide - 1 - x;
      y = kSide - 1 - y;
    }
    std::swap(x, y);
  }
  return place;
}

/// A raster that is shared, and which of its tiles each helper has.
struct SharedRaster {
  std::uint64_t id;
  std::vector<std::uint64_t>
      begins;  ///< along the curve, of the part of each process but the first
  std::vector<std::unordered_set<const LikelihoodRaster::Tile*>> sent;  ///< by helper

  SharedRaster(const LikelihoodRaster& raster, std::size_t helpers)
      : id(raster.id()), sent(helpers) {
    std::vector<std::uint64_t> places;
    for (const LikelihoodRaster::Tile& tile : raster.tiles())
      places.push_back(alongCurve(tile.tx, tile.ty));
    std::sort(places.begin(), places.end());
    for (std::size_t part = 1; part <= helpers; ++part)
      begins.push_back(places.empty() ? 0 : places[part * places.size() / (helpers + 1)]);
  }

  /// 0 = of this process, i = of helper i - 1.
  std::size_t ownerOf(const OutputTile& tile) const {
    const auto after = std::upper_bound(begins.begin(), begins.end(), alongCurve(tile.tx, tile.ty));
    return static_cast<std::size_t>(after - begins.begin());
  }
};

/// What the helpers have, for who talks to them.
struct SharedRasters {
  std::uint64_t generation = 0;     ///< of the helpers
  std::list<SharedRaster> rasters;  ///< the last asked for first
};
std::list<SharedRaster>& rastersOf(std::uint64_t generation) {
  static SharedRasters shared;
  if (shared.generation != generation) shared = {generation, {}};
  return shared.rasters;
}

/// As the helpers do it, too.
template <class Known, class Make>
Known& kept(std::list<Known>& known, std::uint64_t id, const Make& make) {
  const auto found =
      std::find_if(known.begin(), known.end(), [&](const Known& k) { return k.id == id; });
  if (found != known.end()) {
    known.splice(known.begin(), known, found);
  } else {
    known.push_front(make());
    if (known.size() > kRastersKept) known.pop_back();
  }
  return known.front();
}

/// Those that a scan of the outputs looks at and that were not sent yet.
std::vector<LikelihoodRaster::Tile> newTiles(
    const LikelihoodRaster& raster, const PreparedSamples& prepared,
    const std::vector<OutputTile>& outputs,
    std::unordered_set<const LikelihoodRaster::Tile*>& sent) {
  const std::int64_t reach = (prepared.reach + kTileSide - 1) / kTileSide;
  std::vector<LikelihoodRaster::Tile> tiles;
  for (const OutputTile& output : outputs) {
    for (std::int64_t ty = output.ty - reach; ty <= output.ty + reach; ++ty) {
      for (std::int64_t tx = output.tx - reach; tx <= output.tx + reach; ++tx) {
        const LikelihoodRaster::Place* place = raster.findPlace(tx, ty);
        for (const std::uint16_t channel : prepared.channels) {
          const LikelihoodRaster::Tile* tile = LikelihoodRaster::tileOf(place, channel);
          if (tile && sent.insert(tile).second) tiles.push_back(*tile);
        }
      }
    }
  }
  return tiles;
}

std::string requestFor(const RasterLevels& levels, const std::vector<LikelihoodRaster::Tile>& tiles,
                       const std::vector<OutputTile>& outputs) {
  const RasterLevel& level = levels.first();
  std::vector<std::uint8_t> background;
  for (std::size_t c = 0; c < level.raster.channels(); ++c)
    background.push_back(level.raster.background(c));
  MessageWriter request;
  request(HelperTask::scan, level.raster.id(), level.raster.cellSize(), background, tiles,
          level.samples, level.max_yaw_step_rad, levels.keep_cells, levels.threads,
          levels.centre_prior, outputs);
  return request.take();
}

}  // namespace

template <class Message>
void visit(OutputTile& tile, Message& message) {
  message(tile.tx, tile.ty, tile.bound, tile.rows);
}

// ---- the process that searches

SharedScan::SharedScan(const RasterLevels& levels, const PreparedSamples& prepared,
                       std::vector<OutputTile>& outputs) {
  const std::size_t count = helpers_.helpers();
  if (count == 0) return;
  const LikelihoodRaster& raster = levels.first().raster;
  SharedRaster& shared = kept(rastersOf(helpers_.generation()), raster.id(),
                              [&] { return SharedRaster(raster, count); });
  std::vector<std::vector<OutputTile>> parts(count + 1);
  for (OutputTile& output : outputs) parts[shared.ownerOf(output)].push_back(std::move(output));
  outputs = std::move(parts[0]);
  for (std::size_t i = 0; i < count; ++i) {
    const auto tiles = newTiles(raster, prepared, parts[i + 1], shared.sent[i]);
    helpers_.ask(i, requestFor(levels, tiles, parts[i + 1]));
  }
}

void SharedScan::collect(BestCandidates& best) {
  for (std::size_t i = 0; i < helpers_.helpers(); ++i) {
    const std::string answer = helpers_.answerOf(i);
    MessageReader reader(answer);
    for (const Candidate& candidate : reader.next<std::vector<Candidate>>()) best.offer(candidate);
    reader.end();
  }
}

// ---- a helper

ScanHelper::ScanHelper() = default;
ScanHelper::~ScanHelper() = default;

std::string ScanHelper::answer(const std::string& text) {
  MessageReader request(text);
  if (request.next<HelperTask>() != HelperTask::scan) request.fail();
  const auto id = request.next<std::uint64_t>();
  const auto cell_m = request.next<double>();
  const auto background = request.next<std::vector<std::uint8_t>>();
  Known& known = kept(known_, id, [&] {
    return Known{id, std::make_unique<LikelihoodRaster>(cell_m, background)};
  });
  for (const auto& tile : request.next<std::vector<LikelihoodRaster::Tile>>())
    known.raster->add(tile);
  auto samples = request.next<std::vector<RasterSample>>();
  const auto max_yaw_step_rad = request.next<double>();
  RasterLevels levels{{*known.raster, std::move(samples), max_yaw_step_rad}, std::nullopt};
  std::vector<OutputTile> outputs;
  request(levels.keep_cells, levels.threads, levels.centre_prior, outputs);
  request.end();
  MessageWriter answer;
  answer(scanTiles(levels, outputs));
  return answer.take();
}

std::size_t ScanHelper::tiles() const {
  std::size_t count = 0;
  for (const Known& known : known_) count += known.raster->tiles().size();
  return count;
}

}  // namespace xview::search
