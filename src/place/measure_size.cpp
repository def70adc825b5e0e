// SPDX-License-Identifier: BSD-3-Clause
#include "place/measure_size.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/cells.h"
#include "base/median.h"
#include "base/stray_points.h"
#include "place/floors.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr std::size_t kFrames = 12;                 ///< looked at of all recordings together
constexpr std::size_t kPoints = 5000;               ///< approximate number per frame
constexpr double kMostSeen = 0.9;                   ///< the ground near by is seen in any place
constexpr double kFlatRatio = 16;                   ///< ratio of width to height of a flat place
constexpr double kCells = 64;                       ///< across where most points of a cloud are
constexpr std::size_t kPointsOfCloud = 100000;      ///< approximate number sorted into them
constexpr std::size_t kPointsOfBuilding = 1000000;  ///< the same, where floors are looked for
constexpr double kCrowd = 0.2;                      ///< of the points at the height where most are
constexpr double kPeak = 0.05;                      ///< of all points at that height, at least
constexpr double kTopAndBottom = 0.2;               ///< of the height of a place
constexpr double kRoofed = 1.0 / 3;                 ///< share of a place that has something at both
constexpr double kRooms = 8;  ///< times as wide as high: what counts of a roofed place
/// What is between two sizes is taken for the nearer one, in ratios.
constexpr double kTownRange_m = 9, kRoomRange_m = 1.6;  ///< of most that a sensor sees
constexpr double kTownReach_m = 12, kRoomReach_m = 2.3, kPartReach_m = 0.9;  ///< of clouds
constexpr double kTownGraph_m = 7.2, kRoomGraph_m = 1.35;                    ///< of bare graphs

struct OccupiedCell {
  ClassCell key;
};

double sizeOf(double length, double least_town, double least_room) {
  return length >= least_town ? kTownScale : length >= least_room ? kRoomScale : kDeskScale;
}

/// Of a cloud, which may be a part of a room, as a depth camera sees it.
double sizeOfCloud(double reach) {
  constexpr double kPartOfRoom = kRoomScale / 2;
  const bool is_part = reach >= kPartReach_m && reach < kRoomReach_m;
  return is_part ? kPartOfRoom : sizeOf(reach, kTownReach_m, kRoomReach_m);
}

/// Distances of what a sensor measured [m].
std::vector<double> rangesOf(const Frame& frame) {
  std::vector<double> ranges;
  const std::size_t step = 1 + frame.depth.pixels.size() / kPoints;
  for (std::size_t i = 0; i < frame.depth.pixels.size(); i += step) {
    if (isDepth(frame.depth.pixels[i])) ranges.push_back(frame.depth.pixels[i]);
  }
  const std::size_t stride = 1 + frame.cloud.size() / kPoints;
  for (std::size_t i = 0; i < frame.cloud.size(); i += stride) {
    const double range = frame.cloud.position(i).norm();
    if (std::isfinite(range) && range > 0) ranges.push_back(range);
  }
  return ranges;
}

/// Between the fifth and the 95th percentile.
double spreadOf(std::vector<double> values) {
  if (values.size() < 2) return 0;
  const std::size_t cut = values.size() / 20;
  const double high = rankedOf(values, values.size() - 1 - cut);
  return high - rankedOf(values, cut);
}

std::vector<double> along(int axis, const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> values;
  for (const Eigen::Vector3d& p : points) values.push_back(p[axis]);
  return values;
}

/// From the fifth to the 95th percentile along each axis.
Eigen::Vector3d spreadsOf(const std::vector<Eigen::Vector3d>& points) {
  return {spreadOf(along(0, points)), spreadOf(along(1, points)), spreadOf(along(2, points))};
}

/// Points of a place seen from above: near the bottom, near the top, and between.
struct Column {
  ClassCell key;
  int bottom = 0, top = 0, between = 0;

  bool isRoofed() const { return bottom > 0 && top > 0 && between <= bottom + top; }
};

/// Whether rooms go on side by side: a third of the place and more has a floor, a ceiling and
/// little between, where of a town a tenth has ground and roofs, or crowns.
bool isRoofed(const std::vector<Eigen::Vector3d>& points, int up, double side_m) {
  std::vector<double> heights = along(up, points);
  const double low = quantileOf(heights, 0.05), high = quantileOf(heights, 0.95);
  const double near = kTopAndBottom * (high - low);
  CellTable<Column> columns;
  for (Eigen::Vector3d p : points) {
    const double height = std::exchange(p[up], 0);
    const ClassCell cell = cellOf(p, side_m, 0);
    Column& column = columns[columns.numberOf(cell, [&] { return Column{cell}; })];
    ++(height < low + near ? column.bottom : height > high - near ? column.top : column.between);
  }
  std::size_t roofed = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) roofed += columns[i].isRoofed();
  return static_cast<double>(roofed) >= kRoofed * static_cast<double>(columns.size());
}

/// Whether points crowd at two heights, as they do where floors or ceilings lie above one another.
bool crowdAtHeights(const std::vector<Eigen::Vector3d>& points) {
  HeightCounts counts(kFloorBin_m);
  for (const Eigen::Vector3d& p : points) counts.add(p.z());
  const std::vector<std::pair<int, double>> ranked = counts.ranked();
  if (ranked[0].first < kPeak * static_cast<double>(points.size())) return false;  // a slope
  return std::any_of(ranked.begin(), ranked.end(), [&](const auto& height) {
    return std::abs(height.second - ranked[0].second) >= kLowestStorey_m &&
           height.first >= kCrowd * ranked[0].first;
  });
}

