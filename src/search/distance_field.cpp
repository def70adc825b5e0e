// SPDX-License-Identifier: BSD-3-Clause
#include "xview/search/distance_field.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "xview/types/cells.h"
#include "xview/types/parallel.h"
#include "xview/types/random.h"

namespace xview::search {
namespace {

// Compiled with -O3 -ffp-contract=off: vectors of any width, but the same roundings with all of
// them.
#define XVIEW_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))

constexpr int kSide = DistanceField::kTileCells;
constexpr int kCells = kSide * kSide;
constexpr float kReach_m = kBinLimits_m.back();  ///< beyond it every distance is in the last class
constexpr float kSeenNear_m = 1.f;               ///< a cell this near to a seen one counts as seen
constexpr float kFar = 1e9f;                     ///< squared distance where there is no sample
constexpr int kNearBins = 5;  ///< classes below 2 m say something even where the map was not seen
static_assert(kBinLimits_m[kNearBins - 1] == 2.f, "classes below 2 m");

using TileKey = std::pair<std::int32_t, std::int32_t>;  ///< (y, x)
using Mask = std::vector<std::uint8_t>;                 ///< 1 per cell of a tile that was seen

/// Cells of each tile that were seen, grown by kSeenNear_m; the key set is the set of tiles of the
/// field.
std::map<TileKey, Mask> seenTiles(const BevGrid& map) {
  std::map<TileKey, Mask> seen;
  const int reach = static_cast<int>(kSeenNear_m / map.cell_m);
  TileKey last{std::numeric_limits<std::int32_t>::max(), 0};
  Mask* mask = nullptr;
  for (const GroundCell& cell : map.known) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const TileKey key{(cell.y + dy) >> 6, (cell.x + dx) >> 6};
        if (!mask || key != last) {
          mask = &seen[key];
          mask->resize(kCells, 0);
          last = key;
        }
        (*mask)[DistanceField::cellInTile(cell.x + dx, cell.y + dy)] = 1;
      }
    }
  }
  return seen;
}

/// A sample, in cells from the first one of a tile.
struct Site {
  float x, y;
};
/// From the centres of the cells of a tile to the nearest site, squared.
using Distances = std::array<float, kCells>;

constexpr int kBlock = 16;  ///< columns that are looked at together

/// Lowers the distances of the cells up to `reach` rows and columns away to those to one site, and
/// of some more columns.
XVIEW_CLONES void tryOneSite(Site site, float reach, float* squared) {
  const int first_row = std::max(0, static_cast<int>(site.y - reach) - 1),
            last_row = std::min(kSide, static_cast<int>(site.y + reach) + 1),
            first_column = std::max(0, static_cast<int>(site.x - reach) - 1) & ~(kBlock - 1),
            last_column = std::min(kSide, static_cast<int>(site.x + reach) + 1);
  for (int column = first_column; column < last_column; column += kBlock) {
    float across[kBlock];
    for (int x = 0; x < kBlock; ++x) {
      const float dx = static_cast<float>(column + x) + 0.5f - site.x;
      across[x] = dx * dx;
    }
    for (int y = first_row; y < last_row; ++y) {
      const float dy = static_cast<float>(y) + 0.5f - site.y, dy_squared = dy * dy;
      float* row = squared + y * kSide + column;
      for (int x = 0; x < kBlock; ++x) {
        const float d = across[x] + dy_squared;
        row[x] = d < row[x] ? d : row[x];
      }
    }
  }
}

XVIEW_CLONES void addReached(const float* __restrict squared, float limit,
                             std::uint8_t* __restrict counts) {
  for (int i = 0; i < kCells; ++i) {
    counts[i] = static_cast<std::uint8_t>(counts[i] + (squared[i] >= limit));
  }
}

/// Distances above `reach` are only known to be above it.
Distances squaredDistances(const std::vector<Site>& sites, float reach) {
  Distances squared;
  squared.fill(kFar);
  for (const Site& s : sites) tryOneSite(s, reach, squared.data());
  return squared;
}

