// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "base/pose.h"
#include "view/scene.h"

namespace xview {
namespace {

/// What a file of a mesh holds.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Color> colors;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

constexpr double kDigits_m = 0.00051;  // files have millimetres

// Readers that are written after the formats' descriptions, not after the writers; they throw
// std::runtime_error.

template <class T>
T next(std::istream& in) {
  T value{};
  if (!(in >> value)) throw std::runtime_error("unexpected end");
  return value;
}

void expectWord(std::istream& in, const std::string& expected) {
  const auto word = next<std::string>(in);
  if (word != expected) throw std::runtime_error("expected " + expected + ", found " + word);
}

std::array<std::uint32_t, 3> nextTriangle(std::istream& in) {
  if (next<int>(in) != 3) throw std::runtime_error("not a triangle");
  return {next<std::uint32_t>(in), next<std::uint32_t>(in), next<std::uint32_t>(in)};
}

Mesh readVtk(const std::string& text) {
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  if (line.rfind("# vtk DataFile Version", 0) != 0) throw std::runtime_error("no magic");
  std::getline(in, line);  // free text
  for (const char* word : {"ASCII", "DATASET", "POLYDATA", "POINTS"}) expectWord(in, word);
  Mesh mesh;
  mesh.vertices.resize(next<std::size_t>(in));
  expectWord(in, "double");
  for (auto& p : mesh.vertices) p = {next<double>(in), next<double>(in), next<double>(in)};
  expectWord(in, "POLYGONS");
  mesh.triangles.resize(next<std::size_t>(in));
  if (next<std::size_t>(in) != 4 * mesh.triangles.size())
    throw std::runtime_error("wrong size of the polygon list");
  for (auto& t : mesh.triangles) t = nextTriangle(in);
  auto section = next<std::string>(in);
  if (section == "VERTICES") {
    const auto points = next<std::size_t>(in);
    if (next<std::size_t>(in) != 2 * points)
      throw std::runtime_error("wrong size of the point list");
    for (std::size_t i = 0; i < points; ++i) {
      if (next<int>(in) != 1 || next<std::size_t>(in) >= mesh.vertices.size())
        throw std::runtime_error("not a point");
    }
    section = next<std::string>(in);
  }
  if (section != "POINT_DATA") throw std::runtime_error("expected POINT_DATA, found " + section);
  mesh.colors.resize(next<std::size_t>(in));
  expectWord(in, "COLOR_SCALARS");
  expectWord(in, "RGB");
  if (next<int>(in) != 3) throw std::runtime_error("not three colour components");
  for (auto& c : mesh.colors) {
    for (auto& component : c)
      component = static_cast<std::uint8_t>(std::lround(255 * next<double>(in)));
  }
  if (in >> line) throw std::runtime_error("more than expected: " + line);
  return mesh;
}

Mesh readPly(const std::string& text) {
  std::istringstream in(text);
  Mesh mesh;
  std::string line;
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    std::string element, name;
    std::size_t count = 0;
    if (!(words >> element >> name >> count) || element != "element") continue;
    if (name == "vertex") mesh.vertices.resize(count);
    if (name == "face") mesh.triangles.resize(count);
  }
  mesh.colors.resize(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    mesh.vertices[i] = {next<double>(in), next<double>(in), next<double>(in)};
    for (auto& component : mesh.colors[i]) component = static_cast<std::uint8_t>(next<int>(in));
  }
  for (auto& t : mesh.triangles) t = nextTriangle(in);
  if (in >> line) throw std::runtime_error("more than expected: " + line);
  return mesh;
}

Mesh meshOf(const Scene& scene) { return readVtk(sceneMesh(scene, MeshFormat::vtk)); }

/// Volume inside a closed mesh whose faces look outwards.
double volumeOf(const Mesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  }
  return volume;
}

bool isValid(const Mesh& mesh) {
  if (mesh.colors.size() != mesh.vertices.size()) return false;
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t i : t) {
      if (i >= mesh.vertices.size()) return false;
    }
  }
  return true;
}

