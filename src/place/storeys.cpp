// SPDX-License-Identifier: BSD-3-Clause
#include "place/storeys.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/cells.h"
#include "place/bev_grid.h"
#include "place/merge.h"
#include "place/point_quality.h"

namespace xview {
namespace {

// In metres of the world: people are as high in any place.
constexpr double kPathSquare_m = 4;       ///< of the squares in which poses lie above one another
constexpr double kLevelBin_m = 0.25;      ///< of heights of poses
constexpr double kLeastOfPoses = 0.02;    ///< of the poses that a storey has, at least
constexpr double kHighestSensor_m = 3;    ///< above the floor of its storey
constexpr double kLowestSensor_m = -0.4;  ///< the same: floors lean, and heights are in bins
constexpr double kLeastFloor = 0.2;       ///< ground of a storey over that of any other
constexpr double kThickestSlab_m = 0.6;   ///< from a ceiling to the floor above, at most
// Canonical.
constexpr double kVoteCell_m = 0.4;  ///< side of the cells whose neighbours vote for a class
constexpr float kPointsOfVoxel = 4;  ///< that a thinned point stands for, as far as views count

/// Whether one walks over where one has walked before in many places.
bool isStacked(const std::vector<Eigen::Vector3d>& path, double per_metre) {
  std::map<std::pair<long, long>, std::vector<double>> squares;
  const double side = kPathSquare_m * per_metre;
  for (const Eigen::Vector3d& p : path)
    squares[{std::lround(p.x() / side), std::lround(p.y() / side)}].push_back(p.z());
  const auto hasTwo = [&](auto& square) {
    std::vector<double>& z = square.second;
    std::sort(z.begin(), z.end());
    return std::adjacent_find(z.begin(), z.end(), [&](double low, double high) {
             return high - low >= kLowestStorey_m * per_metre;
           }) != z.end();
  };
  const auto stacked = std::count_if(squares.begin(), squares.end(), hasTwo);
  return static_cast<double>(stacked) >= kStackedShare * static_cast<double>(squares.size());
}

/// What points count in a view: by the share of their class among all points around, squared. A
/// class that a network says now and then is everywhere, but prevails nowhere.
std::vector<float> weightsOf(const LabelledCloud& cloud) {
  struct Count {
    ClassCell key;
    float points = 0, weight = 0;
  };
  CellTable<Count> of_class, of_all;
  const auto add = [](const ClassCell& cell, CellTable<Count>& counts) {
    const std::size_t number = counts.numberOf(cell, [&] { return Count{cell}; });
    ++counts[number].points;
    return number;
  };
  const auto around = [](const ClassCell& cell, const CellTable<Count>& counts) {
    float sum = 0;
    for (int i = 0; i < 27; ++i) {
      const std::int32_t number = counts.find(cell.neighbour(i));
      if (number >= 0) sum += counts[static_cast<std::size_t>(number)].points;
    }
    return sum;
  };
  std::vector<std::size_t> number_of;
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d p = point.getVector3fMap().cast<double>();
    number_of.push_back(add(cellOf(p, kVoteCell_m, point.label), of_class));
    add(cellOf(p, kVoteCell_m, 0), of_all);
  }
  for (Count& count : of_class.entries()) {
    ClassCell all = count.key;
    all.label = 0;
    const float share = around(count.key, of_class) / around(all, of_all);
    count.weight = kPointsOfVoxel * share * share;
  }
  std::vector<float> weights;
  for (const std::size_t number : number_of) weights.push_back(of_class[number].weight);
  return weights;
}

std::vector<Eigen::Vector3d> uprightPath(const std::vector<Eigen::Isometry3d>& poses,
                                         const Eigen::Quaterniond& upright) {
  std::vector<Eigen::Vector3d> path;
  for (const Eigen::Isometry3d& T : poses) path.push_back(upright * T.translation());
  return path;
}

/// Heights at which many poses are, from below.
std::vector<double> levelsOf(const std::vector<Eigen::Vector3d>& path, double per_metre) {
  HeightCounts heights(kLevelBin_m * per_metre);
  for (const Eigen::Vector3d& p : path) heights.add(p.z());
  std::vector<double> levels;
  for (const auto& [count, z] : heights.ranked()) {
    if (count < kLeastOfPoses * static_cast<double>(path.size())) break;
    const auto isNear = [&, height = z](double level) {
      return std::abs(level - height) < kLowestStorey_m * per_metre;
    };
    if (std::none_of(levels.begin(), levels.end(), isNear)) levels.push_back(z);
  }
  std::sort(levels.begin(), levels.end());
  return levels;
}

}  // namespace

