// SPDX-License-Identifier: BSD-3-Clause
// 05_follow MAP.xvm RECORDING [WINDOW]: following a robot. The frames of a recording take the place
// of a driver: they come one by one, each with the pose that odometry has for it.
#include <xview/xview.h>

#include <iostream>
#include <string>

int main(int argc, char** argv) try {
  if (argc < 3) return std::cerr << "05_follow MAP.xvm RECORDING [WINDOW]\n", 2;
  const xview::Localizer localizer(xview::map::openMap(argv[1]));
  const auto driver = xview::io::openRecording(argv[2]);
  const int window = argc > 3 ? std::stoi(argv[3]) : 0;  // frames per query; 0 = by the sensor
  xview::Follower follower(localizer, {window});
  std::size_t found = 0;
  for (std::size_t i = 0; i < driver->size(); ++i) {
    // Of a driver of PCL: follower.add(cloud, T_odom_sensor, stamp_s).
    const auto answer = follower.add(driver->read(i), driver->labels());
    std::cout << "frame " << driver->number(i) << ": " << toString(answer.state);
    if (answer.found())
      std::cout << " at " << answer.T_map_sensor.translation().transpose() << " m by "
                << toString(answer.source);
    std::cout << "\n";
    found += answer.found();
  }
  return found > 0 ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
