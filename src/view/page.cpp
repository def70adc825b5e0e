// SPDX-License-Identifier: BSD-3-Clause
// The scene as JSON, in the page that draws it: page/page.html, page.css and page.js.
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/in_order.h"
#include "drawing.h"

namespace xview {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostOfQueries = 400000;  // points of all queries together
constexpr std::size_t kMostMatches = 2000;      // drawn of one query, evenly thinned
constexpr std::size_t kMostClasses = 255;       // of a page; the others share the last entry

/// RFC 4648 with padding.
std::string base64(const void* data, std::size_t size) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t present = std::min<std::size_t>(3, size - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8) | (k < present ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= present ? kLetters[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}
template <class T>
std::string base64(const std::vector<T>& values) {
  return base64(values.data(), values.size() * sizeof(T));
}

Json orNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

/// Spreads numbers so that any beginning of an order by them is a fair sample.
std::uint32_t shuffled(std::uint32_t i) {
  i = (i ^ (i >> 16)) * 0x45d9f3bu;
  i = (i ^ (i >> 16)) * 0x45d9f3bu;
  return i ^ (i >> 16);
}

struct PagePoint {
  Eigen::Vector3f at;
  std::uint8_t kind = 0;
};

/// Points in chunks, each with positions of 16 bit in its cube: 7 bytes a point, and what is far
/// off or out of sight need not be drawn.
Json chunksOf(std::vector<PagePoint> points) {
  constexpr float kChunks = 16;  // along the longer side
  Eigen::AlignedBox3f box;
  for (const PagePoint& p : points) box.extend(p.at);
  const float edge = std::max(1e-3f, box.isEmpty() ? 1 : box.sizes().maxCoeff() / kChunks * 1.001f);
  std::map<std::array<int, 3>, std::vector<std::uint32_t>> chunks;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f cell = (points[i].at - box.min()) / edge;
    chunks[{int(cell.x()), int(cell.y()), int(cell.z())}].push_back(i);
  }
  std::vector<std::uint16_t> positions;
  std::vector<std::uint8_t> kinds;
  Json list = Json::array();
  for (auto& [cell, members] : chunks) {
    std::sort(members.begin(), members.end(), [](std::uint32_t a, std::uint32_t b) {
      return shuffled(a) < shuffled(b) || (shuffled(a) == shuffled(b) && a < b);
    });
    const Eigen::Vector3f corner =
        box.min() + edge * Eigen::Vector3f(float(cell[0]), float(cell[1]), float(cell[2]));
    for (const std::uint32_t i : members) {
      const Eigen::Vector3f local = (points[i].at - corner) / edge;
      for (int k = 0; k < 3; ++k)
        positions.push_back(
            static_cast<std::uint16_t>(std::clamp(std::round(local[k] * 65535), 0.f, 65535.f)));
      kinds.push_back(points[i].kind);
    }
    list.push_back({members.size(), corner.x(), corner.y(), corner.z(), edge});
  }
  const double area = box.isEmpty() ? 1 : double(box.sizes().x()) * box.sizes().y();
  const double spacing = std::sqrt(std::max(area, 1e-6) / std::max<double>(1, points.size()));
  return {{"size", 0.5 * spacing},
          {"positions", base64(positions)},
          {"kinds", base64(kinds)},
          {"chunks", list}};
}

/// Everything in the page is relative to a centre, so that single precision will do.
class PageData {
 public:
  PageData(const Scene& scene, std::size_t most_points) : scene_(scene), most_(most_points) {
    if (scene.labels) labels_ = *scene.labels;
    for (const std::uint32_t id : classesIn(scene)) kindOf(id);
    const Eigen::AlignedBox3d box = boxOf();
    if (!box.isEmpty()) center_ = box.center();
    radius_ = box.isEmpty() ? 10 : std::max(1e-3, box.sizes().head<2>().norm() / 2);
    half_size_ = box.isEmpty() ? Eigen::Vector3d(10, 10, 0) : Eigen::Vector3d(box.sizes() / 2);
  }

