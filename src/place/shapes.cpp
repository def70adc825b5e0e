// SPDX-License-Identifier: BSD-3-Clause
#include "place/shapes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/cells.h"
#include "base/median.h"
#include "place/ground_field.h"
#include "xview/base/budget.h"

namespace xview {
namespace {

/// Sums over points that give their mean and covariance.
struct PointSums {
  double count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();  ///< xx xy xz yy yz zz

  void add(const Eigen::Vector3d& p) {
    count += 1;
    sum += p;
    squares[0] += p.x() * p.x(), squares[1] += p.x() * p.y(), squares[2] += p.x() * p.z();
    squares[3] += p.y() * p.y(), squares[4] += p.y() * p.z(), squares[5] += p.z() * p.z();
  }
  void add(const PointSums& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
};

/// How the points around a place are spread: the eigenvalues of their covariance.
struct Spread {
  float linear = 0, planar = 0;  ///< shares of the largest deviation that only one, or two, have
  float thickness_m2 = 0;        ///< the least variance
  float normal_z = 0;            ///< of the direction with the least spread, absolute
  float axis_z = 0;              ///< of the direction with the greatest spread, absolute
};

Spread spreadOf(const PointSums& sums) {
  const Eigen::Vector3d mean = sums.sum / sums.count;
  const Eigen::Matrix<double, 6, 1> s = sums.squares / sums.count;
  Eigen::Matrix3d covariance;
  covariance << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  covariance -= mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;
  axes.computeDirect(covariance.cast<float>());
  const Eigen::Vector3f l = axes.eigenvalues().cwiseMax(0);
  const float largest = l[2] + 1e-9F;
  return {(l[2] - l[1]) / largest, (l[1] - l[0]) / largest, l[0],
          std::abs(axes.eigenvectors()(2, 0)), std::abs(axes.eigenvectors()(2, 2))};
}

/// Points in voxels of several sides, each twice the one before.
class ShapeVoxels {
 public:
  static constexpr int kLevels = 5;

  explicit ShapeVoxels(double finest_m) : finest_m_(finest_m) {}

  /// Number of the finest voxel of a point.
  std::size_t add(const Eigen::Vector3d& p) {
    const double scale = 1 / finest_m_;
    const ClassCell key{floorToInt(p.x() * scale), floorToInt(p.y() * scale),
                        floorToInt(p.z() * scale)};
    const std::size_t voxel = levels_[0].numberOf(key, [&] { return Neighbourhood{key}; });
    levels_[0][voxel].sums.add(p);
    return voxel;
  }

  /// All points are there.
  void finish() {
    for (int level = 1; level < kLevels; ++level) {
      auto &fine = levels_[level - 1], &coarse = levels_[level];
      for (std::size_t i = 0; i < fine.size(); ++i) {
        const ClassCell& part = fine[i].key;
        const ClassCell key{part.x >> 1, part.y >> 1, part.z >> 1};
        const std::size_t parent = coarse.numberOf(key, [&] { return Neighbourhood{key}; });
        fine[i].parent = static_cast<std::int32_t>(parent);
        coarse[parent].sums.add(fine[i].sums);
      }
    }
  }

  std::size_t size() const { return levels_[0].size(); }
  ClassCell key(std::size_t voxel) const { return levels_[0][voxel].key; }
  const PointSums& points(std::size_t voxel) const { return levels_[0][voxel].sums; }
  std::int32_t find(const ClassCell& key) const { return levels_[0].find(key); }  ///< or -1

