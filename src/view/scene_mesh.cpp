// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "base/median.h"
#include "drawing.h"

namespace xview {
namespace {

constexpr Color kMapEdgeColor{150, 150, 150}, kQueryEdgeColor{90, 130, 200};
constexpr std::size_t kMostPutative = 400;  // correspondences drawn, evenly thinned

/// What every viewer shows alike, unlike lines and big points: coloured triangles. A vertex that no
/// triangle uses is a point of a cloud.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;  // [m]
  std::vector<Color> colors;              // one per vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;

  std::uint32_t add(const Eigen::Vector3d& position, const Color& color) {
    vertices.push_back(position);
    colors.push_back(color);
    return static_cast<std::uint32_t>(vertices.size() - 1);
  }
};

/// Eight triangles around a point.
void addOctahedron(Mesh& mesh, const Eigen::Vector3d& center, double radius_m, const Color& color) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0})
      mesh.add(center + sign * radius_m * Eigen::Vector3d::Unit(axis), color);
  }
  // Corners 0..5 are +x -x +y -y +z -z; one face per octant, seen from outside counter-clockwise.
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const std::uint32_t x = octant & 1, y = (octant >> 1) & 1, z = octant >> 2;
    std::array<std::uint32_t, 3> face{first + x, first + 2 + y, first + 4 + z};
    if ((x + y + z) % 2 == 1) std::swap(face[1], face[2]);
    mesh.triangles.push_back(face);
  }
}

/// A tube with three sides, open at its ends. Nothing if both ends are the same point.
void addTube(Mesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m,
             const Color& color) {
  const Eigen::Vector3d along = to - from;
  if (!(along.norm() > 0)) return;
  const Eigen::Vector3d u = along.unitOrthogonal(), v = along.normalized().cross(u);
  std::array<std::uint32_t, 3> near{}, far{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = static_cast<double>(k) * 2 * M_PI / 3;
    const Eigen::Vector3d side = radius_m * (std::cos(angle) * u + std::sin(angle) * v);
    near[k] = mesh.add(from + side, color);
    far[k] = mesh.add(to + side, color);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    mesh.triangles.push_back({near[k], near[next], far[next]});
    mesh.triangles.push_back({near[k], far[next], far[k]});
  }
}

/// An octahedron per vertex in the colour of its class, of half the size for surface classes, and a
/// tube per edge that is drawn. Vertices that are not finite are left out.
void addGraph(Mesh& mesh, const SemanticGraph& graph, const LabelSet& labels, double radius_m,
              const Color& edge_color, const Eigen::Isometry3d& T_scene_graph) {
  for (const Vertex& v : graph.vertices) {
    if (!v.position.allFinite()) continue;
    const bool is_surface = labels.role(v.label) == Role::surface;
    addOctahedron(mesh, T_scene_graph * v.position, is_surface ? radius_m / 2 : radius_m,
                  labels.color(v.label));
  }
  const ReadableEdges edges = readableEdges(graph);
  for (const auto& [i, j] : edges.shown) {
    addTube(mesh, T_scene_graph * graph.vertices[i].position,
            T_scene_graph * graph.vertices[j].position, radius_m / 8, edge_color);
  }
}

/// Legacy ASCII VTK: POLYGONS, and VERTICES for what no triangle uses, with COLOR_SCALARS.
std::string toVtk(const Mesh& mesh) {
  std::string text = "# vtk DataFile Version 3.0\nxview\nASCII\nDATASET POLYDATA\n";
  auto out = std::back_inserter(text);
  fmt::format_to(out, "POINTS {} double\n", mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices)
    fmt::format_to(out, "{:.3f} {:.3f} {:.3f}\n", p.x(), p.y(), p.z());
  fmt::format_to(out, "POLYGONS {} {}\n", mesh.triangles.size(), 4 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) fmt::format_to(out, "3 {} {} {}\n", t[0], t[1], t[2]);
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) used[t[0]] = used[t[1]] = used[t[2]] = true;
  const auto loose = std::count(used.begin(), used.end(), false);
  if (loose > 0) fmt::format_to(out, "VERTICES {} {}\n", loose, 2 * loose);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) fmt::format_to(out, "1 {}\n", i);
  }
  // In ASCII files these are fractions of one.
  fmt::format_to(out, "POINT_DATA {}\nCOLOR_SCALARS RGB 3\n", mesh.colors.size());
  for (const Color& c : mesh.colors)
    fmt::format_to(out, "{:.4f} {:.4f} {:.4f}\n", c[0] / 255.0, c[1] / 255.0, c[2] / 255.0);
  return text;
}

