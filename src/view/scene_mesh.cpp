// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>

#include "drawing.h"

namespace xview {
namespace {

constexpr Color kMapEdgeColor{150, 150, 150}, kQueryEdgeColor{90, 130, 200};
constexpr std::size_t kMostPutative = 400;  // correspondences drawn, evenly thinned

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

ColorMesh sceneMesh(const Scene& scene) {
  const LabelSet& labels = labelsOf(scene);
  const double radius_m = radiusOf(scene);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  ColorMesh mesh;
  const auto addPoint = [&](const Eigen::Vector3d& p, const Color& color) {
    mesh.vertices.push_back(p);
    mesh.colors.push_back(color);
  };
  if (scene.map_graph) addGraph(mesh, *scene.map_graph, labels, radius_m, kMapEdgeColor);
  forEachPoint(scene.map_cloud, identity, [&](const Eigen::Vector3d& p, std::uint32_t label) {
    addPoint(p, labels.color(label));
  });
  for (const SceneQuery& query : scene.queries) {
    if (!query.has_pose) continue;
    const Eigen::Isometry3d T = liftedPose(query, radius_m);
    if (query.graph) addGraph(mesh, *query.graph, labels, radius_m, kQueryEdgeColor, T);
    forEachPoint(query.cloud, T,
                 [&](const Eigen::Vector3d& p, std::uint32_t) { addPoint(p, kQueryColor); });
    for (const SceneMark& mark : query.marks)
      addOctahedron(mesh, mark.at, radius_m / 2, mark.color);
  }
  for (const SceneMark& mark : scene.marks) addOctahedron(mesh, mark.at, radius_m, mark.color);
  for (const Stroke& s : strokesOf(scene, radius_m))
    addTube(mesh, s.from, s.to, s.weight * radius_m / 4, s.color);
  return mesh;
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
