// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/thin_frame.h"

#include "cloud_of_rows.h"
#include "lifting.h"
#include "voxel_thinner.h"

namespace xview {
namespace {

/// Thins all points, and keeps those of some classes as they are.
class ThinningSink : public PointSink {
 public:
  ThinningSink(const Eigen::Vector3d& origin, double voxel_m, std::size_t expected,
               const LabelSet& set, WholeClasses whole)
      : thinner_(origin, voxel_m, expected), whole_(origin), set_(set), which_(whole) {}

  void add(const PointRow& row) override {
    thinner_.add(row);
    if (which_ == WholeClasses::all) whole_.add(row);
    if (which_ == WholeClasses::no_surfaces) addWithoutSurfaces(row);
    for (std::size_t i = 0; i < row.size; ++i) near_ += row.range[i] <= kAerialQuantile_m;
  }
  ThinFrame finish() {
    ThinFrame frame;
    frame.thin = thinner_.finish(&frame.points_per_voxel);
    frame.whole = whole_.finish();
    return frame;
  }
  std::size_t near() const { return near_; }

 private:
  void addWithoutSurfaces(const PointRow& row) {
    for (std::size_t i = 0; i < row.size; ++i) {
      if (row.label[i] != last_label_) {
        last_label_ = row.label[i];
        is_surface_ = set_.role(last_label_) == Role::surface;
      }
      if (!is_surface_) whole_.addPoint(row, i);
    }
  }

  VoxelThinner thinner_;
  CloudOfRows whole_;
  const LabelSet& set_;
  WholeClasses which_;
  std::size_t near_ = 0;  ///< points not further than kAerialQuantile_m
  std::uint32_t last_label_ = 0;
  bool is_surface_ = set_.role(0) == Role::surface;
};

}  // namespace

ThinFrame liftThin(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   double voxel_m, WholeClasses whole, LiftCounts* counts) {
  const LiftPlan plan = planOf(frame, options);
  ThinningSink sink(plan.origin, voxel_m, plan.expected, set, whole);
  const LiftCounts found = liftInto(sink, plan, frame, set);
  ThinFrame result = sink.finish();
  result.is_aerial =
      frame.sensor == Sensor::camera && found.lifted > 0 && 10 * sink.near() < found.lifted;
  if (counts) *counts = found;
  return result;
}

}  // namespace xview
