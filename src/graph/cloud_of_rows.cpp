// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_of_rows.h"

#include <utility>

namespace xview {

Columns::Columns(const Frame& frame)
    : instances(frame.sensor == Sensor::camera
                    ? !frame.instance.empty()
                    : frame.cloud.instances.size() == frame.cloud.size()),
      ranges(frame.sensor != Sensor::cloud || frame.cloud.ranges.size() == frame.cloud.size()) {}

CloudOfRows::CloudOfRows(const Columns& columns, const Eigen::Vector3d& origin)
    : columns_(columns) {
  cloud_.origin = origin;
}

void CloudOfRows::reserve(std::size_t points) {
  cloud_.points.points.reserve(points);
  if (columns_.instances) cloud_.instances.reserve(points);
  if (columns_.ranges) cloud_.ranges.reserve(points);
}

void CloudOfRows::add(const PointRow& row) {
  const std::size_t first = cloud_.size();
  cloud_.points.points.resize(first + row.size);
  for (std::size_t i = 0; i < row.size; ++i)
    cloud_.points.points[first + i] = {row.x[i], row.y[i], row.z[i], row.label[i]};
  const auto end = static_cast<std::ptrdiff_t>(row.size);
  if (columns_.instances)
    cloud_.instances.insert(cloud_.instances.end(), row.instance.begin(),
                            row.instance.begin() + end);
  if (columns_.ranges)
    cloud_.ranges.insert(cloud_.ranges.end(), row.range.begin(), row.range.begin() + end);
}

void CloudOfRows::addPoint(const PointRow& row, std::size_t i) {
  cloud_.points.points.emplace_back(row.x[i], row.y[i], row.z[i], row.label[i]);
  if (columns_.instances) cloud_.instances.push_back(row.instance[i]);
  if (columns_.ranges) cloud_.ranges.push_back(row.range[i]);
}

LabelledCloud CloudOfRows::finish() {
  cloud_.points.width = static_cast<std::uint32_t>(cloud_.points.points.size());
  cloud_.points.height = 1;
  cloud_.points.is_dense = true;
  return std::move(cloud_);
}

}  // namespace xview