/// Samples in cells, by tile and channel.
class SamplesByTile {
 public:
  SamplesByTile(const BevGrid& map, float reach)
      : tiles_around_(static_cast<int>(reach) / kSide + 1), reach_(reach) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      for (const BevSample& s : map.samples[c]) {
        const auto x = static_cast<float>(s.x / map.cell_m),
                   y = static_cast<float>(s.y / map.cell_m);
        tiles_[{tileOf(y), tileOf(x)}][c].push_back({x, y});
      }
    }
  }

  using Sites = std::vector<Site>;
  /// Those within reach of a tile, relative to it.
  std::array<Sites, kBevChannels> around(std::int32_t tile_x, std::int32_t tile_y) const {
    std::array<Sites, kBevChannels> result;
    const float x0 = static_cast<float>(tile_x) * kSide, y0 = static_cast<float>(tile_y) * kSide;
    const auto inReach = [this](float p) { return p >= -reach_ && p <= kSide + reach_; };
    for (int dy = -tiles_around_; dy <= tiles_around_; ++dy) {
      for (int dx = -tiles_around_; dx <= tiles_around_; ++dx) {
        const auto it = tiles_.find({tile_y + dy, tile_x + dx});
        if (it == tiles_.end()) continue;
        for (std::size_t c = 0; c < kBevChannels; ++c) {
          for (const Site& s : it->second[c]) {
            if (inReach(s.x - x0) && inReach(s.y - y0)) result[c].push_back({s.x - x0, s.y - y0});
          }
        }
      }
    }
    return result;
  }

 private:
  static std::int32_t tileOf(float cell) {
    return static_cast<std::int32_t>(std::floor(cell / kSide));
  }

  int tiles_around_;
  float reach_;
  std::map<TileKey, std::array<Sites, kBevChannels>> tiles_;
};

/// Limits of the classes in cells, squared.
std::vector<float> squaredLimits(double cell_m) {
  std::vector<float> limits;
  for (const float limit : kBinLimits_m) {
    limits.push_back(static_cast<float>(std::pow(limit / cell_m, 2)));
  }
  return limits;
}

void appendPlane(const Distances& squared, const std::vector<float>& limits, const Mask& mask,
                 std::vector<std::uint8_t>& planes) {
  planes.resize(planes.size() + kCells);
  std::uint8_t* plane = planes.data() + planes.size() - kCells;
  for (const float limit : limits) addReached(squared.data(), limit, plane);
  for (int i = 0; i < kCells; ++i) {
    const bool unknown = plane[i] >= kNearBins && !mask[i];
    plane[i] = unknown ? static_cast<std::uint8_t>(kUnknownBin) : plane[i];
  }
}

/// The planes of one tile, and which of them each channel has. The first is that of all channels
/// without a sample in reach.
struct TilePlanes {
  std::vector<std::uint8_t> planes;
  std::array<std::size_t, kBevChannels> plane_of{};
};

TilePlanes makePlanes(const std::array<SamplesByTile::Sites, kBevChannels>& samples,
                      const Mask& mask, double cell_m) {
  TilePlanes result;
  const auto reach = static_cast<float>(kReach_m / cell_m);
  const auto limits = squaredLimits(cell_m);
  const auto present = std::count_if(samples.begin(), samples.end(),
                                     [](const auto& sites) { return !sites.empty(); });
  result.planes.reserve(static_cast<std::size_t>(present + 1) * kCells);
  appendPlane(squaredDistances({}, reach), limits, mask, result.planes);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (samples[c].empty()) continue;
    result.plane_of[c] = result.planes.size() / kCells;
    appendPlane(squaredDistances(samples[c], reach), limits, mask, result.planes);
  }
  return result;
}

}  // namespace

DistanceField::DistanceField(const BevGrid& map, int threads)
    : cell_m_(map.cell_m), origin_x_(map.origin_x), origin_y_(map.origin_y) {
  const auto seen = seenTiles(map);
  if (seen.empty()) return;
  std::vector<const Mask*> masks;
  for (const auto& tile : seen) {
    const auto y = tile.first.first, x = tile.first.second;
    tiles_.emplace_back();
    tiles_.back().y = y;
    tiles_.back().x = x;
    places_.numberOf({x, y}, [&] { return Place{{x, y}}; });
    masks.push_back(&tile.second);
  }
  const SamplesByTile samples(map, static_cast<float>(kReach_m / cell_m_));
  planes_.resize(tiles_.size());
  parallelFor(tiles_.size(), threads, [&](std::size_t t) {
    Tile& tile = tiles_[t];
    TilePlanes made = makePlanes(samples.around(tile.x, tile.y), *masks[t], cell_m_);
    planes_[t] = std::move(made.planes);
    for (std::size_t c = 0; c < kBevChannels; ++c)
      tile.bins[c] = planes_[t].data() + made.plane_of[c] * kCells;
    tile.ground.assign(kCells, std::numeric_limits<float>::quiet_NaN());
  });
  setGround(map.known);
}

