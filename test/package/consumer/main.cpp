// SPDX-License-Identifier: BSD-3-Clause
#include <xview/io/recording.h>
#include <xview/localizer.h>
#include <xview/map/map_store.h>

#include <iostream>

/// consumer MAP.xvm SCAN: the example of the README.
int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const xview::Options options;
  const xview::map::SemanticMap map = xview::map::loadMap(argv[1]);
  const auto scan = xview::io::openRecording(argv[2]);
  const auto frames = xview::digestRecording(*scan, options);
  const auto query =
      xview::makeQuery(frames.data(), frames.data() + frames.size(), scan->labels(), options);
  const xview::Localization fix = xview::Localizer(map, options).localize(query);
  if (fix.accepted())
    std::cout << fix.T_map_query.matrix() << "\n";  // p_map = T_map_query * p_query
  else
    std::cout << fix.reason << "\n";
}
