// SPDX-License-Identifier: BSD-3-Clause
#include "scenes.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <ctime>

#include "base/median.h"
#include "pose/trajectory.h"

namespace xview::tools {
namespace {

std::string sigmaText(double sigma_m) {
  return std::isfinite(sigma_m) && sigma_m > 0 ? ", ±" + lengthText(sigma_m) : "";
}

/// "2026-11-22" in UTC: that of SOURCE_DATE_EPOCH, if it is set, so that a page can be made again
/// to the byte.
std::string dateText() {
  const char* const epoch = std::getenv("SOURCE_DATE_EPOCH");
  const std::time_t time = epoch ? std::atoll(epoch) : std::time(nullptr);
  std::tm parts{};
  char text[32] = "";
  if (gmtime_r(&time, &parts)) std::strftime(text, sizeof text, "%Y-%m-%d", &parts);
  return text;
}

}  // namespace

Scene sceneOf(const Place& map) {
  Scene scene;
  scene.labels = &map.labels;
  scene.map_graph = &map.graph;
  scene.map_cloud = &map.cloud;
  scene.map_bev = &map.bev;
  scene.map_poses = map.poses;
  return scene;
}

std::string madeBy(const Job& job) {
  return fmt::format("{} · version {} · {}", job.command_line, XVIEW_VERSION, dateText());
}

Localization movedTo(const Eigen::Vector3d& p_query, Localization fix) {
  const Eigen::Vector3d p_map = fix.T_map_query * (fix.scale * p_query);
  fix.covariance = pose::movedCovariance(fix.covariance, fix.T_map_sensor.translation(), p_map);
  fix.T_map_sensor.translation() = p_map;
  return fix;
}

SceneQuery queryOf(const Localization& fix) {
  SceneQuery query;
  query.status = fix.status;
  query.reason = fix.reason;
  query.chance_wrong = chanceWrongText(fix.confidence);
  query.has_pose = !fix.hypotheses.empty();
  if (!fix.covariance.isZero()) query.sigma_m = positionSigma(fix.covariance);
  if (!fix.timing_ms.empty()) query.total_ms = totalMs(fix.timing_ms);
  query.T_map_query = fix.T_map_query;
  const Eigen::Isometry3d T_query_sensor = fix.T_map_query.inverse() * fix.T_map_sensor;
  for (const Hypothesis& h : fix.hypotheses)
    query.hypotheses.push_back(h.T_map_query * T_query_sensor);
  return query;
}

std::string outcomeOf(const std::vector<SceneQuery>& queries) {
  std::vector<double> sigmas;
  std::size_t accepted = 0;
  for (const SceneQuery& query : queries) {
    if (query.status != Status::accepted) continue;
    ++accepted;
    if (std::isfinite(query.sigma_m)) sigmas.push_back(query.sigma_m);
  }
  const std::string sigma = sigmas.empty() ? "" : sigmaText(medianOf(sigmas));
  if (queries.size() == 1) return toString(queries[0].status) + sigma;
  return fmt::format("{} of {} found{}", accepted, queries.size(), sigma);
}

namespace {

template <class PositionOf>
Eigen::Isometry3d arrowAmong(std::size_t size, const Eigen::Isometry3d& origin,
                             PositionOf&& position) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector3d p = origin.inverse() * position(i);
    if (p.allFinite()) box.extend(p);
  }
  const bool around_origin = !box.isEmpty() && (box.min().head<2>().array() <= 0).all() &&
                             (box.max().head<2>().array() >= 0).all();
  if (box.isEmpty() || around_origin) return origin;
  return origin * Eigen::Translation3d(box.center());
}

}  // namespace

Eigen::Isometry3d arrowPose(const LabelledCloud& cloud, const Eigen::Isometry3d& origin) {
  return arrowAmong(cloud.size(), origin, [&](std::size_t i) { return cloud.position(i); });
}

Eigen::Isometry3d arrowPose(const SemanticGraph& graph) {
  return arrowAmong(graph.size(), Eigen::Isometry3d::Identity(),
                    [&](std::size_t i) { return graph.vertices[i].position; });
}

Eigen::Isometry3d arrowPose(const Query& query) {
  if (query.sensor != Sensor::cloud || query.poses.size() != 1) return query.poses.back();
  return query.cloud.empty() ? arrowPose(query.graph) : arrowPose(query.cloud, query.poses[0]);
}

SceneQuery queryWith(const Query& query, const Localization& fix) {
  const Eigen::Isometry3d arrow = arrowPose(query);
  SceneQuery result = queryOf(movedTo(arrow.translation(), fix));
  result.name = "query";
  result.graph = &query.graph;
  result.cloud = &query.cloud;
  result.poses = query.poses;
  if (query.sensor != Sensor::camera) result.forward = Eigen::Vector3d::UnitX();
  result.poses.back() = arrow;
  result.putative = fix.putative;
  result.kept = fix.kept;
  return result;
}

std::map<std::uint32_t, std::uint32_t> JoinedLabels::idsFor(const LabelSet& its_labels) {
  std::map<std::string, std::uint32_t> known;
  for (const auto& [id, info] : labels_.classes()) known.emplace(info.name, id);
  std::map<std::uint32_t, std::uint32_t> ids;
  for (const auto& [id, info] : its_labels.classes()) {
    const auto same = known.find(info.name);
    if (same != known.end()) {
      ids[id] = same->second;
      continue;
    }
    ClassInfo added = info;
    if (labels_.find(id)) added.id = labels_.classes().rbegin()->first + 1;
    labels_.add(added);
    ids[id] = added.id;
  }
  return ids;
}

void JoinedLabels::adopt(Place& place) {
  const auto ids = idsFor(place.labels);
  const auto rename = [&](auto& labelled) {
    for (auto& one : labelled) {
      const auto found = ids.find(one.label);
      if (found != ids.end()) one.label = found->second;
    }
  };
  rename(place.graph.vertices);
  rename(place.cloud.points);
}

}  // namespace xview::tools
