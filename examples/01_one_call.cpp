// SPDX-License-Identifier: BSD-3-Clause
// 01_one_call MAP.xvm RECORDING: where is the whole recording (a scan, a folder, a cloud, with
// labels or without) in the map?
#include <xview/xview.h>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) return std::cerr << "01_one_call MAP.xvm RECORDING\n", 2;
  const xview::Localizer localizer(xview::map::openMap(argv[1]));
  const auto recording = xview::io::openRecording(argv[2]);
  const xview::Localization fix = localizer.localize(*recording);
  std::cout << toString(fix.status) << ", confidence " << fix.confidence << ": " << fix.reason
            << "\n";
  if (!fix.accepted()) return 3;
  std::cout << fix.T_map_query.matrix() << "\n";  // p_map = T_map_query * p_query
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
