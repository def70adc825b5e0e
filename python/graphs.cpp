// SPDX-License-Identifier: BSD-3-Clause
#include "places.h"

#include <fmt/core.h>
#include <pybind11/stl.h>

#include "io/graph_files.h"
#include "place/edges.h"
#include "place/measure_size.h"
#include "xview/base/error.h"

namespace xview::python {
std::shared_ptr<const Place> withEdges(const Place& place) {
  auto whole = std::make_shared<Place>();
  whole->labels = place.labels;
  whole->graph = place.graph;
  makeEdges(whole->graph);
  return whole;
}

namespace {

std::shared_ptr<const SemanticGraph> graphIn(const Graph& graph) {
  return {graph.place, &graph.place->graph};
}

py::array positionsOf(std::shared_ptr<const SemanticGraph> graph) {
  const auto count = static_cast<py::ssize_t>(graph->size());
  const double* first = count > 0 ? graph->vertices[0].position.data() : nullptr;
  return viewOf(first, {count, 3}, {sizeof(Vertex), sizeof(double)}, graph);
}
py::array extentsOf(std::shared_ptr<const SemanticGraph> graph) {
  const auto count = static_cast<py::ssize_t>(graph->size());
  const double* first = count > 0 ? graph->vertices[0].extent.data() : nullptr;
  return viewOf(first, {count, 3}, {sizeof(Vertex), sizeof(double)}, graph);
}
py::array vertexLabelsOf(std::shared_ptr<const SemanticGraph> graph) {
  const auto count = static_cast<py::ssize_t>(graph->size());
  const std::uint32_t* first = count > 0 ? &graph->vertices[0].label : nullptr;
  return viewOf(first, {count}, {sizeof(Vertex)}, graph);
}
py::array_t<std::uint32_t> edgesOf(const SemanticGraph& graph) {
  const auto edges = graph.edges();
  py::array_t<std::uint32_t> array({static_cast<py::ssize_t>(edges.size()), py::ssize_t{2}});
  auto values = array.mutable_unchecked<2>();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    values(static_cast<py::ssize_t>(i), 0) = edges[i].first;
    values(static_cast<py::ssize_t>(i), 1) = edges[i].second;
  }
  return array;
}

Graph makeGraph(const py::array_t<double, py::array::c_style | py::array::forcecast>& positions,
                const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>& labels,
                const py::object& edges, const py::object& classes, const py::kwargs& arguments) {
  if (positions.ndim() != 2 || positions.shape(1) != 3)
    throw UsageError("positions: expected the shape (V, 3)");
  if (labels.ndim() != 1 || labels.shape(0) != positions.shape(0))
    throw UsageError("labels: expected one class id per position");
  auto place = std::make_shared<Place>();
  const auto p = positions.unchecked<2>();
  const auto ids = labels.unchecked<1>();
  for (py::ssize_t i = 0; i < p.shape(0); ++i) {
    Vertex vertex;
    vertex.position = {p(i, 0), p(i, 1), p(i, 2)};
    if (!vertex.position.allFinite())
      throw UsageError(fmt::format("positions[{}] is not finite", i));
    vertex.label = static_cast<std::uint32_t>(std::max<std::int64_t>(0, ids(i)));
    place->graph.vertices.push_back(vertex);
  }
  place->labels = classes.is_none() ? genericLabelSet(idsIn(labels)) : labelSetOf(classes);
  place->graph.setEdges({});
  const Options options = optionsOf(arguments);
  if (edges.is_none()) {
    connectByRadius(place->graph, atSize(options, sizeFor(options, place->graph)).edges);
  } else {
    const auto pairs =
        py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(edges);
    if (!pairs || pairs.ndim() != 2 || pairs.shape(1) != 2)
      throw UsageError("edges: expected the shape (E, 2)");
    std::vector<std::pair<std::uint32_t, std::uint32_t>> list;
    const auto values = pairs.unchecked<2>();
    for (py::ssize_t i = 0; i < values.shape(0); ++i) {
      for (int side = 0; side < 2; ++side) {
        if (values(i, side) < 0 || values(i, side) >= p.shape(0))
          throw UsageError(
              fmt::format("edges[{}] names vertex {} of {}", i, values(i, side), p.shape(0)));
      }
      list.emplace_back(values(i, 0), values(i, 1));
    }
    place->graph.setEdges(list);
  }
  return {"", {}, std::move(place)};
}

}  // namespace

void bindGraph(py::module_& module) {
  py::class_<Graph>(module, "Graph",
                    "A semantic graph: things with a class and a place, and edges "
                    "between neighbours.")
      .def(py::init(&makeGraph), py::arg("positions"), py::arg("labels"),
           py::arg("edges") = py::none(), py::arg("classes") = py::none(),
           "Of arrays: positions (V, 3) [m], class ids (V,), and edges (E, 2) of vertex indices; "
           "without edges those within edges__radius_m of one another are joined. classes: a "
           "shipped label set by name, a classes.yaml by path, or {id: name}.")
      .def("__len__", [](const Graph& g) { return g.place->graph.size(); })
      .def("__repr__",
           [](const Graph& g) {
             return fmt::format("<xview.Graph: {} vertices, {} edges>", g.place->graph.size(),
                                g.place->graph.edgeCount());
           })
      .def_property_readonly(
          "positions", [](const Graph& g) { return positionsOf(graphIn(g)); },
          "Places of the vertices, float64 (V, 3) [m].")
      .def_property_readonly(
          "extents", [](const Graph& g) { return extentsOf(graphIn(g)); },
          "Sizes of their axis-aligned boxes, float64 (V, 3) [m].")
      .def_property_readonly(
          "labels", [](const Graph& g) { return vertexLabelsOf(graphIn(g)); },
          "Their class ids, uint32 (V,).")
      .def_property_readonly(
          "edges", [](const Graph& g) { return edgesOf(g.place->graph); },
          "Each edge once, uint32 (E, 2): vertex indices, the smaller one first.")
      .def_property_readonly(
          "classes", [](const Graph& g) { return namesOf(g.place->labels); },
          "Class ids and names.")
      .def(
          "save",
          [](const Graph& g, const py::object& path) {
            io::writeGraph(pathText(path), g.place->graph, g.place->labels);
          },
          py::arg("path"), "Writes a .ply that opens in any mesh viewer.");
}

}  // namespace xview::python
