// SPDX-License-Identifier: BSD-3-Clause
#include "drawing.h"

#include <filesystem>

#include "xview/io/atomic_file.h"
#include "xview/io/cloud_files.h"
#include "xview/types/error.h"
#include "xview/view/color_mesh.h"

namespace xview::tools {
namespace {

std::string endingOf(const std::string& path) {
  return std::filesystem::path(path).extension().string();
}

template <class Bytes>
void writeFile(const std::string& path, const Bytes& bytes) {
  AtomicFile file(path);
  file.write(bytes.data(), bytes.size());
  file.commit();
}

}  // namespace

bool isDrawing(const std::string& path) {
  const std::string ending = endingOf(path);
  return ending == ".png" || ending == ".html" || ending == ".vtk" || ending == ".ply" ||
         ending == ".pcd";
}

void checkDrawingEnding(const std::string& path) {
  if (!isDrawing(path))
    throw UsageError(path + ": a drawing ends with .png, .html, .vtk, .ply or .pcd");
}

void writeMesh(const std::string& path, const ColorMesh& mesh) {
  writeFile(path, endingOf(path) == ".vtk" ? toVtk(mesh) : toPly(mesh));
}

void writeDrawing(const std::string& path, const Scene& scene) {
  const std::string ending = endingOf(path);
  const bool has_graph = scene.map_graph && !scene.map_graph->empty();
  const bool has_cloud = scene.map_cloud && !scene.map_cloud->empty();
  if (ending == ".png") return writeFile(path, drawTopDown(scene));
  if (ending == ".html") return writeFile(path, htmlView(scene));
  if (has_graph && ending != ".pcd")
    return writeMesh(path, graphMesh(*scene.map_graph, *scene.labels));
  if (has_cloud && ending == ".pcd") return writePcd(path, *scene.map_cloud, scene.labels);
  if (has_cloud && ending == ".ply") return writePly(path, *scene.map_cloud, scene.labels);
  throw UsageError(
      path +
      ": a graph is drawn as .png, .html, .vtk or .ply, a cloud as .png, .html, .pcd or .ply");
}

}  // namespace xview::tools
