// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/scene.h"

#include <set>

namespace xview {
namespace {

void collect(const SemanticGraph* graph, std::set<std::uint32_t>& ids) {
  if (graph == nullptr) return;
  for (const Vertex& v : graph->vertices) ids.insert(v.label);
}

void collect(const LabelledCloud* cloud, std::set<std::uint32_t>& ids) {
  if (cloud == nullptr) return;
  for (const auto& p : cloud->points) ids.insert(p.label);
}

}  // namespace

Color statusColor(Status status) {
  switch (status) {
    case Status::accepted:
      return {22, 130, 60};
    case Status::ambiguous:
      return {214, 130, 0};
    case Status::rejected:
      return {200, 40, 40};
  }
  return {128, 128, 128};
}

std::vector<std::uint32_t> classesIn(const Scene& scene) {
  std::set<std::uint32_t> ids;
  collect(scene.map_graph, ids);
  collect(scene.map_cloud, ids);
  for (const SceneQuery& query : scene.queries) {
    collect(query.graph, ids);
    collect(query.cloud, ids);
  }
  std::vector<std::uint32_t> present;
  for (const std::uint32_t id : ids) {
    const bool ignored = scene.labels != nullptr && scene.labels->find(id) != nullptr &&
                         scene.labels->role(id) == Role::ignored;
    if (!ignored) present.push_back(id);
  }
  return present;
}

}  // namespace xview
