// SPDX-License-Identifier: BSD-3-Clause
#include <pcl/point_types.h>
#include <xview/xview.h>

#include <iostream>
#include <string>

static_assert(XVIEW_VERSION_MAJOR * 100 + XVIEW_VERSION_MINOR >= 2, "the version is told");

/// consumer MAP.xvm: the example of the README, with an empty cloud.
int main(int argc, char** argv) {
  if (argc != 2) return std::string(XVIEW_VERSION_STRING).empty() ? 1 : 2;
  const pcl::PointCloud<pcl::PointXYZ> cloud;
  const xview::Localizer localizer(xview::map::unpacked(xview::map::openMap(argv[1])));
  const xview::Localization fix = localizer.localize(cloud);
  if (fix.accepted())
    std::cout << fix.T_map_query.matrix() << "\n";  // p_map = T_map_query * p_query
  else
    std::cout << fix.reason << "\n";
}