  /// The sums over the 27 voxels around one at a level.
  struct Neighbourhood {
    ClassCell key;
    PointSums sums{};
    std::optional<Spread> spread{};  ///< once somebody has asked for it
    std::int32_t parent = -1;
    bool is_summed = false;
    int filled = 0;  ///< voxels of the 27 that hold points
    PointSums around{};
  };
  /// Of the voxel at a level that holds this finest one.
  Neighbourhood& around(std::size_t voxel, int level) {
    std::size_t number = voxel;
    for (int l = 0; l < level; ++l) number = static_cast<std::size_t>(levels_[l][number].parent);
    const auto& table = levels_[level];
    Neighbourhood& here = levels_[level][number];
    if (here.is_summed) return here;
    here.is_summed = true;
    for (int i = 0; i < 27; ++i) {
      const std::int32_t j = table.find(here.key.neighbour(i));
      if (j < 0) continue;
      ++here.filled;
      here.around.add(table[static_cast<std::size_t>(j)].sums);
    }
    return here;
  }

 private:
  double finest_m_;
  std::array<CellTable<Neighbourhood>, kLevels> levels_;
};

constexpr double kVoxel_m = 0.3;
constexpr float kOnGround_m = 0.25F;                         ///< what is lower is ground
constexpr std::array<double, 3> kFewestPoints = {12, 8, 5};  ///< that tell a shape, by level
constexpr int kTelling = kFewestPoints.size();               ///< levels that tell one by themselves
constexpr float kPlanar = 0.4F, kUpright = 0.25F;            ///< a wall: its normal is nearly level
constexpr float kLinear = 0.7F, kPlumb = 0.85F;              ///< a post: its axis is nearly plumb
constexpr float kFlat = 0.6F, kLevel = 0.85F;  ///< a roof or table: its normal is nearly plumb
constexpr float kOverhead_m = 1.9F;            ///< what is higher is none that one works at
constexpr float kAlone = 0.5F;                 ///< linear for a post seen from farther
constexpr float kBeam = 0.7F;                  ///< one beam over a wall is a level line
/// Variance across a scattered wall, over that at half the distance; that of a crown is four times.
constexpr float kThicker = 2;
/// Voxels of 27 that are filled around the median one: 4 to 12 where points hardly err, 14 to 18 of
/// stereo cameras.
constexpr float kScattered = 14;

struct Voxel {
  float height_m = 0;  ///< of its points above the ground
  Shape shape = Shape::foliage;
};

/// One scan line over a surface tells no more than its direction.
bool isOneBeam(const Spread& spread) { return spread.linear > kBeam && spread.axis_z < 0.5F; }

bool isWall(const Spread& spread) { return spread.planar > kPlanar && spread.normal_z < kUpright; }

Shape shapeOf(const Spread& spread, float height_m, bool ground_below) {
  if (isWall(spread)) return Shape::wall;
  if (spread.linear > kLinear && spread.axis_z > kPlumb) return Shape::post;
  if (spread.planar > kFlat && spread.normal_z > kLevel) {
    if (height_m < kOverhead_m) return Shape::table;
    return ground_below ? Shape::ceiling : Shape::roof;
  }
  return Shape::foliage;
}

/// Labels in progress: what stands on the ground, in voxels.
class Standing {
 public:
  Standing(const pcl::PointCloud<Point>& points, const GroundField& ground, double size)
      : voxels_(kVoxel_m * std::max(size, kRoomScale)) {
    std::vector<float> heights;
    voxel_of_.assign(points.size(), kOnGround);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      const float height = p.z - ground.heightAt(p.x, p.y);
      if (height < kOnGround_m) continue;
      const std::size_t v = voxels_.add(p.getVector3fMap().cast<double>());
      if (v == heights.size()) heights.push_back(0);
      heights[v] += height;
      voxel_of_[i] = static_cast<std::int32_t>(v);
    }
    voxels_.finish();
    is_scattered_ = isScattered(points);
    found_.resize(voxels_.size());
    for (std::size_t v = 0; v < found_.size(); ++v) {
      const PointSums& sums = voxels_.points(v);
      found_[v].height_m = heights[v] / static_cast<float>(sums.count);
      const Eigen::Vector3d mean = sums.sum / sums.count;
      const bool ground_below =
          ground.isSeenAt(static_cast<float>(mean.x()), static_cast<float>(mean.y()));
      found_[v].shape = judge(v, ground_below);
    }
    smooth();
    if (size == kTownScale) findLowObjects();
  }

