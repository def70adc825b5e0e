// SPDX-License-Identifier: BSD-3-Clause
// Two places in one frame become one: their graphs, and their BEV grids.
#include <algorithm>
#include <cmath>
#include <string>

#include "base/cells.h"
#include "place/bev_grid.h"
#include "place/merge.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr float kSameObject_m = 1.0f;

/// The items of a sorted list between two rows.
template <class Item>
std::pair<std::size_t, std::size_t> rowsBetween(const std::vector<Item>& items, double low,
                                                double high) {
  const auto begin =
      std::partition_point(items.begin(), items.end(), [&](const Item& i) { return i.y < low; });
  const auto end =
      std::partition_point(begin, items.end(), [&](const Item& i) { return i.y <= high; });
  return {static_cast<std::size_t>(begin - items.begin()),
          static_cast<std::size_t>(end - items.begin())};
}

/// visit(index) for the items of a sorted list that lie not farther than `margin` from the box of
/// the addition: what is farther away does not meet it, however large the map is.
template <class Item, class Visit>
void forItemsAround(const std::vector<Item>& addition, double margin,
                    const std::vector<Item>& items, const Visit& visit) {
  if (addition.empty()) return;
  double low_x = addition[0].x, high_x = low_x, low_y = addition[0].y, high_y = low_y;
  for (const Item& item : addition) {
    low_x = std::min<double>(low_x, item.x);
    high_x = std::max<double>(high_x, item.x);
    low_y = std::min<double>(low_y, item.y);
    high_y = std::max<double>(high_y, item.y);
  }
  const auto [begin, end] = rowsBetween(items, low_y - margin, high_y + margin);
  for (std::size_t i = begin; i < end; ++i) {
    if (items[i].x >= low_x - margin && items[i].x <= high_x + margin) visit(i);
  }
}

/// Sorts what was appended to a sorted list into it.
template <class Item>
void sortIn(std::size_t sorted, std::vector<Item>& items) {
  const auto middle = items.begin() + static_cast<std::ptrdiff_t>(sorted);
  std::sort(middle, items.end(), InRowOrder());
  std::inplace_merge(items.begin(), middle, items.end(), InRowOrder());
}

/// Returns the cells that `view` had measured before, where the addition lies.
CellIndex addKnown(BevGrid& view, const std::vector<GroundCell>& addition) {
  CellIndex index, measured_before;
  std::vector<std::size_t> at;  // in view.known, by the numbers of `index`
  forItemsAround(addition, 0, view.known, [&](std::size_t i) {
    const GroundCell& cell = view.known[i];
    index.findOrAdd(cell.x, cell.y);
    at.push_back(i);
    if (cell.measured) measured_before.findOrAdd(cell.x, cell.y);
  });
  const std::size_t before = view.known.size();
  for (const GroundCell& cell : addition) {
    const auto number = static_cast<std::size_t>(index.findOrAdd(cell.x, cell.y));
    if (number == at.size()) {
      at.push_back(view.known.size());
      view.known.push_back(cell);
    } else if (cell.measured && !view.known[at[number]].measured) {
      view.known[at[number]] = cell;
    }
  }
  sortIn(before, view.known);
  return measured_before;
}

PlaneCell bevCellOf(const BevSample& s, double side) {
  return {floorToInt(s.x / side), floorToInt(s.y / side)};
}

/// One sample per cell, the one that was there first; none in cells that are `taken`. Borders lie
/// on the edges of cells, so that two of them may meet in one cell, but not in one quarter of it.
void addSurface(BevChannel channel, BevGrid& view, const std::vector<BevSample>& addition,
                const CellIndex* taken) {
  std::vector<BevSample>& samples = view[channel];
  const double side = isBorder(channel) ? view.cell_m / 2 : view.cell_m;
  CellIndex occupied;
  const auto occupy = [&](const BevSample& s) {
    const PlaneCell c = bevCellOf(s, side);
    const std::size_t before = occupied.size();
    occupied.findOrAdd(c.x, c.y);
    return occupied.size() > before;
  };
  forItemsAround(addition, view.cell_m, samples, [&](std::size_t i) { occupy(samples[i]); });
  for (const BevSample& s : addition) {
    const PlaneCell c = bevCellOf(s, view.cell_m);
    if (taken && taken->find(c.x, c.y) >= 0) continue;
    if (occupy(s)) samples.push_back(s);
  }
}

void addObjects(std::vector<BevSample>& samples, const std::vector<BevSample>& addition) {
  const auto cellOfObject = [](const BevSample& s) {
    return cellOf(Eigen::Vector3d(s.x, s.y, 0), kSameObject_m, 0);
  };
  CellLists known;
  forItemsAround(addition, 2 * kSameObject_m, samples,
                 [&](std::size_t i) { known.add(cellOfObject(samples[i]), i); });
  for (const BevSample& s : addition) {
    const bool is_known = known.anyAround(cellOfObject(s), [&](std::size_t i) {
      return std::hypot(samples[i].x - s.x, samples[i].y - s.y) <= kSameObject_m;
    });
    if (!is_known) samples.push_back(s);
  }
}

