// SPDX-License-Identifier: BSD-3-Clause
// 03_own_clouds MAP.xvm CLOUD.pcd: labelled clouds of your own driver. Here they come from a file
// of PCL's pcl::PointXYZL; a callback of a driver would fill the frames in the same way.
#include <pcl/common/point_tests.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <xview/xview.h>

#include <iostream>

namespace {

/// One scan: points in the frame of the sensor, and where odometry has the sensor.
xview::Frame frameOf(const pcl::PointCloud<pcl::PointXYZL>& cloud,
                     const Eigen::Isometry3d& T_odom_sensor, std::int64_t number) {
  xview::Frame frame;
  frame.number = number;
  frame.sensor = xview::Sensor::lidar;
  frame.T_odom_sensor = T_odom_sensor;
  for (const pcl::PointXYZL& p : cloud) {
    if (pcl::isFinite(p)) frame.cloud.points.push_back(xview::Point(p.x, p.y, p.z, p.label));
  }
  return frame;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return std::cerr << "03_own_clouds MAP.xvm CLOUD.pcd\n", 2;
  pcl::PointCloud<pcl::PointXYZL> cloud;
  if (pcl::io::loadPCDFile(argv[2], cloud) != 0) throw xview::Error(argv[2], "cannot be read");
  xview::Options options;
  const xview::map::SemanticMap map = xview::map::loadMap(argv[1]);
  options.size = xview::sizeText(map.size);    // a query has the lengths of its map
  const xview::LabelSet& labels = map.labels;  // the driver's classes are those of the map here

  xview::PlaceBuilder builder(labels, options, xview::PlaceUse::query);
  builder.add(
      xview::digestFrame(frameOf(cloud, Eigen::Isometry3d::Identity(), 0), labels, options));
  // ... one add() for every further scan of the drive, with its pose.
  builder.endRecording();
  const xview::Localization fix = xview::Localizer(map, options).localize(builder.finish());
  std::cout << toString(fix.status) << ": " << fix.reason << "\n";
  if (fix.accepted()) std::cout << fix.T_map_sensor.matrix() << "\n";
  return fix.accepted() ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
