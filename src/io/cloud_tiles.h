// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "xview/io/cloud_files.h"

namespace xview::io {

// The divided point-cloud map of Autoware: PCD files, one for each square or rectangle of a grid,
// and `pointcloud_map_metadata.yaml` beside them, or beside their folder, with their size and the
// lower corner of each. Together they are one cloud.

/// A folder with tiles, or with their folder and metadata, or the folder of tiles itself. Throws
/// Error if metadata beside such a folder cannot be read.
bool isTiledCloud(const std::string& path);
/// The first of its tiles.
std::string firstTile(const std::string& path);
/// That of the first tile, with the points of all. Throws Error, also if a tile is missing or has
/// its classes in another field.
CloudHeader readTiledHeader(const std::string& path, const CloudFields& fields);
/// All tiles, read one by one in the order of the metadata. Throws Error as readCloud(), and if
/// points lie outside of their tile.
LabelledCloud readTiledCloud(const std::string& path, const CloudFields& fields,
                             bool require_label);

}  // namespace xview::io
