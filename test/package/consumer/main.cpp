// SPDX-License-Identifier: BSD-3-Clause
#include <xview/io/graph_files.h>
#include <xview/localizer.h>
#include <xview/map/map_store.h>

#include <iostream>

/// consumer MAP.xvm QUERY.ply: the first example of the README, for a bare graph.
int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const xview::Options options;
  const xview::SemanticMap map = xview::loadMap(argv[1]);
  const xview::SemanticGraph graph = xview::readGraph(argv[2]).graph;
  const xview::Query query = xview::makeQuery(graph, map.labels, options);
  const xview::Localization fix = xview::Localizer(map, options).localize(query);
  if (fix.accepted()) std::cout << fix.T_map_query.matrix() << "\n";  // p_map = T_map_query * p_query
  else std::cout << fix.reason << "\n";
}