void DistanceField::setGround(const std::vector<GroundCell>& known) {
  std::vector<double> sums(tiles_.size(), 0);
  std::vector<int> counts(tiles_.size(), 0);
  for (const GroundCell& cell : known) {
    const auto t = static_cast<std::size_t>(findTile(cell.x, cell.y));
    sums[t] += double{cell.z};
    ++counts[t];
    if (cell.measured) tiles_[t].ground[cellInTile(cell.x, cell.y)] = cell.z;
  }
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    if (counts[t] > 0) tiles_[t].level = static_cast<float>(sums[t] / counts[t]);
  }
}

namespace {

constexpr int kDraws = 300;
constexpr double kSight_m = 30, kApart_m = 25;
constexpr double kBlock_m = 2;  ///< samples are thinned to one per block
constexpr std::uint64_t kSeed = 11;

double headingAt(const std::vector<Eigen::Vector2d>& path, std::size_t i) {
  const Eigen::Vector2d d = path[i + 1] - path[i - 1];
  return std::atan2(d.y(), d.x());
}

/// Samples of a channel in cells as wide as the sight, thinned.
class NearbySamples {
 public:
  explicit NearbySamples(const std::vector<BevSample>& samples) : samples_(samples) {
    CellIndex taken;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const std::size_t before = taken.size();
      taken.findOrAdd(floorToInt(samples[i].x / kBlock_m), floorToInt(samples[i].y / kBlock_m));
      if (taken.size() > before)
        cells_.add(cellOf({samples[i].x, samples[i].y, 0}, kSight_m, 0), i);
    }
  }
  template <class Body>
  void around(const Eigen::Vector2d& p, Body&& body) const {
    cells_.forAround(cellOf({p.x(), p.y(), 0}, kSight_m, 0), [&](std::size_t i) {
      const double x = samples_[i].x - p.x(), y = samples_[i].y - p.y();
      if (x * x + y * y <= kSight_m * kSight_m) body(x, y);
    });
  }

 private:
  const std::vector<BevSample>& samples_;
  CellLists cells_;
};

struct WrongPose {
  Eigen::Vector2d from, to;
  double yaw;
};

/// From or to a pose of the path that is not one of the first `known`.
std::vector<WrongPose> drawWrongPoses(const std::vector<Eigen::Vector2d>& path, std::size_t known) {
  std::vector<WrongPose> poses;
  Random random(kSeed + known);
  const double known_share = static_cast<double>(known) / static_cast<double>(path.size());
  const int draws = static_cast<int>(std::ceil(kDraws * (1 - known_share * known_share)));
  const std::size_t first = std::clamp<std::size_t>(known, 1, path.size() - 2);
  for (int draw = 0; draw < draws; ++draw) {
    std::size_t j = first + random.below(static_cast<std::uint32_t>(path.size() - 1 - first));
    std::size_t i = 1 + random.below(static_cast<std::uint32_t>(path.size() - 2));
    if (known > 0 && draw % 4 > 1) std::swap(i, j);
    const Eigen::Vector2d jitter(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5));
    const double yaw =
        headingAt(path, i) - headingAt(path, j) + (draw % 2 ? M_PI : 0) + random.uniform(-.03, .03);
    if ((path[i] - path[j]).norm() >= kApart_m) poses.push_back({path[j], path[i] + jitter, yaw});
  }
  return poses;
}

}  // namespace

std::uint64_t fingerprintOf(const BevGrid& map) {
  std::uint64_t hash = map.known.size();
  for (const auto& samples : map.samples) hash = hash * 0x9E3779B97F4A7C15ull + samples.size();
  return hash >> 16;  // so that a double holds it
}

PathNull mapNull(const BevGrid& map, const std::vector<Eigen::Vector2d>& path,
                 const DistanceField& field, const PathNull& known) {
  const std::uint64_t view = fingerprintOf(map);
  if (path.size() < 4 || (known.poses > 0 && view == known.view)) return known;
  const bool has_grown = path.size() > known.poses;
  PathNull null{has_grown ? known.counts : MapNull{}, path.size(), view};
  const std::vector<WrongPose> poses = drawWrongPoses(path, has_grown ? known.poses : 0);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const NearbySamples samples(map.samples[c]);
    for (const WrongPose& pose : poses) {
      const double cosine = std::cos(pose.yaw), sine = std::sin(pose.yaw);
      samples.around(pose.from, [&](double x, double y) {
        const double px = pose.to.x() + cosine * x - sine * y,
                     py = pose.to.y() + sine * x + cosine * y;
        const std::uint8_t bin = field.binAt(c, px, py);
        if (bin < kDistanceBins) ++null.counts[c][bin];
      });
    }
  }
  return null;
}

}  // namespace xview::search