  Shape of(std::size_t point) const {
    return voxel_of_[point] < 0 ? Shape::ground : found_[voxel_of_[point]].shape;
  }

 private:
  static constexpr std::int32_t kOnGround = -1;

  const Spread& spreadAround(std::size_t voxel, int level) {
    ShapeVoxels::Neighbourhood& here = voxels_.around(voxel, level);
    if (!here.spread) here.spread = spreadOf(here.around);
    return *here.spread;
  }

  /// A column of a scan over a surface is as plumb as a post, but has others beside it.
  bool standsAlone(std::size_t voxel, int level) {
    if (level + 1 == kTelling) return true;
    const Spread& wide = spreadAround(voxel, level + 1);
    return wide.linear > kAlone && wide.axis_z > kPlumb;
  }

  /// Whether points err by more than a voxel and nothing says by how much: a plane fills 9 of 27.
  bool isScattered(const pcl::PointCloud<Point>& points) {
    if (std::any_of(points.begin(), points.end(), [](const Point& p) { return p.sigma != 0; }))
      return false;
    std::vector<float> filled;
    for (std::size_t v = 0; v < voxels_.size(); ++v)
      filled.push_back(static_cast<float>(voxels_.around(v, 0).filled));
    return !filled.empty() && medianOf(std::move(filled)) >= kScattered;
  }

  /// What is scattered near by may be a wall whose points err: farther around it is flat and hardly
  /// thicker.
  bool isScatteredWall(std::size_t voxel, int level) {
    float thickness_m2 = spreadAround(voxel, level).thickness_m2;
    while (++level < ShapeVoxels::kLevels) {
      const Spread& wide = spreadAround(voxel, level);
      if (isWall(wide) && wide.thickness_m2 < kThicker * thickness_m2) return true;
      thickness_m2 = wide.thickness_m2;
    }
    return false;
  }

  /// By the smallest neighbourhood that tells.
  Shape judge(std::size_t voxel, bool ground_below) {
    for (int level = 0; level < kTelling; ++level) {
      if (voxels_.around(voxel, level).around.count < kFewestPoints[level]) continue;
      const Spread& spread = spreadAround(voxel, level);
      if (isOneBeam(spread)) continue;
      const Shape shape = shapeOf(spread, found_[voxel].height_m, ground_below);
      if (shape == Shape::post && !standsAlone(voxel, level)) continue;
      return is_scattered_ && shape == Shape::foliage && isScatteredWall(voxel, level) ? Shape::wall
                                                                                       : shape;
    }
    return Shape::foliage;
  }

  /// What most points around say, but posts, which are thin, stay.
  void smooth() {
    std::vector<Shape> smoothed(found_.size());
    for (std::size_t v = 0; v < found_.size(); ++v) {
      smoothed[v] = found_[v].shape;
      if (smoothed[v] == Shape::post) continue;
      std::array<double, kShapeCount> votes{};
      for (int i = 0; i < 27; ++i) {
        const std::int32_t j = voxels_.find(voxels_.key(v).neighbour(i));
        if (j < 0) continue;
        const auto other = static_cast<std::size_t>(j);
        votes[static_cast<std::size_t>(found_[other].shape)] += voxels_.points(other).count;
      }
      const auto own = static_cast<std::size_t>(smoothed[v]);
      const auto most = std::max_element(votes.begin(), votes.end());
      if (*most > votes[own]) smoothed[v] = static_cast<Shape>(most - votes.begin());
    }
    for (std::size_t v = 0; v < found_.size(); ++v) found_[v].shape = smoothed[v];
  }

  void findLowObjects();