/// The addition in the coordinates of the view; origins differ by whole cells.
BevGrid shifted(const BevGrid& addition, const BevGrid& view) {
  BevGrid result = addition;
  const auto dx = static_cast<float>(addition.origin_x - view.origin_x),
             dy = static_cast<float>(addition.origin_y - view.origin_y),
             dz = static_cast<float>(addition.origin_z - view.origin_z);
  for (auto& channel : result.samples) {
    for (BevSample& s : channel) s = {s.x + dx, s.y + dy, s.z + dz};
  }
  const auto cx = static_cast<std::int32_t>(std::lround(dx / view.cell_m)),
             cy = static_cast<std::int32_t>(std::lround(dy / view.cell_m));
  for (GroundCell& cell : result.known) {
    cell.x += cx;
    cell.y += cy;
    cell.z += dz;
  }
  return result;
}

/// The mean of both, weighted by how often each was seen.
void joinVertex(Vertex& vertex, const Vertex& other) {
  const double a = vertex.observations, b = other.observations, share = b / std::max(1.0, a + b);
  vertex.position += share * (other.position - vertex.position);
  vertex.extent += share * (other.extent - vertex.extent);
  vertex.sigma_m = std::sqrt((1 - share) * vertex.sigma_m * vertex.sigma_m +
                             share * other.sigma_m * other.sigma_m);
  vertex.observations += other.observations;
  vertex.points += other.points;
}

}  // namespace

void mergeBevGrids(BevGrid& view, const BevGrid& addition) {
  if (addition.known.empty()) return;
  if (view.known.empty()) {
    view = addition;
    return;
  }
  if (view.cell_m != addition.cell_m)
    throw UsageError("the views from above of the map and of what is added to it have cells of " +
                     std::to_string(view.cell_m) + " and " + std::to_string(addition.cell_m) +
                     " m; they cannot be joined");
  const BevGrid moved = shifted(addition, view);
  const CellIndex measured_before = addKnown(view, moved.known);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const auto channel = static_cast<BevChannel>(c);
    const std::size_t before = view.samples[c].size();
    const bool is_ground = isArea(channel) || isBorder(channel);
    if (isObject(channel))
      addObjects(view.samples[c], moved.samples[c]);
    else
      addSurface(channel, view, moved.samples[c], is_ground ? &measured_before : nullptr);
    sortIn(before, view.samples[c]);
  }
}

void mergeGraphs(SemanticGraph& graph, const SemanticGraph& addition, const LabelSet& labels,
                 const MergeOptions& options, const EdgeOptions& edge_options) {
  if (graph.empty()) graph.space = addition.space;
  const bool in_images = graph.space == GraphSpace::image;
  const double surface_m = in_images ? options.first_observation_m : options.surface_m / 2;
  CellLists vertices_of_cell;
  const auto reachOf = [&](const Vertex& v) {
    return labels.role(v.label) == Role::surface ? surface_m : options.object_m;
  };
  const auto cellOfVertex = [&](const Vertex& v) {
    return cellOf(v.position, std::max(surface_m, options.object_m), v.label);
  };
  Eigen::AlignedBox3d near;  // what is outside of it cannot meet the addition
  const double margin_m = std::max(surface_m, options.object_m);
  for (const Vertex& v : addition.vertices) near.extend(v.position);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Vertex& v = graph.vertices[i];
    if (near.squaredExteriorDistance(v.position) <= margin_m * margin_m)
      vertices_of_cell.add(cellOfVertex(v), i);
  }
  std::vector<std::uint32_t> now_at;  // of the vertices of the addition
  for (const Vertex& v : addition.vertices) {
    std::size_t nearest = graph.size();
    double distance = reachOf(v);
    vertices_of_cell.forAround(cellOfVertex(v), [&](std::size_t i) {
      const double d = (graph.vertices[i].position - v.position).norm();
      if (d > distance) return;
      distance = d;
      nearest = i;
    });
    now_at.push_back(static_cast<std::uint32_t>(nearest));
    if (nearest < graph.size())
      joinVertex(graph.vertices[nearest], v);
    else
      graph.vertices.push_back(v);
  }
  if (!in_images) return useRadius(graph, edge_options);
  BlobEdges edges = graph.edges();
  for (const auto& [a, b] : addition.edges()) edges.emplace_back(now_at[a], now_at[b]);
  graph.setEdges(edges);
}

}  // namespace xview
