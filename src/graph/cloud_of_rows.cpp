// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_of_rows.h"

#include <utility>

namespace xview {

namespace {

Point pointOf(const PointRow& row, std::size_t i) {
  Point point(row.x[i], row.y[i], row.z[i], row.label[i]);
  point.instance = row.instance[i];
  return point;
}

}  // namespace

CloudOfRows::CloudOfRows(const Eigen::Vector3d& origin) { cloud_.origin = origin; }

void CloudOfRows::reserve(std::size_t points) { cloud_.points.points.reserve(points); }

void CloudOfRows::add(const PointRow& row) {
  for (std::size_t i = 0; i < row.size; ++i) addPoint(row, i);
}

void CloudOfRows::addPoint(const PointRow& row, std::size_t i) {
  cloud_.points.points.push_back(pointOf(row, i));
}

LabelledCloud CloudOfRows::finish() {
  cloud_.points.width = static_cast<std::uint32_t>(cloud_.points.points.size());
  cloud_.points.height = 1;
  cloud_.points.is_dense = true;
  return std::move(cloud_);
}

}  // namespace xview
