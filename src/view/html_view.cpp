// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "drawing.h"

namespace xview {
extern const char* const kHtmlPageBegin;
extern const char* const kHtmlPageEnd;
namespace {

using nlohmann::ordered_json;

constexpr Color kMapEdgeColor{190, 190, 196}, kQueryEdgeColor{90, 130, 200};

/// RFC 4648 with padding.
std::string base64(const void* data, std::size_t size) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t present = size - i < 3 ? size - i : 3;
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8) | (k < present ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= present ? kLetters[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}

/// What the page draws in one call.
class Layer {
 public:
  /// kind: points, balls, lines (two points each). lift: none, all, or starts (the first end of
  /// each line).
  Layer(std::string name, std::string kind, double size_m, std::string lift = "none")
      : name_(std::move(name)), kind_(std::move(kind)), lift_(std::move(lift)), size_m_(size_m) {}

  void add(const Eigen::Vector3d& p, const Color& color) {
    positions_.push_back(p);
    colors_.insert(colors_.end(), color.begin(), color.end());
  }
  void addLine(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Color& color) {
    if (!a.allFinite() || !b.allFinite()) return;
    add(a, color);
    add(b, color);
  }
  void append(const Layer& other) {
    positions_.insert(positions_.end(), other.positions_.begin(), other.positions_.end());
    colors_.insert(colors_.end(), other.colors_.begin(), other.colors_.end());
  }
  void hide() { shown_ = false; }
  const std::string& name() const { return name_; }
  const std::vector<Eigen::Vector3d>& positions() const { return positions_; }

  ordered_json toJson(const Eigen::Vector3d& center) const {
    std::vector<float> relative;
    relative.reserve(3 * positions_.size());
    for (const Eigen::Vector3d& p : positions_) {
      for (int i = 0; i < 3; ++i) relative.push_back(static_cast<float>(p[i] - center[i]));
    }
    return {{"name", name_},
            {"kind", kind_},
            {"lift", lift_},
            {"size", size_m_},
            {"shown", shown_},
            {"count", positions_.size()},
            {"positions", base64(relative.data(), relative.size() * sizeof(float))},
            {"colors", base64(colors_.data(), colors_.size())}};
  }

 private:
  std::string name_, kind_, lift_;
  double size_m_;
  bool shown_ = true;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<std::uint8_t> colors_;
};

class SceneLayers {
 public:
  SceneLayers(const Scene& scene, const HtmlViewOptions& options)
      : scene_(scene), options_(options) {
    if (scene.labels != nullptr) labels_ = *scene.labels;
    if (scene.map_graph != nullptr) vertex_size_m_ = 2 * typicalVertexRadius(*scene.map_graph);
    addMap();
    for (std::size_t i = 0; i < scene.queries.size(); ++i) {
      const SceneQuery& query = scene.queries[i];
      addQuery(query, !query.name.empty()         ? query.name
                      : scene.queries.size() == 1 ? "query"
                                                  : "query " + std::to_string(i + 1));
    }
    for (const SceneLine& line : scene.lines) addLines(line);
  }

  std::vector<Layer> take() { return std::move(layers_); }

 private:
  void keep(Layer layer) {
    if (!layer.positions().empty()) layers_.push_back(std::move(layer));
  }

  void addMap() {
    const bool has_cloud = scene_.map_cloud != nullptr && !scene_.map_cloud->empty();
    if (has_cloud)
      addCloud("map cloud", *scene_.map_cloud, Eigen::Isometry3d::Identity(), 0.25, "none");
    if (!has_cloud && scene_.map_plan != nullptr) addPlan(*scene_.map_plan);
    if (scene_.map_graph != nullptr) {
      addGraph("map", *scene_.map_graph, Eigen::Isometry3d::Identity(), "none", kMapEdgeColor);
    }
    addTrajectory("key frames", scene_.map_poses, kKeyframeColor, "none");
  }

  void addQuery(const SceneQuery& query, const std::string& name) {
    if (query.cloud != nullptr)
      addCloud(name + " cloud", *query.cloud, query.T_map_query, 0, "all");
    if (query.graph != nullptr)
      addGraph(name, *query.graph, query.T_map_query, "all", kQueryEdgeColor);
    if (query.graph != nullptr && scene_.map_graph != nullptr) {
      addMatches(name + " putative matches", query, query.putative, kPutativeColor, true);
      addMatches(name + " kept matches", query, query.kept, kKeptColor, false);
    }
    std::vector<Eigen::Isometry3d> poses;
    for (const Eigen::Isometry3d& T_odom_sensor : query.poses)
      poses.push_back(query.T_map_query * T_odom_sensor);
    addTrajectory(name + " poses", poses, statusColor(query.status), "all");
    if (!poses.empty())
      addViewPyramid(name + " view", poses.back(), query.forward, statusColor(query.status), "all");
    addTrajectory(name + " true poses", query.true_poses, kTruthColor, "none");
    if (!query.true_poses.empty())
      addViewPyramid(name + " true view", query.true_poses.back(), query.forward, kTruthColor,
                     "none");
  }

  void addCloud(const std::string& name, const LabelledCloud& cloud, const Eigen::Isometry3d& T,
                double fade, const std::string& lift) {
    Layer layer(name, "points", 0.2, lift);
    const std::size_t step = 1 + cloud.size() / std::max<std::size_t>(1, options_.most_points);
    for (std::size_t i = 0; i < cloud.size(); i += step) {
      const Eigen::Vector3d p = T * cloud.position(i);
      if (p.allFinite()) layer.add(p, paler(labels_.color(cloud.points[i].label), fade));
    }
    keep(std::move(layer));
  }

  void addPlan(const PlanView& plan) {
    Layer layer("map plan view", "points", 0.8 * plan.cell_m);
    const std::size_t step =
        1 + plan.sampleCount() / std::max<std::size_t>(1, options_.most_points);
    for (std::size_t c = 0; c < kChannels; ++c) {
      const Color color = channelColor(static_cast<Channel>(c));
      for (std::size_t i = 0; i < plan.samples[c].size(); i += step) {
        const PlanSample& s = plan.samples[c][i];
        layer.add({plan.origin_x + s.x, plan.origin_y + s.y, plan.origin_z + s.z}, color);
      }
    }
    keep(std::move(layer));
  }

  void addGraph(const std::string& name, const SemanticGraph& graph, const Eigen::Isometry3d& T,
                const std::string& lift, const Color& edge_color) {
    Layer objects(name + " vertices", "balls", vertex_size_m_, lift);
    Layer surfaces(name + " surface vertices", "balls", vertex_size_m_ / 2, lift);
    Layer edges(name + " edges", "lines", 0, lift);
    for (const Vertex& v : graph.vertices) {
      if (!v.position.allFinite()) continue;
      Layer& layer = labels_.role(v.label) == Role::surface ? surfaces : objects;
      layer.add(T * v.position, labels_.color(v.label));
    }
    for (const auto& [i, j] : readableEdges(graph)) {
      edges.addLine(T * graph.vertices[i].position, T * graph.vertices[j].position, edge_color);
    }
    keep(std::move(objects));
    keep(std::move(surfaces));
    keep(std::move(edges));
  }

  void addMatches(const std::string& name, const SceneQuery& query,
                  const std::vector<Correspondence>& matches, const Color& color, bool hidden) {
    Layer layer(name, "lines", 0, "starts");
    if (hidden) layer.hide();
    for (const Correspondence& c : matches) {
      if (c.query >= query.graph->size() || c.map >= scene_.map_graph->size()) continue;
      layer.addLine(query.T_map_query * query.graph->vertices[c.query].position,
                    scene_.map_graph->vertices[c.map].position, color);
    }
    keep(std::move(layer));
  }

  void addTrajectory(const std::string& name, const std::vector<Eigen::Isometry3d>& poses,
                     const Color& color, const std::string& lift) {
    Layer layer(name, "lines", 0, lift);
    for (const auto& piece : trajectoryPieces(poses)) {
      for (std::size_t i = 1; i < piece.size(); ++i) layer.addLine(piece[i - 1], piece[i], color);
    }
    keep(std::move(layer));
  }

  /// A pyramid that opens to where the sensor looks.
  void addViewPyramid(const std::string& name, const Eigen::Isometry3d& T,
                      const Eigen::Vector3d& forward, const Color& color, const std::string& lift) {
    constexpr double kLength_m = 3;
    const Eigen::Vector3d ahead = forward.normalized(), u = ahead.unitOrthogonal(),
                          v = ahead.cross(u);
    std::array<Eigen::Vector3d, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const double su = k == 0 || k == 3 ? 1 : -1, sv = k < 2 ? 1 : -1;
      corners[k] = T * Eigen::Vector3d(kLength_m * (ahead + 0.5 * su * u + 0.4 * sv * v));
    }
    Layer layer(name, "lines", 0, lift);
    for (std::size_t k = 0; k < 4; ++k) {
      layer.addLine(T.translation(), corners[k], color);
      layer.addLine(corners[k], corners[(k + 1) % 4], color);
    }
    keep(std::move(layer));
  }

  void addLines(const SceneLine& line) {
    Layer layer(line.name.empty() ? "line" : line.name, "lines", 0);
    for (std::size_t i = 1; i < line.points.size(); ++i)
      layer.addLine(line.points[i - 1], line.points[i], line.color);
    for (Layer& known : layers_) {
      if (known.name() == layer.name()) return known.append(layer);
    }
    keep(std::move(layer));
  }

  const Scene& scene_;
  HtmlViewOptions options_;
  LabelSet labels_;
  double vertex_size_m_ = 1;
  std::vector<Layer> layers_;
};

ordered_json classesOf(const Scene& scene) {
  ordered_json classes = ordered_json::array();
  if (scene.labels == nullptr) return classes;
  for (const std::uint32_t id : classesIn(scene)) {
    classes.push_back({{"name", scene.labels->className(id)}, {"color", scene.labels->color(id)}});
  }
  return classes;
}

/// So that no text of the scene can end the script element.
std::string withoutTags(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

}  // namespace

std::string htmlView(const Scene& scene, const HtmlViewOptions& options) {
  const std::vector<Layer> layers = SceneLayers(scene, options).take();
  Eigen::AlignedBox3d box;
  for (const Layer& layer : layers) {
    for (const Eigen::Vector3d& p : layer.positions()) box.extend(p);
  }
  const Eigen::Vector3d center =
      box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.center());
  ordered_json json = {{"title", scene.title},
                       {"radius", box.isEmpty() ? 10.0 : box.sizes().head<2>().norm() / 2},
                       {"center", {center.x(), center.y(), center.z()}},
                       {"classes", classesOf(scene)},
                       {"layers", ordered_json::array()}};
  for (const Layer& layer : layers) json["layers"].push_back(layer.toJson(center));
  const std::string text = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  std::string page = kHtmlPageBegin + withoutTags(text) + "</script>\n";
  if (!options.below.empty()) page += "<main>\n" + options.below + "</main>\n";
  return page + kHtmlPageEnd;
}

}  // namespace xview
