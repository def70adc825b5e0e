// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/labelled_cloud.h"

#include <ostream>
#include <utility>
#include <vector>

#include "base/median.h"

namespace xview {

std::ostream& operator<<(std::ostream& out, const Point& point) {
  return out << '(' << point.x << ',' << point.y << ',' << point.z << " - " << point.label << ')';
}

double LabelledCloud::typicalSigma() const {
  std::vector<float> sigmas;
  sigmas.reserve(size());
  for (const Point& p : points) sigmas.push_back(p.sigma);
  return sigmas.empty() ? 0.0 : medianOf(std::move(sigmas));
}

}  // namespace xview
