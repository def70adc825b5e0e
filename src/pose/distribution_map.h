// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/stored_cloud.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/base/semantic_place.h"

namespace xview::pose {

struct RefineOptions;

constexpr std::uint32_t kNoGroup = 0xFFFFFFFF;

/// Points match within a group: a kind of object, or one class if its kind is not known. Lane
/// markings lie on the road. kNoGroup for what moves and what is ignored.
std::uint32_t matchingGroup(const LabelSet& labels, std::uint32_t label);
/// Kind of a group; none for a class of its own.
Kind kindOfGroup(std::uint32_t group);

/// The points of one group in one cell.
struct Distribution {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();         ///< relative to the map's origin
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();  ///< more than an even cell has [1/m^2]
  Eigen::Vector3f view = Eigen::Vector3f::Zero();  ///< unit vector to who saw it; zero if unknown
};

/// Of large maps some cells are asked, spread evenly.
SurfaceNoise measureNoise(const LabelledCloud& map, const LabelSet& labels,
                          const RefineOptions& options);

/// What a DistributionMap is made of. The clouds must outlive it.
struct MapPoints {
  const LabelledCloud& cloud;
  const LabelSet& labels;
  /// T_map_sensor that the map was seen from; they tell which side of a thing it knows. May be
  /// empty.
  const std::vector<Eigen::Isometry3d>& viewpoints;
  const StoredCloud* stored = nullptr;  ///< further points, relative to the origin of `cloud`
  std::optional<SurfaceNoise> noise{};  ///< measured anew if there is none for the cells
};

/// The points of a map as normal distributions per cell and class (Magnusson 2009), of static
/// classes only. Along a surface that runs through its cell the mean of the cell is no landmark:
/// what an evenly filled cell would say is taken off.
///
/// They are made tile by tile where they are asked for. What a tile holds depends on the map alone,
/// so neither the order of the questions nor threads change an answer.
class DistributionMap {
 public:
  DistributionMap(const MapPoints& map, const RefineOptions& options);
  /// The same with a cloud of its own.
  DistributionMap(LabelledCloud&& map, const LabelSet& labels,
                  const std::vector<Eigen::Isometry3d>& viewpoints, const RefineOptions& options);
  ~DistributionMap();
  DistributionMap(DistributionMap&&) noexcept;

  const Eigen::Vector3d& origin() const;
  /// The nearest distribution of the group in the cell of p (relative to the origin) and the 26
  /// around it, within the gate; null if there is none.
  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate_m) const;
  /// The answer to the question before it, for a point that moves little from one to the next.
  struct Nearest {
    const Distribution* is = nullptr;
    Eigen::Vector3f from = Eigen::Vector3f::Constant(NAN);  ///< where the point was
    float others_m = 0;  ///< no other one was nearer, up to the gate
  };
  /// The same; cells are asked only if `last`, of this group, does not tell.
  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate_m,
                              Nearest& last) const;
  /// True if there is anything of any group in the cell of p or one beside it.
  bool holdsAnything(const Eigen::Vector3f& p) const;
  /// Calls visit(distribution, group) for all around, at least as far as the radius in plan.
  void forAround(const Eigen::Vector3d& centre, double radius_m,
                 const std::function<void(const Distribution&, std::uint32_t)>& visit) const;
  double noise_m() const;    ///< common error of the points of one view of a surface
  std::size_t size() const;  ///< makes all of them

 private:
  class Tiles;
  std::unique_ptr<const LabelledCloud> kept_;  ///< null: somebody else's
  std::unique_ptr<const Tiles> tiles_;
};

}  // namespace xview::pose
