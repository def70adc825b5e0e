// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "lifting.h"

namespace xview {

/// A cloud that grows row by row.
class CloudOfRows : public PointSink {
 public:
  explicit CloudOfRows(const Eigen::Vector3d& origin);

  void reserve(std::size_t points);
  void add(const PointRow& row) override;
  void addPoint(const PointRow& row, std::size_t i);
  LabelledCloud finish();

 private:
  LabelledCloud cloud_;
};

}  // namespace xview