/// From floor to floor of a building whose floors lie above one another [m], or 0.
double heightOfStorey(const LabelledCloud& cloud, const Eigen::AlignedBox3d& box) {
  FloorFinder finder(1);
  const std::size_t step = 1 + cloud.size() / kPointsOfBuilding;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (const Eigen::Vector3d p = cloud.position(i); box.contains(p)) finder.add(p);
  }
  const std::vector<double> floors = finder.heights();
  if (floors.size() < 2) return 0;
  return (floors.back() - floors.front()) / static_cast<double>(floors.size() - 1);
}

/// The mean, in ratios, of how far and how high a cloud reaches [m], of rooms about that of one.
/// Places count, not points: half of the points of a scan are within some metres of the scanner, in
/// a town as in a room.
double reachOf(const LabelledCloud& cloud) {
  std::vector<Eigen::Vector3d> points;
  const Eigen::AlignedBox3d box = boxWithoutStrays(cloud);
  const std::size_t step = 1 + cloud.size() / kPointsOfCloud;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (const Eigen::Vector3d p = cloud.position(i); box.contains(p)) points.push_back(p);
  }
  const double side_m = spreadsOf(points).maxCoeff() / kCells;
  if (!(side_m > 0)) return 0;
  CellTable<OccupiedCell> places;
  std::vector<Eigen::Vector3d> middles;
  for (const Eigen::Vector3d& p : points) {
    const ClassCell cell = cellOf(p, side_m, 0);
    if (places.numberOf(cell, [&] { return OccupiedCell{cell}; }) == middles.size())
      middles.push_back(p);
  }
  // Whichever way is up; what is flat shows nothing but ground.
  Eigen::Index up = 0;
  const Eigen::Vector3d spreads = spreadsOf(middles);
  const double height = spreads.minCoeff(&up), width = spreads.maxCoeff();
  if (width > kRooms * height && isRoofed(points, static_cast<int>(up), side_m))
    return std::sqrt(kRooms) * height;
  const double reach = std::sqrt(std::max(height, width / kFlatRatio) * width);
  const bool may_be_building = reach >= kTownReach_m && crowdAtHeights(points);
  const double storey = may_be_building ? heightOfStorey(cloud, box) : 0;
  return storey > 0 ? std::min(reach, std::sqrt(kRooms) * storey) : reach;
}

/// What tells the size of a frame [m]: of a sensor how far away most of what it sees is, of a cloud
/// how far it reaches; 0 if nothing is measured.
double lengthOf(const Frame& frame) {
  if (frame.sensor == Sensor::cloud) return reachOf(frame.cloud);
  std::vector<double> ranges = rangesOf(frame);
  return ranges.empty() ? 0 : quantileOf(ranges, kMostSeen);
}

MeasuredSize measured(const std::vector<double>& lengths, Sensor sensor) {
  if (lengths.empty()) return {kTownScale, "nothing to measure"};
  const double length = medianOf(lengths);
  if (sensor == Sensor::cloud) {
    return {sizeOfCloud(length),
            fmt::format("it reaches {:.3g} m, a mean of width and height", length)};
  }
  return {sizeOf(length, kTownRange_m, kRoomRange_m),
          fmt::format("most of what is seen is within {:.3g} m", length)};
}

}  // namespace

MeasuredSize measureSize(const std::vector<const FrameSource*>& recordings) {
  std::size_t total = 0;
  for (const FrameSource* source : recordings) {
    if (source == nullptr) throw UsageError("a recording to be measured is null");
    total += source->size();
  }
  const std::size_t step = std::max<std::size_t>(1, total / kFrames);
  std::vector<double> lengths;
  std::size_t before = 0;  // frames of earlier recordings
  for (const FrameSource* source : recordings) {
    for (std::size_t i = (step - before % step) % step; i < source->size(); i += step) {
      const double length = lengthOf(source->asMeasured().read(i));
      if (length > 0) lengths.push_back(length);
    }
    before += source->size();
  }
  return measured(lengths, recordings.empty() ? Sensor::cloud : recordings[0]->sensor());
}

MeasuredSize measureSize(const Frame& frame) {
  const double length = lengthOf(frame);
  return measured(length > 0 ? std::vector<double>{length} : std::vector<double>{}, frame.sensor);
}

/// The mean, in ratios, of the distance to the nearest vertex and of the width of the whole.
MeasuredSize measureSize(const SemanticGraph& graph) {
  const std::size_t step = 1 + graph.size() / 300;
  std::vector<double> nearest, along[3];
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) along[axis].push_back(graph.vertices[i].position[axis]);
    if (i % step != 0) continue;
    double least = INFINITY;
    for (std::size_t j = 0; j < graph.size(); ++j) {
      const double d = (graph.vertices[i].position - graph.vertices[j].position).norm();
      if (j != i && d > 0) least = std::min(least, d);
    }
    if (std::isfinite(least)) nearest.push_back(least);
  }
  if (nearest.empty()) return {kTownScale, "nothing to measure"};
  const double spacing = medianOf(std::move(nearest));
  double width = 0;
  for (auto& values : along) width = std::max(width, spreadOf(std::move(values)));
  return {sizeOf(std::sqrt(spacing * std::max(spacing, width)), kTownGraph_m, kRoomGraph_m),
          fmt::format("things are {:.3g} m apart over {:.3g} m", spacing, width)};
}

}  // namespace xview