StoreyFinder::StoreyFinder(const std::vector<Eigen::Isometry3d>& poses,
                           const Eigen::Quaterniond& upright, double size)
    : upright_(upright),
      per_metre_(1 / size),
      is_town_(size >= kTownScale),
      points_(kFloorBin_m * per_metre_),
      surfaces_(per_metre_) {
  const std::vector<Eigen::Vector3d> path = uprightPath(poses, upright);
  if (!is_town_ && path.size() > 1 && isStacked(path, per_metre_))
    levels_ = levelsOf(path, per_metre_);
  floors_.assign(levels_.size(), HeightCounts(kFloorBin_m * per_metre_));
}

void StoreyFinder::add(const LabelledCloud& cloud, const LabelSet& labels) {
  if (is_town_) return;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = upright_ * cloud.position(i);
    const double z = p.z();
    points_.add(z);
    if (levels_.size() < 2) surfaces_.add(p);
    const auto above =
        std::upper_bound(levels_.begin(), levels_.end(), z + kLowestSensor_m * per_metre_);
    if (above != levels_.end() && *above - z < kHighestSensor_m * per_metre_ &&
        isGround(labels.kind(cloud.points[i].label)))
      floors_[static_cast<std::size_t>(above - levels_.begin())].add(z);
  }
}

std::vector<double> StoreyFinder::floorsBelowPoses() const {
  std::size_t most = 0;
  for (const HeightCounts& floor : floors_) most = std::max(most, floor.size());
  std::vector<double> floors;
  for (const HeightCounts& floor : floors_) {
    if (static_cast<double>(floor.size()) > kLeastFloor * static_cast<double>(most))
      floors.push_back(floor.ranked()[0].second);
  }
  return floors;
}

std::vector<Storey> StoreyFinder::storeys() const {
  const std::vector<double> floors = levels_.size() < 2 ? surfaces_.heights() : floorsBelowPoses();
  if (floors.size() < 2) return {};
  constexpr double kEnd = std::numeric_limits<double>::infinity();
  std::vector<Storey> storeys{{-kEnd, kEnd}};
  for (std::size_t i = 1; i < floors.size(); ++i) {
    const double low = floors[i] - kThickestSlab_m * per_metre_;
    storeys.back().top = points_.emptiest(low, floors[i]);
    storeys.push_back({storeys.back().top, kEnd});
  }
  return storeys;
}

bool standOnSeveralFloors(const std::vector<Eigen::Isometry3d>& poses,
                          const Eigen::Quaterniond& upright) {
  return poses.size() > 1 && isStacked(uprightPath(poses, upright), 1);
}

LabelledCloud pointsIn(const Storey& storey, const LabelledCloud& cloud,
                       const Eigen::Quaterniond& upright) {
  LabelledCloud points;
  points.origin = cloud.origin;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (storey.holds((upright * cloud.position(i)).z())) points.points.push_back(cloud.points[i]);
  }
  return points;
}

std::vector<StoreyOfPlace> storeysOf(const Place& place) {
  if (!place.gravity.known || place.bev.aerial) return {};
  const Eigen::Quaterniond& upright = place.gravity.alignment;
  StoreyFinder finder(place.poses, upright, place.size);
  finder.add(place.cloud, place.labels);
  std::vector<StoreyOfPlace> storeys;
  for (const Storey& heights : finder.storeys()) {
    const LabelledCloud points = pointsIn(heights, place.cloud, upright);
    storeys.push_back({heights, viewOfThinned(points, place.labels, upright)});
  }
  return storeys;
}

void placeThinObjects(const std::vector<StoreyOfPlace>& storeys, Place& place) {
  std::vector<Vertex> placed;
  for (const StoreyOfPlace& storey : storeys) {
    SemanticGraph part;
    for (const Vertex& v : place.graph.vertices) {
      if (storey.heights.holds((place.gravity.alignment * v.position).z()))
        part.vertices.push_back(v);
    }
    placeThinObjects(part, storey.view, place.labels);
    placed.insert(placed.end(), part.vertices.begin(), part.vertices.end());
  }
  place.graph.vertices = std::move(placed);
  place.graph.neighbours.assign(place.graph.size(), {});
}

void dropContradicted(const std::vector<StoreyOfPlace>& storeys, Place& place) {
  pcl::PointCloud<Point> kept;
  for (const StoreyOfPlace& storey : storeys) {
    LabelledCloud points = pointsIn(storey.heights, place.cloud, place.gravity.alignment);
    dropContradicted(storey.view, place.labels, points);
    kept += points.points;
  }
  place.cloud.points = std::move(kept);
}

BevGrid viewOfThinned(const LabelledCloud& cloud, const LabelSet& labels,
                      const Eigen::Quaterniond& upright) {
  BevGridBuilder view(labels);
  view.add(cloud, weightsOf(cloud), {}, Eigen::Isometry3d(upright), false);
  BevGrid grid = view.build();
  grid.alignment = upright;
  return grid;
}

}  // namespace xview