  Json json() {
    Json page = {{"title", scene_.title},
                 {"caption", scene_.caption},
                 {"made_by", scene_.made_by},
                 {"facts", scene_.facts},
                 {"center", {center_.x(), center_.y(), center_.z()}},
                 {"radius", radius_},
                 {"half_size", {half_size_.x(), half_size_.y(), half_size_.z()}},
                 {"vertex_size", vertexSize()},
                 {"cloud", mapPoints()},
                 {"graph", scene_.map_graph && !scene_.map_graph->empty()
                               ? graph(*scene_.map_graph, Eigen::Isometry3d::Identity(), true)
                               : Json()}};
    page["lines"] = lines();
    page["marks"] = marks(scene_.marks);
    page["queries"] = Json::array();
    for (const SceneQuery& q : scene_.queries) page["queries"].push_back(query(q));
    page["charts"] = Json::array();
    for (const SceneChart& chart : scene_.charts) page["charts"].push_back(chartSvg(chart));
    page["classes"] = classes_;
    return page;
  }

 private:
  Eigen::AlignedBox3d boxOf() const {
    Eigen::AlignedBox3d box;
    const auto add = [&](const Eigen::Vector3d& p) {
      if (p.allFinite()) box.extend(p);
    };
    if (scene_.map_graph) {
      for (const Vertex& v : scene_.map_graph->vertices) add(v.position);
    }
    for (std::size_t i = 0; scene_.map_cloud && i < scene_.map_cloud->size(); ++i)
      add(scene_.map_cloud->position(i));
    for (const Eigen::Isometry3d& T : scene_.map_poses) add(T.translation());
    for (const SceneLine& line : scene_.lines) {
      for (const Eigen::Vector3d& p : line.points) add(p);
    }
    for (const SceneMark& mark : scene_.marks) add(mark.at);
    if (!box.isEmpty()) return box;
    for (const SceneQuery& q : scene_.queries) {
      for (const Eigen::Isometry3d& T : posesInMap(q)) add(T.translation());
      for (std::size_t i = 0; q.cloud && i < q.cloud->size(); ++i)
        add(q.T_map_query * q.cloud->position(i));
      for (std::size_t i = 0; q.graph && i < q.graph->size(); ++i)
        add(q.T_map_query * q.graph->vertices[i].position);
    }
    return box;
  }

  double vertexSize() const {
    return 2 * (scene_.map_graph ? typicalVertexRadius(*scene_.map_graph) : 0.5);
  }

  /// Position of a class in the list of the page.
  std::uint8_t kindOf(std::uint32_t id) {
    const auto known = kinds_.find(id);
    if (known != kinds_.end()) return known->second;
    return kinds_[id] = addClass(labels_.className(id), labels_.color(id), quietColor(labels_, id));
  }
  std::uint8_t addClass(const std::string& name, const Color& color, const Color& quiet) {
    if (classes_.size() < kMostClasses)
      classes_.push_back({{"name", name}, {"color", color}, {"quiet", quiet}});
    else
      classes_.back()["name"] = "other classes";
    return static_cast<std::uint8_t>(classes_.size() - 1);
  }

  Eigen::Vector3f local(const Eigen::Vector3d& p) const { return (p - center_).cast<float>(); }

  std::vector<PagePoint> thinned(const LabelledCloud& cloud, const Eigen::Isometry3d& T,
                                 std::size_t most) {
    std::vector<PagePoint> points;
    const std::size_t step =
        1 + (cloud.empty() ? 0 : cloud.size() - 1) / std::max<std::size_t>(1, most);
    for (std::size_t i = 0; i < cloud.size(); i += step) {
      const Eigen::Vector3d p = T * cloud.position(i);
      const std::uint32_t label = cloud.points[i].label;
      if (p.allFinite() && (kinds_.count(label) || !labels_.find(label)))
        points.push_back({local(p), kindOf(label)});
    }
    return points;
  }

  Json mapPoints() {
    std::vector<PagePoint> points;
    std::size_t total = 0;
    const bool is_cloud = scene_.map_cloud && !scene_.map_cloud->empty();
    if (is_cloud) {
      points = thinned(*scene_.map_cloud, Eigen::Isometry3d::Identity(), most_);
      total = scene_.map_cloud->size();
    } else if (scene_.map_bev) {
      points = bevPoints(*scene_.map_bev);
      total = points.size();
    }
    if (points.empty()) return {};
    Json json = {{"name", is_cloud ? "map cloud" : "map from above"},
                 {"total", total},
                 {"shown", points.size()}};
    json.update(chunksOf(std::move(points)));
    return json;
  }

