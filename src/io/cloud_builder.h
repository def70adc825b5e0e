// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "row_reader.h"
#include "xview/types/labelled_cloud.h"

namespace xview {

/// Collects points that arrive in double precision. The first finite coordinate beyond `far_m`
/// makes that point, rounded down to metres, the origin of the cloud.
class CloudBuilder {
 public:
  explicit CloudBuilder(double far_m) : far_m_(far_m) {}

  void reserve(std::size_t points);
  /// Throws Error, at `place`, for a finite coordinate that no place in the world has.
  void add(const Eigen::Vector3d& position, std::uint32_t label, std::uint32_t instance,
           const RowPlace& place);
  /// The beam of the point that was added last. A number that is none makes all of them unknown.
  void addRing(double ring);
  LabelledCloud finish();
  /// One per point, or empty.
  std::vector<std::uint16_t> rings() const;

  /// float32 coordinates are kept as they are.
  static constexpr double kNever = std::numeric_limits<double>::infinity();

 private:
  void setOrigin(const Eigen::Vector3d& position);

  double far_m_;
  bool has_wrong_ring_ = false;
  bool has_origin_ = false;
  LabelledCloud cloud_;
  std::vector<std::uint16_t> rings_;
};

}  // namespace xview