SemanticGraph chain(std::size_t vertices, double step_m) {
  SemanticGraph graph;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    Vertex v;
    v.label = i % 3;
    v.position = {i * step_m, 0, 0};
    graph.vertices.push_back(v);
    if (i > 0) edges.emplace_back(i - 1, i);
  }
  graph.setEdges(edges);
  return graph;
}

LabelSet threeClasses() {
  LabelSet labels("three");
  for (std::uint32_t id = 0; id < 3; ++id) {
    ClassInfo info;
    info.id = id;
    info.name = "class" + std::to_string(id);
    info.color = {static_cast<std::uint8_t>(80 * id), 200, static_cast<std::uint8_t>(10 + id)};
    labels.add(info);
  }
  return labels;
}

Scene sceneOf(const SemanticGraph& map, const LabelSet& labels) {
  Scene scene;
  scene.labels = &labels;
  scene.map_graph = &map;
  return scene;
}

Mesh graphMesh(const SemanticGraph& graph, const LabelSet& labels) {
  return meshOf(sceneOf(graph, labels));
}

/// A scene of nothing but a line.
Mesh tubeMesh(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  Scene scene;
  scene.lines = {{"line", {200, 10, 10}, {from, to}}};
  return meshOf(scene);
}

/// Half of what lies between two opposite corners of the first vertex.
double radiusOf(const Mesh& mesh) { return (mesh.vertices[0] - mesh.vertices[1]).norm() / 2; }

TEST(MeshFile, OctahedronHasItsVolumeAndLooksOutwards) {
  const Mesh mesh = graphMesh(chain(1, 10), threeClasses());
  EXPECT_EQ(mesh.triangles.size(), 8u);
  EXPECT_NEAR(volumeOf(mesh), 4.0 / 3 * std::pow(radiusOf(mesh), 3), 1e-9);
}

TEST(MeshFile, TubeRunsFromEndToEndWithItsRadius) {
  const Eigen::Vector3d from(1, 2, 3), to(4, -2, 9);
  const Mesh mesh = tubeMesh(from, to);
  EXPECT_EQ(mesh.triangles.size(), 6u);
  const Eigen::ParametrizedLine<double, 3> axis =
      Eigen::ParametrizedLine<double, 3>::Through(from, to);
  for (const auto& p : mesh.vertices) {
    EXPECT_NEAR(axis.distance(p), 0.125, 2 * kDigits_m);
    EXPECT_NEAR(std::min((p - from).norm(), (p - to).norm()), 0.125, 2 * kDigits_m);
  }
}

TEST(MeshFile, TubeOfNoLengthIsNothing) {
  EXPECT_TRUE(tubeMesh({1, 1, 1}, {1, 1, 1}).vertices.empty());
}

TEST(MeshFile, VtkAndPlyHoldTheSameMesh) {
  const SemanticGraph graph = chain(5, 12.3456);
  const LabelSet labels = threeClasses();
  const Scene scene = sceneOf(graph, labels);
  const Mesh vtk = meshOf(scene), ply = readPly(sceneMesh(scene, MeshFormat::ply));
  EXPECT_EQ(ply.vertices, vtk.vertices);
  EXPECT_EQ(ply.triangles, vtk.triangles);
  EXPECT_EQ(ply.colors, vtk.colors);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Eigen::Vector3d center = (vtk.vertices[6 * i] + vtk.vertices[6 * i + 1]) / 2;
    EXPECT_LT((center - graph.vertices[i].position).lpNorm<Eigen::Infinity>(), kDigits_m);
  }
}

TEST(MeshFile, CoordinatesFarFromTheOriginKeepTheirMillimetres) {
  SemanticGraph graph = chain(1, 10);
  graph.vertices[0].position = {500000.125, 4649776.225, 12};
  EXPECT_EQ(graphMesh(graph, threeClasses()).vertices[0],
            Eigen::Vector3d(500000.725, 4649776.225, 12));
}

TEST(MeshFile, EmptySceneIsAFile) {
  EXPECT_TRUE(meshOf({}).vertices.empty());
  EXPECT_TRUE(readPly(sceneMesh({}, MeshFormat::ply)).vertices.empty());
}

