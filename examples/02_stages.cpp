// SPDX-License-Identifier: BSD-3-Clause
// 02_stages MAP_RECORDING RECORDING [WINDOW]: the stages one by one. A map is made in memory, and
// the recording is found in it window by window while it is read, as on a robot.
#include <xview/xview.h>

#include <iostream>
#include <string>

namespace {

/// Every `window` frames that were digested are one query. Frames are digested once and kept only
/// as long as a window needs them.
void localizeWindows(const xview::FrameSource& recording, const xview::Localizer& localizer,
                     const xview::Options& options, std::size_t window) {
  std::vector<xview::FrameDigest> frames;
  xview::digestRecording(recording, options, [&](xview::FrameDigest frame) {
    frames.push_back(std::move(frame));
    if (frames.size() < window) return;
    const xview::Query query =
        xview::makeQuery(frames.data(), frames.data() + frames.size(), recording.labels(), options);
    const xview::Localization fix = localizer.localize(query);
    std::cout << "frames " << frames.front().number << "-" << frames.back().number << ": "
              << query.graph.size() << " vertices, " << toString(fix.status);
    if (fix.accepted()) {
      const Eigen::Vector3d p = fix.T_map_sensor.translation();
      std::cout << " at " << p.transpose() << " m, sigma "
                << fix.covariance.diagonal().head<3>().cwiseSqrt().transpose() << " m";
    }
    std::cout << "\n";
    frames.clear();
  });
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) return std::cerr << "02_stages MAP_RECORDING RECORDING [WINDOW]\n", 2;
  xview::Options options;
  xview::setOption(options, "seed", "7");  // as flags and YAML files spell it
  const auto drive = xview::io::openRecording(argv[1]),
             recording = xview::io::openRecording(argv[2]);
  const xview::map::SemanticMap map = xview::buildMap({drive.get()}, options);
  std::cout << "map: " << map.graph.size() << " vertices, " << map.graph.edgeCount() << " edges\n";
  options.size = xview::sizeText(map.size);  // a query has the lengths of its map
  const std::size_t window = argc > 3 ? std::stoul(argv[3]) : 30;
  localizeWindows(*recording, xview::Localizer(map, options), options, window);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