  std::vector<PagePoint> bevPoints(const BevGrid& bev) {
    std::vector<PagePoint> points;
    for (const auto& [channel, name, color] : drawnBevChannels(bev)) {
      const std::uint8_t kind = addClass(name, color, color);
      for (const BevSample& s : bev[channel])
        points.push_back(
            {local({bev.origin_x + s.x, bev.origin_y + s.y, bev.origin_z + s.z}), kind});
    }
    return points;
  }

  Json graph(const SemanticGraph& graph, const Eigen::Isometry3d& T, bool of_map) {
    std::vector<float> positions, ends;
    std::vector<std::uint8_t> kinds;
    Json observations = Json::array(), points = Json::array(), sigmas = Json::array();
    for (const Vertex& v : graph.vertices) {
      if (!v.position.allFinite()) continue;
      append(T * v.position, positions);
      kinds.push_back(kindOf(v.label));
      observations.push_back(v.observations);
      points.push_back(v.points);
      sigmas.push_back(std::round(1e4 * v.sigma_m) / 1e4);
      auto& info = classes_[kinds.back()];
      if (of_map) info["vertices"] = info.value("vertices", 0) + 1;
    }
    const ReadableEdges edges = readableEdges(graph);
    for (const auto& [i, j] : edges.shown) {
      append(T * graph.vertices[i].position, ends);
      append(T * graph.vertices[j].position, ends);
    }
    return {{"positions", base64(positions)}, {"kinds", base64(kinds)}, {"edges", base64(ends)},
            {"observations", observations},   {"points", points},       {"sigmas", sigmas},
            {"edges_in_all", edges.all}};
  }

  void append(const Eigen::Vector3d& p, std::vector<float>& numbers) const {
    const Eigen::Vector3f q = local(p);
    numbers.insert(numbers.end(), {q.x(), q.y(), q.z()});
  }

  void appendLine(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  std::vector<float>& ends) const {
    if (!a.allFinite() || !b.allFinite()) return;
    append(a, ends);
    append(b, ends);
  }

  std::string way(const std::vector<Eigen::Isometry3d>& poses) const {
    std::vector<float> ends;
    for (const auto& piece : trajectoryPieces(poses)) {
      for (std::size_t i = 1; i < piece.size(); ++i) appendLine(piece[i - 1], piece[i], ends);
    }
    return base64(ends);
  }

  /// Lines of one name are one layer.
  Json lines() const {
    Json list = Json::array();
    if (scene_.map_poses.size() > 1)
      list.push_back(
          {{"name", "key frames"}, {"color", kKeyframeColor}, {"ends", way(scene_.map_poses)}});
    std::vector<std::pair<std::string, std::pair<Color, std::vector<float>>>> by_name;
    for (const SceneLine& line : scene_.lines) {
      auto& [color, ends] = valueOf(by_name, line.name);
      color = line.color;
      for (std::size_t i = 1; i < line.points.size(); ++i)
        appendLine(line.points[i - 1], line.points[i], ends);
    }
    for (const auto& [name, layer] : by_name)
      list.push_back({{"name", name}, {"color", layer.first}, {"ends", base64(layer.second)}});
    return list;
  }

  /// Marks by group, in the order in which the groups come.
  Json marks(const std::vector<SceneMark>& marks) const {
    std::vector<std::pair<std::string, std::vector<const SceneMark*>>> groups;
    for (const SceneMark& mark : marks) {
      if (mark.at.allFinite()) valueOf(groups, mark.group).push_back(&mark);
    }
    Json list = Json::array();
    for (const auto& [name, members] : groups) {
      std::vector<float> positions;
      Json notes = Json::array();
      for (const SceneMark* mark : members) {
        append(mark->at, positions);
        notes.push_back(mark->note);
      }
      list.push_back({{"group", name},
                      {"color", members[0]->color},
                      {"positions", base64(positions)},
                      {"notes", notes},
                      {"listed", members[0]->is_listed}});
    }
    return list;
  }

  std::string matches(const std::vector<Correspondence>& pairs, const SceneQuery& query) const {
    std::vector<float> ends;
    if (scene_.map_graph == nullptr) return {};
    const std::vector<MatchEnds> all = endsOf(pairs, query, *scene_.map_graph);
    for (std::size_t i = 0; i < all.size(); i += 1 + all.size() / kMostMatches)
      appendLine(all[i].map, all[i].query, ends);
    return base64(ends);
  }

