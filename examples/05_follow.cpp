// SPDX-License-Identifier: BSD-3-Clause
// 05_follow MAP.xvm RECORDING [WINDOW]: following a robot. The frames of a recording take the place
// of a driver: they come one by one, each with the pose that odometry has for it.
#include <xview/xview.h>

#include <iostream>
#include <string>

int main(int argc, char** argv) try {
  if (argc < 3) return std::cerr << "05_follow MAP.xvm RECORDING [WINDOW]\n", 2;
  const xview::Localizer localizer(xview::map::openToLocalize(argv[1]));
  const auto driver = xview::io::openRecording(argv[2]);
  const std::size_t window = argc > 3 ? std::stoul(argv[3]) : 20;  // frames per query
  xview::Tracker tracker(localizer, localizer.options(), window);
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < driver->size(); ++i) {
    // Of a driver of PCL: tracker.add(cloud, T_odom_sensor, stamp_s).
    const auto answer = tracker.add(driver->read(i), driver->labels());
    if (!answer) continue;  // the window is not full
    const xview::Localization& fix = answer->fix;
    std::cout << "frame " << driver->number(i) << ": " << toString(fix.status);
    if (fix.accepted())
      std::cout << " at " << fix.T_map_sensor.translation().transpose() << " m, "
                << (answer->local ? "where it was expected" : "searched everywhere");
    std::cout << (answer->lost ? ", was lost\n" : "\n");
    accepted += fix.accepted();
  }
  return accepted > 0 ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
