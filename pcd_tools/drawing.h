// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/view/scene.h"

namespace xview::tools {

/// True if the ending is one that writeDrawing knows: .png, .html, .vtk, .ply, .pcd.
bool isDrawing(const std::string& path);

/// Throws UsageError unless isDrawing.
void checkDrawingEnding(const std::string& path);

/// .png: from above; .html: a page to turn and zoom; .vtk and .ply: the graph as a mesh; .pcd, or
/// .ply if there is no graph: the cloud. Throws UsageError if the scene has no such part.
void writeDrawing(const std::string& path, const Scene& scene);

/// A mesh as .vtk or .ply by the ending of the path.
void writeMesh(const std::string& path, const ColorMesh& mesh);

}  // namespace xview::tools
