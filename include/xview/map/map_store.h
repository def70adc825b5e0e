// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/map/semantic_map.h"

namespace xview {

/// What `xview info` prints without reading the bulk of a map.
struct MapSummary {
  int schema_version = 0;
  std::string program_version;
  std::string label_set;
  std::size_t vertices = 0, edges = 0, keyframes = 0, cloud_points = 0, plan_samples = 0;
  std::vector<std::string> sources;
};

/// True if the file starts like an .xvm database (SQLite magic and our application_id); false for anything else, also missing.
bool isMapFile(const std::string& path);

/// Writes the whole map in one transaction. A new file appears only when complete (written beside, then renamed); an existing map is
/// replaced inside one transaction, so that a killed process leaves the old map or the new one. Throws Error.
void saveMap(const std::string& path, const SemanticMap& map);

/// Throws Error: missing, not a map, unknown schema version (the message names both), damaged.
SemanticMap loadMap(const std::string& path);
MapSummary readMapSummary(const std::string& path);

}  // namespace xview
