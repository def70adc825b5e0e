// SPDX-License-Identifier: BSD-3-Clause
// 04_raw_clouds MAP.pcd CLOUD.pcd: one cloud in another, both without labels; z is up in both.
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <xview/xview.h>

#include <iostream>
#include <string>

pcl::PointCloud<pcl::PointXYZ> read(const std::string& path) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  if (pcl::io::loadPCDFile(path, cloud) != 0) throw xview::Error(path, "cannot be read");
  return cloud;
}

int main(int argc, char** argv) try {
  if (argc != 3) return std::cerr << "04_raw_clouds MAP.pcd CLOUD.pcd\n", 2;
  const xview::Localizer localizer(xview::buildMap(read(argv[1])));
  const xview::Localization fix = localizer.localize(read(argv[2]));
  std::cout << toString(fix.status) << ": " << fix.reason << "\n";
  if (fix.accepted()) std::cout << fix.T_map_query.matrix() << "\n";
  return fix.accepted() ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
