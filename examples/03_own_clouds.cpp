// SPDX-License-Identifier: BSD-3-Clause
// 03_own_clouds MAP.xvm CLOUD.pcd: a labelled cloud of your own driver, pcl::PointXYZL, whose
// classes are those of the map.
#include <pcl/common/io.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <xview/xview.h>

#include <iostream>
#include <string>

pcl::PointCloud<pcl::PointXYZL> read(const std::string& path) {
  pcl::PCLPointCloud2 file;
  if (pcl::io::loadPCDFile(path, file) != 0) throw xview::Error(path, "cannot be read");
  if (pcl::getFieldIndex(file, "label") < 0)
    throw xview::Error(path, "has no field label; 04_raw_clouds is for clouds without");
  pcl::PointCloud<pcl::PointXYZL> cloud;
  pcl::fromPCLPointCloud2(file, cloud);
  return cloud;
}

int main(int argc, char** argv) try {
  if (argc != 3) return std::cerr << "03_own_clouds MAP.xvm CLOUD.pcd\n", 2;
  const xview::Localizer localizer(xview::map::openMap(argv[1]));
  const xview::LabelSet& labels = localizer.labels();
  const xview::Localization fix = localizer.localize(read(argv[2]), labels);
  // Several scans of a drive, each in the frame of the sensor and with its pose:
  //   xview::CloudRecording scans(labels);
  //   scans.add(cloud, T_odom_sensor, stamp_s);  // for every scan
  //   const xview::Localization fix = localizer.localize(scans);
  std::cout << toString(fix.status) << ": " << fix.reason << "\n";
  if (fix.accepted()) std::cout << fix.T_map_query.matrix() << "\n";
  return fix.accepted() ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
