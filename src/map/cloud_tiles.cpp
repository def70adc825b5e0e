// SPDX-License-Identifier: BSD-3-Clause
// A tile, before compression: in columns and as difference to the point before, label, instance,
// and x, y, z in centimetres from the corner of the tile; points sorted in this order.
#include "cloud_tiles.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

#include "damage.h"
#include "grid.h"

namespace xview {
namespace {

constexpr std::int64_t kSide = 6400;  // centimetres

struct StoredPoint {
  std::uint32_t label = 0, instance = 0;
  std::int32_t x = 0, y = 0, z = 0;  ///< centimetres, [0, kSide)
  bool operator<(const StoredPoint& o) const {
    return std::tie(label, instance, x, y, z) < std::tie(o.label, o.instance, o.x, o.y, o.z);
  }
};

using TileKey = std::tuple<std::int64_t, std::int64_t, std::int64_t>;  // (z, y, x)

bool isFinite(const Point& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

std::map<TileKey, std::vector<StoredPoint>> distribute(const LabelledCloud& cloud) {
  std::map<TileKey, std::vector<StoredPoint>> tiles;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& p = cloud.points[i];
    if (!isFinite(p)) continue;
    const std::int64_t x = toSteps(p.x, "point of the cloud"),
                       y = toSteps(p.y, "point of the cloud"),
                       z = toSteps(p.z, "point of the cloud");
    const std::int64_t tx = floorDivide(x, kSide), ty = floorDivide(y, kSide),
                       tz = floorDivide(z, kSide);
    tiles[{tz, ty, tx}].push_back({p.label, p.instance, static_cast<std::int32_t>(x - tx * kSide),
                                   static_cast<std::int32_t>(y - ty * kSide),
                                   static_cast<std::int32_t>(z - tz * kSide)});
  }
  return tiles;
}

template <class Number>
void writeColumn(const std::vector<StoredPoint>& points, Number StoredPoint::*field,
                 ByteWriter& out) {
  std::int64_t previous = 0;
  for (const StoredPoint& p : points) {
    out.signedInteger(static_cast<std::int64_t>(p.*field) - previous);
    previous = p.*field;
  }
}

template <class Number>
void readColumn(std::vector<StoredPoint>& points, Number StoredPoint::*field, std::int64_t largest,
                ByteReader& in) {
  std::uint64_t value = 0;  // wraps in a damaged file
  for (StoredPoint& p : points) {
    value += static_cast<std::uint64_t>(in.signedInteger());
    if (value > static_cast<std::uint64_t>(largest))
      throw Damage("cloud tile with a value out of range");
    p.*field = static_cast<Number>(value);
  }
}

Bytes packed(std::vector<StoredPoint>& points) {
  std::sort(points.begin(), points.end());
  ByteWriter out;
  writeColumn(points, &StoredPoint::label, out);
  writeColumn(points, &StoredPoint::instance, out);
  writeColumn(points, &StoredPoint::x, out);
  writeColumn(points, &StoredPoint::y, out);
  writeColumn(points, &StoredPoint::z, out);
  return compressed(out.bytes());
}

}  // namespace

std::vector<CloudTile> toTiles(const LabelledCloud& cloud) {
  auto open = distribute(cloud);
  std::vector<CloudTile> tiles;
  tiles.reserve(open.size());
  for (auto& [key, points] : open) {
    const auto& [z, y, x] = key;
    tiles.push_back({x, y, z, static_cast<std::uint32_t>(points.size()), packed(points)});
  }
  return tiles;
}

void appendTile(const CloudTile& tile, LabelledCloud& cloud) {
  if (!isTileIndex(tile.x) || !isTileIndex(tile.y) || !isTileIndex(tile.z)) {
    throw Damage("cloud tile with an index out of range");
  }
  const Bytes raw = decompressed(tile.data);
  if (tile.points > raw.size()) throw Damage("cloud tile announces more points than bytes");
  ByteReader in(raw);
  std::vector<StoredPoint> points(tile.points);
  readColumn(points, &StoredPoint::label, std::numeric_limits<std::uint32_t>::max(), in);
  readColumn(points, &StoredPoint::instance, std::numeric_limits<std::uint32_t>::max(), in);
  readColumn(points, &StoredPoint::x, kSide - 1, in);
  readColumn(points, &StoredPoint::y, kSide - 1, in);
  readColumn(points, &StoredPoint::z, kSide - 1, in);
  if (in.remaining() > 0) throw Damage("cloud tile with more bytes than points");
  for (const StoredPoint& p : points) {
    Point point;
    point.x = toMetres(tile.x * kSide + p.x);
    point.y = toMetres(tile.y * kSide + p.y);
    point.z = toMetres(tile.z * kSide + p.z);
    point.label = p.label;
    point.instance = p.instance;
    cloud.points.push_back(point);
  }
}

}  // namespace xview