/// With red green blue per vertex.
std::string toPly(const Mesh& mesh) {
  std::string text = "ply\nformat ascii 1.0\ncomment xview\n";
  auto out = std::back_inserter(text);
  fmt::format_to(out,
                 "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
                 "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                 "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                 mesh.vertices.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& p = mesh.vertices[i];
    const Color& c = mesh.colors[i];
    fmt::format_to(out, "{:.3f} {:.3f} {:.3f} {} {} {}\n", p.x(), p.y(), p.z(), c[0], c[1], c[2]);
  }
  for (const auto& t : mesh.triangles) fmt::format_to(out, "3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

/// A line of the scene, whatever it stands for.
struct Stroke {
  std::string name;
  Color color{0, 0, 0};
  double weight = 1;  // thickness over that of a way
  Eigen::Vector3d from, to;
};

/// Of what has correspondences, so that their lines are seen: a third of its width.
double liftOf(const SceneQuery& query, double radius_m) {
  if (query.graph == nullptr || (query.kept.empty() && query.putative.empty())) return 0;
  Eigen::AlignedBox3d box;
  for (const Vertex& v : query.graph->vertices) {
    if (v.position.allFinite()) box.extend(Eigen::Vector3d(query.T_map_query * v.position));
  }
  const double width = box.isEmpty() ? 0 : box.sizes().head<2>().maxCoeff();
  return std::max(6 * radius_m, width / 3);
}

/// An arrow from a pose to where the sensor looks: shaft and two barbs.
void addArrow(const Eigen::Isometry3d& T, const Eigen::Vector3d& forward, const Stroke& like,
              double length_m, std::vector<Stroke>& strokes) {
  const Eigen::Vector3d ahead = T.linear() * forward.normalized(),
                        tip = T.translation() + length_m * ahead;
  const Eigen::Vector3d aside = std::abs(ahead.z()) < 0.9
                                    ? Eigen::Vector3d(ahead.cross(Eigen::Vector3d::UnitZ()))
                                    : Eigen::Vector3d::UnitX();
  const auto add = [&](const Eigen::Vector3d& from) {
    strokes.push_back({like.name, like.color, 1.6, from, tip});
  };
  add(T.translation());
  for (const double side : {0.3, -0.3}) add(tip + length_m * (-0.35 * ahead + side * aside));
}

void addWay(const std::vector<Eigen::Isometry3d>& poses, const Stroke& like,
            std::vector<Stroke>& strokes) {
  for (const auto& piece : trajectoryPieces(poses)) {
    for (std::size_t i = 1; i < piece.size(); ++i)
      strokes.push_back({like.name, like.color, like.weight, piece[i - 1], piece[i]});
  }
}

/// Correspondences of a query that is lifted.
void addMatches(const SceneQuery& query, const SemanticGraph& map, double lift_m,
                std::vector<Stroke>& strokes) {
  const Eigen::Vector3d lift(0, 0, lift_m);
  const auto rest = endsOf(onlyPutative(query.putative, query.kept), query, map);
  for (std::size_t i = 0; i < rest.size(); i += 1 + rest.size() / kMostPutative)
    strokes.push_back(
        {"putative correspondence", kPutativeColor, 0.25, rest[i].query + lift, rest[i].map});
  for (const MatchEnds& ends : endsOf(query.kept, query, map))
    strokes.push_back({"kept correspondence", kKeptColor, 0.8, ends.query + lift, ends.map});
}

std::vector<Stroke> strokesOf(const Scene& scene, double radius_m) {
  std::vector<Stroke> strokes;
  addWay(scene.map_poses, {"key frames", kKeyframeColor, 0.6, {}, {}}, strokes);
  for (const SceneQuery& query : scene.queries) {
    if (!query.has_pose) continue;
    const double lift_m = liftOf(query, radius_m);
    std::vector<Eigen::Isometry3d> poses = posesInMap(query);
    for (Eigen::Isometry3d& T : poses) T.translation().z() += lift_m;
    const Stroke like{
        std::string("pose, ") + toString(query.status), statusColor(query.status), 1, {}, {}};
    addWay(poses, like, strokes);
    if (!poses.empty()) addArrow(poses.back(), query.forward, like, 6 * radius_m, strokes);
    addWay(query.true_poses, {"true pose", kTruthColor, 1, {}, {}}, strokes);
    if (scene.map_graph) addMatches(query, *scene.map_graph, lift_m, strokes);
  }
  for (const SceneLine& line : scene.lines) {
    for (std::size_t i = 1; i < line.points.size(); ++i)
      strokes.push_back({line.name, line.color, 1, line.points[i - 1], line.points[i]});
  }
  const auto broken = [](const Stroke& s) { return !s.from.allFinite() || !s.to.allFinite(); };
  strokes.erase(std::remove_if(strokes.begin(), strokes.end(), broken), strokes.end());
  return strokes;
}

double radiusOf(const Scene& scene) {
  if (scene.map_graph && !scene.map_graph->empty()) return typicalVertexRadius(*scene.map_graph);
  for (const SceneQuery& query : scene.queries) {
    if (query.graph && !query.graph->empty()) return typicalVertexRadius(*query.graph);
  }
  return 0.5;
}

Eigen::Isometry3d liftedPose(const SceneQuery& query, double radius_m) {
  return Eigen::Translation3d(0, 0, liftOf(query, radius_m)) * query.T_map_query;
}

template <class Take>
void forEachPoint(const LabelledCloud* cloud, const Eigen::Isometry3d& T, Take&& take) {
  for (std::size_t i = 0; cloud != nullptr && i < cloud->size(); ++i) {
    const Eigen::Vector3d p = T * cloud->position(i);
    if (p.allFinite()) take(p, cloud->points[i].label);
  }
}

/// Points of classes that are made as they are named.
class NamedPoints {
 public:
  NamedPoints(LabelSet& labels, LabelledCloud& cloud) : labels_(labels), cloud_(cloud) {}

  std::uint32_t classOf(const std::string& name, const Color& color) {
    const auto [entry, is_new] = ids_.try_emplace(name, 0);
    if (!is_new) return entry->second;
    ClassInfo info;
    info.id = labels_.empty() ? 1 : labels_.classes().rbegin()->first + 1;
    info.name = name;
    info.color = color;
    info.role = Role::ignored;  // no part of a place, should the file be read as one
    info.kind = Kind::none;
    labels_.add(info);
    return entry->second = info.id;
  }
  void add(const Eigen::Vector3d& p, std::uint32_t label) {
    const Eigen::Vector3f local = (p - cloud_.origin).cast<float>();
    cloud_.points.push_back(Point(local.x(), local.y(), local.z(), label));
  }

 private:
  LabelSet& labels_;
  LabelledCloud& cloud_;
  std::map<std::string, std::uint32_t> ids_;
};

/// A vertex as a centre and six points around it.
template <class ClassOf>
void addVertices(const SemanticGraph* graph, const Eigen::Isometry3d& T, double radius_m,
                 NamedPoints& points, ClassOf&& classOf) {
  for (std::size_t i = 0; graph != nullptr && i < graph->size(); ++i) {
    const Eigen::Vector3d center = T * graph->vertices[i].position;
    if (!center.allFinite()) continue;
    const std::uint32_t label = classOf(graph->vertices[i].label);
    points.add(center, label);
    for (int axis = 0; axis < 6; ++axis)
      points.add(center + (axis < 3 ? radius_m : -radius_m) * Eigen::Vector3d::Unit(axis % 3),
                 label);
  }
}

Eigen::Vector3d originOf(const Scene& scene) {
  if (scene.map_cloud && !scene.map_cloud->empty()) return scene.map_cloud->origin;
  if (scene.map_graph && !scene.map_graph->empty() &&
      scene.map_graph->vertices[0].position.allFinite())
    return scene.map_graph->vertices[0].position.array().floor();
  return Eigen::Vector3d::Zero();
}

}  // namespace

double typicalVertexRadius(const SemanticGraph& graph) {
  constexpr double kSmallest_m = 0.15, kLargest_m = 3, kShareOfEdge = 0.06;
  std::vector<double> lengths;
  for (const auto& [i, j] : graph.edges()) {
    const double length = (graph.vertices[i].position - graph.vertices[j].position).norm();
    if (std::isfinite(length)) lengths.push_back(length);
  }
  if (lengths.empty()) return 0.6;
  return std::clamp(kShareOfEdge * medianOf(std::move(lengths)), kSmallest_m, kLargest_m);
}

std::string sceneMesh(const Scene& scene, MeshFormat format) {
  const LabelSet& labels = labelsOf(scene);
  const double radius_m = radiusOf(scene);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  Mesh mesh;
  if (scene.map_graph) addGraph(mesh, *scene.map_graph, labels, radius_m, kMapEdgeColor, identity);
  forEachPoint(scene.map_cloud, identity, [&](const Eigen::Vector3d& p, std::uint32_t label) {
    mesh.add(p, labels.color(label));
  });
  for (const SceneQuery& query : scene.queries) {
    if (!query.has_pose) continue;
    const Eigen::Isometry3d T = liftedPose(query, radius_m);
    if (query.graph) addGraph(mesh, *query.graph, labels, radius_m, kQueryEdgeColor, T);
    forEachPoint(query.cloud, T,
                 [&](const Eigen::Vector3d& p, std::uint32_t) { mesh.add(p, kQueryColor); });
    for (const SceneMark& mark : query.marks)
      addOctahedron(mesh, mark.at, radius_m / 2, mark.color);
  }
  for (const SceneMark& mark : scene.marks) addOctahedron(mesh, mark.at, radius_m, mark.color);
  for (const Stroke& s : strokesOf(scene, radius_m))
    addTube(mesh, s.from, s.to, s.weight * radius_m / 4, s.color);
  return format == MeshFormat::vtk ? toVtk(mesh) : toPly(mesh);
}

LabelledCloud sceneCloud(const Scene& scene, LabelSet& labels) {
  labels = labelsOf(scene);
  const double radius_m = radiusOf(scene);
  LabelledCloud cloud;
  cloud.origin = originOf(scene);
  NamedPoints points(labels, cloud);
  const auto addAs = [&](std::uint32_t label) {
    return [&points, label](const Eigen::Vector3d& p, std::uint32_t) { points.add(p, label); };
  };
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  if (scene.map_cloud) cloud = *scene.map_cloud;
  addVertices(scene.map_graph, identity, radius_m / 2, points,
              [](std::uint32_t label) { return label; });
  for (const SceneQuery& query : scene.queries) {
    if (!query.has_pose) continue;
    const Eigen::Isometry3d T = liftedPose(query, radius_m);
    const std::uint32_t label =
        points.classOf(std::string("query, ") + toString(query.status),
                       query.status == Status::accepted ? kQueryColor : statusColor(query.status));
    forEachPoint(query.cloud, T, addAs(label));
    addVertices(query.graph, T, radius_m / 2, points, [&](std::uint32_t) { return label; });
    for (const SceneMark& mark : query.marks)
      points.add(mark.at, points.classOf(mark.group, mark.color));
  }
  for (const SceneMark& mark : scene.marks)
    points.add(mark.at, points.classOf(mark.group, mark.color));
  const double step_m = radius_m / 4;
  for (const Stroke& s : strokesOf(scene, radius_m)) {
    const std::uint32_t label = points.classOf(s.name.empty() ? "line" : s.name, s.color);
    const double steps = std::clamp(std::ceil((s.to - s.from).norm() / step_m), 1.0, 2000.0);
    for (double k = 0; k <= steps; ++k) points.add(s.from + k / steps * (s.to - s.from), label);
  }
  return cloud;
}

}  // namespace xview