TEST(GraphMesh, HasAnOctahedronPerVertexAndATubePerEdge) {
  const Mesh mesh = graphMesh(chain(7, 10), threeClasses());
  EXPECT_TRUE(isValid(mesh));
  EXPECT_EQ(mesh.triangles.size(), 7u * 8 + 6u * 6);
  EXPECT_EQ(mesh.vertices.size(), 7u * 6 + 6u * 6);
}

TEST(GraphMesh, VerticesHaveTheColorOfTheirClass) {
  const LabelSet labels = threeClasses();
  const Mesh mesh = graphMesh(chain(3, 10), labels);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(mesh.colors[6 * i], labels.color(i));
}

TEST(GraphMesh, MovesWithItsTransform) {
  const SemanticGraph graph = chain(4, 10);
  const LabelSet labels = threeClasses();
  Scene scene;
  scene.labels = &labels;
  scene.queries.resize(1);
  scene.queries[0].graph = &graph;
  scene.queries[0].T_map_query = poseFromYaw({5, 6, 7}, 1.2);
  const Mesh moved = meshOf(scene);
  const Eigen::Vector3d center = (moved.vertices[6] + moved.vertices[7]) / 2;
  EXPECT_LT((center - scene.queries[0].T_map_query * graph.vertices[1].position)
                .lpNorm<Eigen::Infinity>(),
            kDigits_m);
}

TEST(GraphMesh, VertexSizeFollowsTheEdgesWithinLimits) {
  const auto radius = [](std::size_t vertices, double step_m) {
    return radiusOf(graphMesh(chain(vertices, step_m), threeClasses()));
  };
  EXPECT_LT(radius(5, 8), radius(5, 20));
  EXPECT_GE(radius(5, 0.01), 0.1);
  EXPECT_LE(radius(5, 1e5), 3);
  EXPECT_GT(radius(1, 10), 0);
}

TEST(GraphMesh, VerticesThatAreNotFiniteAreLeftOut) {
  SemanticGraph graph = chain(3, 10);
  graph.vertices[1].position.x() = std::numeric_limits<double>::quiet_NaN();
  const LabelSet labels = threeClasses();
  const std::string vtk = sceneMesh(sceneOf(graph, labels), MeshFormat::vtk);
  EXPECT_EQ(readVtk(vtk).triangles.size(), 2u * 8);
  EXPECT_EQ(vtk.find("nan"), std::string::npos);
}

TEST(GraphMesh, DenseGraphShowsOnlyItsShortestEdges) {
  SemanticGraph graph = chain(60, 10);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> all;
  for (std::uint32_t i = 0; i < 60; ++i) {
    for (std::uint32_t j = 0; j < i; ++j) all.emplace_back(i, j);
  }
  graph.setEdges(all);
  const std::size_t tubes = (graphMesh(graph, threeClasses()).triangles.size() - 60 * 8) / 6;
  EXPECT_GE(tubes, 59u);
  EXPECT_LE(tubes, 3u * 60);
}

TEST(GraphMesh, EmptyGraphIsAnEmptyMesh) { EXPECT_TRUE(graphMesh({}, {}).vertices.empty()); }

std::size_t verticesOfColor(const Mesh& mesh, const Color& color) {
  return static_cast<std::size_t>(std::count(mesh.colors.begin(), mesh.colors.end(), color));
}

/// A chain as map, another as query, without a way.
Scene sceneOf(const SemanticGraph& map, const SemanticGraph& query, const LabelSet& labels) {
  Scene scene = sceneOf(map, labels);
  scene.queries.resize(1);
  scene.queries[0].graph = &query;
  scene.queries[0].T_map_query = poseFromYaw({50, 1, 2}, 0);
  return scene;
}

const Color kKept{20, 160, 60}, kPutative{214, 150, 150};

TEST(SceneMesh, DrawsEachMatchOnceInItsColor) {
  const SemanticGraph map = chain(10, 10), query = chain(4, 10);
  const LabelSet labels = threeClasses();
  Scene scene = sceneOf(map, query, labels);
  scene.queries[0].putative = {{0, 5, 1}, {1, 6, 1}, {2, 0, 1}};
  scene.queries[0].kept = {{0, 5, 1}, {1, 6, 1}};
  const Mesh mesh = meshOf(scene);
  EXPECT_TRUE(isValid(mesh));
  EXPECT_EQ(verticesOfColor(mesh, kKept), 2u * 6);
  EXPECT_EQ(verticesOfColor(mesh, kPutative), 1u * 6);
}