  Json place(const Eigen::Vector3d& p) const {
    const Eigen::Vector3f q = local(p);
    return {q.x(), q.y(), q.z()};
  }

  Json query(const SceneQuery& q) {
    Json json = {{"name", q.name},
                 {"status", toString(q.status)},
                 {"reason", q.reason},
                 {"chance_wrong", q.chance_wrong},
                 {"sigma", orNull(q.sigma_m)},
                 {"error", orNull(q.error_m)},
                 {"error_deg", orNull(q.error_deg)},
                 {"ms", orNull(q.total_ms)},
                 {"elsewhere", q.out_of_map},
                 {"pose", Json()},
                 {"kept", matches(q.kept, q)},
                 {"putative", matches(onlyPutative(q.putative, q.kept), q)},
                 {"hypotheses", Json::array()},
                 {"marks", marks(q.marks)}};
    const std::vector<Eigen::Isometry3d> poses = posesInMap(q);
    if (!q.has_pose || poses.empty() || !poses.back().matrix().allFinite()) return json;
    const Eigen::Vector3d heading = poses.back().linear() * q.forward.normalized();
    json["pose"] = place(poses.back().translation());
    json["heading"] = {heading.x(), heading.y(), heading.z()};
    json["way"] = way(poses);
    json["truth"] = way(q.true_poses);
    if (!q.true_poses.empty() && q.true_poses.back().matrix().allFinite()) {
      json["error_line"] = place(q.true_poses.back().translation());
      for (const Json& number : json["pose"]) json["error_line"].push_back(number);
    }
    for (const Eigen::Isometry3d& T : q.hypotheses) {
      if (T.matrix().allFinite()) json["hypotheses"].push_back(place(T.translation()));
    }
    const Eigen::AlignedBox3d box = boxOf(q, poses);
    json["extent"] = std::max(0.05 * radius_, box.sizes().head<2>().norm());
    json["middle"] = place(box.center());
    if (q.graph && !q.graph->empty()) json["graph"] = graph(*q.graph, q.T_map_query, false);
    if (q.cloud && !q.cloud->empty())
      json["cloud"] =
          chunksOf(thinned(*q.cloud, q.T_map_query,
                           kMostOfQueries / std::max<std::size_t>(10, scene_.queries.size())));
    return json;
  }

  static Eigen::AlignedBox3d boxOf(const SceneQuery& q,
                                   const std::vector<Eigen::Isometry3d>& poses) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Isometry3d& T : poses) box.extend(Eigen::Vector3d(T.translation()));
    for (std::size_t i = 0; q.graph && i < q.graph->size(); ++i) {
      const Eigen::Vector3d p = q.T_map_query * q.graph->vertices[i].position;
      if (p.allFinite()) box.extend(p);
    }
    if (box.sizes().isZero() && q.cloud) {  // a cloud of its own, without a way
      for (std::size_t i = 0; i < q.cloud->size(); ++i)
        box.extend(Eigen::Vector3d(q.T_map_query * q.cloud->position(i)));
    }
    return box;
  }

  const Scene& scene_;
  std::size_t most_;
  LabelSet labels_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  double radius_ = 10;
  Eigen::Vector3d half_size_;
  std::map<std::uint32_t, std::uint8_t> kinds_;
  Json classes_ = Json::array();
};

/// So that no text of the scene can end the script element.
std::string withoutTags(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

}  // namespace

std::string htmlPage(const Scene& scene, std::size_t most_points) {
  std::map<std::string, std::string> parts = pageParts();
  parts["scene"] = withoutTags(
      PageData(scene, most_points).json().dump(-1, ' ', false, Json::error_handler_t::replace));
  const std::string& page = parts["page"];
  std::string filled;
  for (std::size_t at = 0; at < page.size();) {  // {{name}} becomes the part of that name
    const std::size_t open = page.find("{{", at), close = page.find("}}", open);
    filled += page.substr(at, open == std::string::npos ? open : open - at);
    if (close == std::string::npos) break;
    filled += parts.at(page.substr(open + 2, close - open - 2));
    at = close + 2;
  }
  return filled;
}

}  // namespace xview
