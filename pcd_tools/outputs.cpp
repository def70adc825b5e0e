// SPDX-License-Identifier: BSD-3-Clause
#include "outputs.h"

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

void append(const ColorMesh& part, ColorMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  mesh.colors.insert(mesh.colors.end(), part.colors.begin(), part.colors.end());
  for (auto triangle : part.triangles) {
    for (std::uint32_t& corner : triangle) corner += first;
    mesh.triangles.push_back(triangle);
  }
}

/// The graph, the way and the pose of an answer, in the colour of its status.
void addQuery(const SceneQuery& query, const LabelSet& labels, double radius_m, ColorMesh& mesh) {
  const Color color = statusColor(query.status);
  if (query.graph) append(graphMesh(*query.graph, labels, query.T_map_query), mesh);
  const auto at = [&](std::size_t i) -> Eigen::Vector3d {
    return query.T_map_query * query.poses[i].translation();
  };
  for (std::size_t i = 1; i < query.poses.size(); ++i)
    addTube(mesh, at(i - 1), at(i), radius_m / 4, color);
  if (!query.poses.empty()) addOctahedron(mesh, at(query.poses.size() - 1), radius_m, color);
}

ColorMesh meshOf(const Scene& scene) {
  ColorMesh mesh;
  double radius_m = 0.5;
  if (scene.map_graph && !scene.map_graph->empty()) {
    mesh = graphMesh(*scene.map_graph, *scene.labels);
    radius_m = typicalVertexRadius(*scene.map_graph);
  }
  for (const SceneQuery& query : scene.queries) addQuery(query, *scene.labels, radius_m, mesh);
  for (const SceneLine& line : scene.lines) {
    for (std::size_t i = 1; i < line.points.size(); ++i)
      addTube(mesh, line.points[i - 1], line.points[i], radius_m / 4, line.color);
  }
  return mesh;
}

}  // namespace

bool makeFolder(const std::string& path) {
  std::error_code problem;
  const bool is_new = std::filesystem::create_directories(path, problem);
  if (problem) throw Error(path, "cannot be made: " + problem.message());
  return is_new;
}

void writeFile(const std::string& path, const void* data, std::size_t bytes) {
  io::AtomicFile file(path);
  file.write(data, bytes);
  file.commit();
}

void requireCloudPath(const std::string& path) {
  const std::string ending = endingOf(path);
  if (ending != ".pcd" && ending != ".ply")
    throw UsageError(path + ": a cloud ends with .pcd or .ply");
  io::requireWritable(path);
}

void writeCloud(const std::string& path, const LabelledCloud& cloud, const LabelSet& labels) {
  if (endingOf(path) == ".pcd")
    io::writePcd(path, cloud, &labels);
  else
    io::writePly(path, cloud, &labels);
}

Scene sceneOf(const map::SemanticMap& map, const std::string& title) {
  Scene scene;
  scene.title = title;
  scene.labels = &map.labels;
  scene.map_graph = &map.graph;
  scene.map_cloud = &map.cloud;
  scene.map_plan = &map.plan;
  scene.map_poses = map.poses;
  return scene;
}

bool isDrawing(const std::string& path) {
  const std::string ending = endingOf(path);
  return ending == ".png" || ending == ".html" || ending == ".vtk" || ending == ".ply" ||
         ending == ".pcd";
}

void requireDrawingPath(const std::string& path) {
  if (!isDrawing(path))
    throw UsageError(path + ": a drawing ends with .png, .html, .vtk, .ply or .pcd");
  io::requireWritable(path);
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
  const bool has_mesh = has_graph || (!has_cloud && !scene.queries.empty());
  if (has_mesh && ending != ".pcd") return writeMesh(path, meshOf(scene));
  if (has_cloud && ending == ".pcd") return io::writePcd(path, *scene.map_cloud, scene.labels);
  if (has_cloud && ending == ".ply") return io::writePly(path, *scene.map_cloud, scene.labels);
  throw UsageError(
      path +
      ": a graph is drawn as .png, .html, .vtk or .ply, a cloud as .png, .html, .pcd or .ply");
}

}  // namespace xview::tools