TEST(SceneMesh, AQueryIsAtItsPoseAndAboveItWithCorrespondences) {
  const SemanticGraph map = chain(1, 10), query = chain(1, 10);
  const LabelSet labels = threeClasses();
  Scene scene = sceneOf(map, query, labels);
  const auto heightOfQuery = [&] {
    const Mesh mesh = meshOf(scene);
    return ((mesh.vertices[6] + mesh.vertices[7]) / 2 - Eigen::Vector3d(50, 1, 2)).z();
  };
  EXPECT_NEAR(heightOfQuery(), 0, 1e-9);
  scene.queries[0].kept = {{0, 0, 1}};
  EXPECT_GT(heightOfQuery(), 1);
}

TEST(SceneMesh, HoldsEverythingThatWasGiven) {
  const SemanticGraph map = chain(3, 10), query = chain(2, 10);
  const LabelSet labels = threeClasses();
  LabelledCloud cloud;
  cloud.points.resize(5);
  Scene scene = sceneOf(map, query, labels);
  const auto vertices = [&] { return meshOf(scene).vertices.size(); };
  std::size_t before = vertices();
  const auto expectMore = [&](const char* what) {
    EXPECT_GT(vertices(), before) << what;
    before = vertices();
  };
  scene.map_cloud = &cloud;
  expectMore("cloud of the map");
  scene.map_poses = {poseFromYaw({0, 0, 0}, 0), poseFromYaw({5, 0, 0}, 0)};
  expectMore("key frames");
  scene.queries[0].cloud = &cloud;
  expectMore("cloud of the query");
  scene.queries[0].poses = {poseFromYaw({0, 0, 0}, 0)};
  expectMore("arrow of the query");
  scene.queries[0].marks = {{"agrees", {0, 200, 0}, {1, 2, 3}, ""}};
  expectMore("marks");
  const std::string vtk = sceneMesh(scene, MeshFormat::vtk);
  EXPECT_NE(vtk.find("VERTICES 10 20"), std::string::npos) << "points without triangles";
}

TEST(SceneCloud, HasTheMapByClassAndTheQueryAsAClassOfItsOwn) {
  const SemanticGraph map = chain(3, 10), query = chain(2, 10);
  const LabelSet labels = threeClasses();
  LabelledCloud cloud;
  cloud.origin = {500000, 4649776, 0};
  cloud.points.resize(5);
  Scene scene = sceneOf(map, query, labels);
  scene.map_cloud = &cloud;
  scene.queries[0].kept = {{0, 0, 1}};
  LabelSet drawn;
  const LabelledCloud whole = sceneCloud(scene, drawn);
  std::map<std::string, int> points;
  for (const Point& p : whole.points) ++points[drawn.className(p.label)];
  EXPECT_EQ(points["query, accepted"], 2 * 7);
  EXPECT_GT(points["kept correspondence"], 5);
  EXPECT_EQ(whole.position(0), cloud.position(0));
  EXPECT_GE(whole.size(), 5u + 3 * 7 + 2 * 7);
  for (const auto& [id, info] : labels.classes()) EXPECT_EQ(drawn.className(id), info.name);
}

TEST(SceneMesh, IndicesOutOfRangeAndEmptyGraphsAreFine) {
  const SemanticGraph none;
  const LabelSet labels;
  Scene scene = sceneOf(none, none, labels);
  scene.queries[0].putative = {{0, 0, 1}};
  scene.queries[0].kept = {{7, 7, 1}};
  EXPECT_TRUE(meshOf(scene).vertices.empty());
  LabelSet drawn;
  EXPECT_TRUE(sceneCloud(scene, drawn).empty());
  EXPECT_TRUE(meshOf({}).vertices.empty());
}

}  // namespace
}  // namespace xview
