// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xview/base/bev_grid.h"
#include "xview/base/frame.h"
#include "xview/base/graph.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/base/localization.h"

namespace xview {

/// A step of an odometry that the scans at both its ends contradict.
struct OdometryJump {
  std::size_t position = 0;  ///< of the frame behind it, in the recording or query
  std::int64_t frame = 0;    ///< number of that frame
  double off_m = 0;  ///< from where the scans put that frame, about; as far as one sees if that is
                     ///< elsewhere
};

/// What is known of a piece of world, in one frame. A query is a place in the frame of its
/// odometry, a map is one with sources and a file; what was not seen, or is not told, is empty. All
/// parts of single precision carry their origin in double.
struct Place {
  LabelSet labels;
  SemanticGraph graph;  ///< the paper's graph: objects and pieces of surface
  BevGrid bev;  ///< bird's-eye view of surfaces and objects; empty for bare graphs, and where
                ///< the direction of gravity is unknown
  LabelledCloud cloud;  ///< for refinement and pictures; Point::view is a position in `poses`

  /// T_place_sensor of the frames that saw it, in order: all of a query, whose last one is answered
  /// (identity for a bare graph), or the key frames of a map.
  std::vector<Eigen::Isometry3d> poses;
  std::vector<std::int64_t> frames;  ///< their numbers; empty if there were no frames
  std::vector<double> stamps_s;      ///< and times [s]
  /// Where the odometry of a query jumps, in order. The query begins behind the last jump: nothing
  /// else of it, poses included, is of earlier frames.
  std::vector<OdometryJump> jumps;
  /// The last frame of a query of several by itself, or its frames behind a step of the odometry
  /// that the scans do not tell, which its pose must fit as well.
  std::shared_ptr<const Place> newest;

  Sensor sensor = Sensor::cloud;  ///< that saw it last
  double size = 1;                ///< scale: its lengths over canonical ones; see kTownScale
  Gravity gravity;                ///< which way is up
  Timings timing_ms;              ///< what making it took: read, lift, blobs, graph
};

namespace search {

/// Classes of the distance from a query sample to the nearest map sample of its channel.
constexpr int kDistanceBins = 9;

/// Per channel, how the distance classes are distributed at wrong poses in one map.
using MapNull = std::array<std::array<double, kDistanceBins>, kBevChannels>;

/// The same of a map that grows: counted along the first poses of its path, for one view of it.
struct PathNull {
  MapNull counts{};
  std::size_t poses = 0;
  std::uint64_t view = 0;  ///< tells other views by how many samples of each channel they have
};

}  // namespace search

namespace pose {

/// Thickness of the surfaces of a map in cells of `cell_m`: the noise of the sensor that made it,
/// which is taken for that of a query as well.
struct SurfaceNoise {
  double cell_m = 0;
  double thickness_m = 0;
  bool is_sparse = false;  ///< most points lie in cells with too few for a distribution
};

}  // namespace pose

// All lengths that stages compare with (cells, voxels, radii, tolerances) are canonical: those of a
// town in metres. A place of another size is brought to canonical scale before any stage reads it,
// and the answer is brought back, so every length follows, also the precision of points. Scales are
// powers of two, which changes no digit of a number.

constexpr double kTownScale = 1, kRoomScale = 1. / 4, kDeskScale = 1. / 16;

/// Scale of a place (lengths over canonical ones) for options.size; none for auto.
std::optional<double> parseSize(const std::string& text);
/// The word, or the typical spacing of neighbouring objects [m]: parseSize() reads it back.
std::string sizeText(double size);
void requireSize(const std::string& name, const std::string& text);

/// Every length times `factor`, about the origin of the frame.
void scaleLengths(double factor, SemanticGraph& graph);
void scaleLengths(double factor, LabelledCloud& cloud);
void scaleLengths(double factor, BevGrid& bev);
void scaleLengths(double factor, Place& place);
void scaleLengths(double factor, Frame& frame);
void scaleLengths(double factor, Localization& answer);
void scaleLengths(double factor, Eigen::Isometry3d& T);

/// A value as given, or a changed copy of it. The given one must outlive this.
template <class Value>
class CopyOnChange {
 public:
  CopyOnChange(const CopyOnChange&) = delete;
  CopyOnChange& operator=(const CopyOnChange&) = delete;
  const Value& operator*() const { return changed_ ? *changed_ : given_; }
  const Value* operator->() const { return &**this; }

 protected:
  explicit CopyOnChange(const Value& given) : given_(given) {}

  const Value& given_;
  std::optional<Value> changed_;
};

/// The same value with all lengths multiplied; copied only if the factor is not 1.
template <class Value>
struct Scaled : CopyOnChange<Value> {
  Scaled(const Value& given, double factor) : CopyOnChange<Value>(given) {
    if (factor != 1) scaleLengths(factor, this->changed_.emplace(given));
  }
};

}  // namespace xview
