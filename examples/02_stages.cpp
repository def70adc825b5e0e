// SPDX-License-Identifier: BSD-3-Clause
// 02_stages MAP_RECORDING RECORDING [WINDOW]: the stages one by one. A map is made in memory, and
// the recording is found in it window by window while it is read.
#include <xview/xview.h>

#include <iostream>
#include <string>
#include <utility>

int main(int argc, char** argv) try {
  if (argc < 3) return std::cerr << "02_stages MAP_RECORDING RECORDING [WINDOW]\n", 2;
  xview::Options options;
  xview::setOption(options, "seed", "7");  // as flags and YAML files spell it
  const auto drive = xview::io::openRecording(argv[1]),
             recording = xview::io::openRecording(argv[2]);
  xview::map::SemanticMap map = xview::buildMap(*drive, options);
  std::cout << "map: " << map.graph.size() << " vertices\n";
  const xview::Localizer localizer(std::move(map), options);

  const std::size_t window = argc > 3 ? std::stoul(argv[3]) : 30;
  std::vector<xview::PreprocessedFrame> frames;  // frames are preprocessed once and then forgotten
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < recording->size(); ++i) {
    frames.push_back(localizer.preprocess(recording->read(i), recording->labels()));
    if (frames.size() < window && i + 1 < recording->size()) continue;
    const xview::Query query = localizer.query(frames, recording->labels());
    const xview::Localization fix = localizer.localize(query);
    std::cout << "frames " << frames.front().number << "-" << frames.back().number << ": "
              << query.graph.size() << " vertices, " << toString(fix.status);
    if (fix.accepted()) {
      std::cout << " at " << fix.T_map_sensor.translation().transpose() << " m, sigma "
                << fix.covariance.diagonal().head<3>().cwiseSqrt().transpose() << " m";
    }
    std::cout << "\n";
    accepted += fix.accepted();
    frames.clear();
  }
  return accepted > 0 ? 0 : 3;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
