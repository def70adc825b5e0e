// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "lifting.h"

namespace xview {

/// Which columns the points of a frame have besides place and label.
struct Columns {
  bool instances, ranges;
  explicit Columns(const Frame& frame);
};

/// A cloud that grows row by row.
class CloudOfRows : public PointSink {
 public:
  CloudOfRows(const Columns& columns, const Eigen::Vector3d& origin);

  void reserve(std::size_t points);
  void add(const PointRow& row) override;
  void addPoint(const PointRow& row, std::size_t i);
  LabelledCloud finish();

 private:
  Columns columns_;
  LabelledCloud cloud_;
};

}  // namespace xview