  ShapeVoxels voxels_;
  bool is_scattered_ = false;
  std::vector<Voxel> found_;
  std::vector<std::int32_t> voxel_of_;  ///< of each point
};

constexpr double kPieceColumn_m = 0.5;
constexpr float kLowest_m = 0.9F, kHighest_m = 2.3F;    ///< top of a vehicle
constexpr double kSmallest_m2 = 1.5, kLargest_m2 = 14;  ///< of what is seen of it from above
constexpr double kLongest_m = 8;  ///< a wall may be as low, as far as a scanner sees it up

/// Columns that touch one another, as low, as large and as long as a vehicle.
void Standing::findLowObjects() {
  CellIndex columns;
  std::vector<float> tops;
  std::vector<std::int32_t> column_of(found_.size());
  for (std::size_t v = 0; v < found_.size(); ++v) {
    const Eigen::Vector3d mean = voxels_.points(v).sum / voxels_.points(v).count;
    column_of[v] = columns.findOrAdd(floorToInt(mean.x() / kPieceColumn_m),
                                     floorToInt(mean.y() / kPieceColumn_m));
    if (static_cast<std::size_t>(column_of[v]) == tops.size()) tops.push_back(0);
    tops[column_of[v]] = std::max(tops[column_of[v]], found_[v].height_m);
  }
  std::vector<std::uint8_t> is_low(columns.size(), 0);
  for (const auto& piece : connectedCells(columns, [](std::int32_t) { return true; })) {
    float top = 0;
    Eigen::AlignedBox2i box;
    for (const std::int32_t c : piece) {
      const PlaneCell& cell = columns.cells()[static_cast<std::size_t>(c)];
      top = std::max(top, tops[c]);
      box.extend(Eigen::Vector2i(cell.x, cell.y));
    }
    const double area = static_cast<double>(piece.size()) * kPieceColumn_m * kPieceColumn_m;
    const double length_m = kPieceColumn_m * box.sizes().cast<double>().norm();
    if (top < kLowest_m || top > kHighest_m || area < kSmallest_m2 || area > kLargest_m2 ||
        length_m > kLongest_m)
      continue;
    for (const std::int32_t c : piece) is_low[c] = 1;
  }
  for (std::size_t v = 0; v < found_.size(); ++v) {
    if (is_low[column_of[v]]) found_[v].shape = Shape::low_thing;
  }
}

}  // namespace

LabelSet labelsOfShapes() {
  const auto id = [](Shape shape) { return static_cast<std::uint32_t>(shape); };
  const ClassInfo classes[kShapeCount] = {
      {id(Shape::none), "unlabelled", {0, 0, 0}, Role::ignored, Kind::none},
      {id(Shape::ground), "ground", {150, 120, 150}, Role::surface, Kind::road},
      {id(Shape::wall), "wall", {240, 190, 60}, Role::surface, Kind::building},
      {id(Shape::post), "post", {220, 40, 40}, Role::object, Kind::pole},
      {id(Shape::foliage), "foliage", {60, 160, 60}, Role::surface, Kind::vegetation},
      {id(Shape::low_thing), "low thing", {90, 140, 230}, Role::dynamic, Kind::vehicle},
      {id(Shape::roof), "roof", {170, 90, 40}, Role::surface, Kind::building},
      {id(Shape::ceiling), "ceiling", {200, 200, 200}, Role::surface, Kind::other_surface},
      {id(Shape::table), "table", {150, 90, 210}, Role::surface, Kind::other_surface}};
  LabelSet labels("shapes");
  for (const ClassInfo& info : classes) labels.add(info);
  return labels;
}

void labelByShape(pcl::PointCloud<Point>& points, double size) {
  if (points.empty()) return;
  askBudget("the classes from shapes");
  const GroundField ground(points);
  askBudget("the classes from shapes");
  const Standing standing(points, ground, size);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i].label = static_cast<std::uint32_t>(standing.of(i));
}

}  // namespace xview
