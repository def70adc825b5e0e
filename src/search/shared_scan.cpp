// SPDX-License-Identifier: BSD-3-Clause
#include "search/shared_scan.h"

#include <algorithm>
#include <cstring>
#include <list>
#include <type_traits>
#include <unordered_set>
#include <utility>

#include "xview/search/scan_helpers.h"
#include "xview/types/error.h"

namespace xview::search {
namespace {

constexpr std::size_t kRastersKept = 8;  ///< by helpers: two view-points, coarse and fine, and some

// ---- messages: numbers as they are in memory

class Writer {
 public:
  template <class Value>
  void put(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class Value>
  void putAll(const std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    put(values.size());
    text_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

class Reader {
 public:
  explicit Reader(const std::string& text) : text_(text) {}
  template <class Value>
  Value get() {
    Value value{};
    std::memcpy(&value, bytes(sizeof value), sizeof value);
    return value;
  }
  template <class Value>
  std::vector<Value> getAll() {
    const auto count = get<std::size_t>();
    if (count > text_.size() / sizeof(Value)) fail();
    std::vector<Value> values(count);
    const char* from = bytes(count * sizeof(Value));
    if (count > 0) std::memcpy(values.data(), from, count * sizeof(Value));
    return values;
  }
  void end() const {
    if (place_ != text_.size()) fail();
  }

 private:
  const char* bytes(std::size_t count) {
    if (count > text_.size() - place_) fail();
    place_ += count;
    return text_.data() + place_ - count;
  }
  [[noreturn]] static void fail() {
    throw Error("message between processes", "not what this version of xview sends");
  }

  const std::string& text_;
  std::size_t place_ = 0;
};

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

struct Sharing {
  std::mutex mutex;  ///< who holds it talks to the helpers
  ScanHelpers* helpers = nullptr;
  std::list<SharedRaster> rasters;  ///< the last asked for first
};
Sharing& sharing() {
  static Sharing one;
  return one;
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
  Writer request;
  request.put(level.raster.id());
  request.put(level.raster.cellSize());
  request.putAll(background);
  request.putAll(tiles);
  request.putAll(level.samples);
  request.put(level.max_yaw_step_rad);
  request.put(levels.keep_cells);
  request.put(levels.threads);
  request.put(levels.centre_prior);
  request.put(outputs.size());
  for (const OutputTile& output : outputs) {
    request.put(output.tx);
    request.put(output.ty);
    request.put(output.bound);
    request.putAll(output.rows);
  }
  return request.take();
}

}  // namespace

void shareScans(ScanHelpers* helpers) {
  const std::lock_guard<std::mutex> lock(sharing().mutex);
  sharing().helpers = helpers && helpers->count() > 0 ? helpers : nullptr;
  sharing().rasters.clear();
}

// ---- the process that searches

SharedScan::SharedScan(const RasterLevels& levels, const PreparedSamples& prepared,
                       std::vector<OutputTile>& outputs)
    : lock_(sharing().mutex, std::try_to_lock) {
  if (!lock_ || !sharing().helpers) return;
  ScanHelpers& helpers = *sharing().helpers;
  const auto count = static_cast<std::size_t>(helpers.count());
  const LikelihoodRaster& raster = levels.first().raster;
  SharedRaster& shared =
      kept(sharing().rasters, raster.id(), [&] { return SharedRaster(raster, count); });
  std::vector<std::vector<OutputTile>> parts(count + 1);
  for (OutputTile& output : outputs) parts[shared.ownerOf(output)].push_back(std::move(output));
  outputs = std::move(parts[0]);
  for (std::size_t i = 0; i < count; ++i) {
    const auto tiles = newTiles(raster, prepared, parts[i + 1], shared.sent[i]);
    helpers.send(static_cast<int>(i), requestFor(levels, tiles, parts[i + 1]));
    ++asked_;
  }
}

SharedScan::~SharedScan() {
  try {
    while (answered_ < asked_) sharing().helpers->receive(answered_++);
  } catch (const Error&) {
    // A helper that is gone is met by the next request.
  }
}

void SharedScan::collect(BestCandidates& best) {
  while (answered_ < asked_) {
    const std::string answer = sharing().helpers->receive(answered_++);
    Reader reader(answer);
    for (const Candidate& candidate : reader.getAll<Candidate>()) best.offer(candidate);
    reader.end();
  }
}

// ---- a helper

ScanHelper::ScanHelper() = default;
ScanHelper::~ScanHelper() = default;

std::string ScanHelper::answer(const std::string& text) {
  Reader request(text);
  const auto id = request.get<std::uint64_t>();
  const auto cell_m = request.get<double>();
  const auto background = request.getAll<std::uint8_t>();
  Known& known = kept(known_, id, [&] {
    return Known{id, std::make_unique<LikelihoodRaster>(cell_m, background)};
  });
  for (const auto& tile : request.getAll<LikelihoodRaster::Tile>()) known.raster->add(tile);
  auto samples = request.getAll<RasterSample>();
  const auto max_yaw_step_rad = request.get<double>();
  RasterLevels levels{{*known.raster, std::move(samples), max_yaw_step_rad}, std::nullopt};
  levels.keep_cells = request.get<std::size_t>();
  levels.threads = request.get<int>();
  levels.centre_prior = request.get<PlacePrior>();
  std::vector<OutputTile> outputs;
  for (auto left = request.get<std::size_t>(); left > 0; --left) {
    OutputTile output;
    output.tx = request.get<std::int64_t>();
    output.ty = request.get<std::int64_t>();
    output.bound = request.get<std::int64_t>();
    output.rows = request.getAll<RowRun>();
    outputs.push_back(std::move(output));
  }
  request.end();
  Writer answer;
  answer.putAll(scanTiles(levels, outputs));
  return answer.take();
}

std::size_t ScanHelper::tiles() const {
  std::size_t count = 0;
  for (const Known& known : known_) count += known.raster->tiles().size();
  return count;
}

}  // namespace xview::search
