// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace xview {

/// Labelled points as columns, so that several are worked on at once: a row of an image or a piece
/// of a cloud.
struct PointRow {
  explicit PointRow(std::size_t capacity)
      : x(capacity),
        y(capacity),
        z(capacity),
        range(capacity),
        sigma(capacity),
        label(capacity),
        instance(capacity) {}

  std::size_t size = 0;  ///< points in use
  std::vector<float> x, y, z;
  std::vector<float> range;  ///< to the sensor [m], 0 if it is not known
  std::vector<float> sigma;  ///< of the position [m]
  std::vector<std::uint32_t> label, instance;
};

}  // namespace xview
