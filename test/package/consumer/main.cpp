// SPDX-License-Identifier: BSD-3-Clause
#include <xview/xview.h>

#include <iostream>

/// consumer MAP.xvm SCAN: the example of the README.
int main(int argc, char** argv) {
  if (argc != 3) return 2;
  xview::Options options;
  const xview::map::SemanticMap map = xview::map::loadMap(argv[1]);
  options.size = xview::sizeText(map.size);  // a query has the lengths of its map
  const auto scan = xview::io::openRecording(argv[2]);
  const xview::Localization fix =
      xview::Localizer(map, options).localize(xview::makeQuery(*scan, options));
  if (fix.accepted())
    std::cout << fix.T_map_query.matrix() << "\n";  // p_map = T_map_query * p_query
  else
    std::cout << fix.reason << "\n";
}
