// SPDX-License-Identifier: BSD-3-Clause
#include "places.h"

#include <fmt/core.h>
#include <pybind11/stl.h>

#include "classes.h"
#include "consistency_checks.h"
#include "xview/graph/edges.h"
#include "xview/io/graph_files.h"
#include "xview/label/shapes.h"
#include "xview/mapper.h"
#include "xview/measure_size.h"
#include "xview/raw_recording.h"
#include "xview/types/atomic_file.h"
#include "xview/types/error.h"

namespace xview::python {

std::shared_ptr<const Place> withEdges(const Place& place) {
  auto whole = std::make_shared<Place>();
  whole->labels = place.labels;
  whole->graph = place.graph;
  graph::makeEdges(whole->graph);
  return whole;
}

namespace {

/// A recording that others hold as well.
class SharedRecording final : public ForwardingSource {
 public:
  explicit SharedRecording(std::shared_ptr<FrameSource> source)
      : ForwardingSource(*source), source_(std::move(source)) {}

 private:
  std::shared_ptr<FrameSource> source_;
};

std::string pathText(const py::object& path) {
  return std::string(py::str(py::module_::import("os").attr("fspath")(path)));
}

io::InputOptions inputOptions(const std::string& labels, const std::string& frames,
                              const std::string& kind, const std::string& label_field,
                              const std::string& instance_field, const std::string& mount,
                              const std::string& topic, const std::string& odometry) {
  io::InputOptions input;
  input.kind = kind;
  input.labels = labels;
  input.label_field = label_field;
  input.instance_field = instance_field;
  input.mount = mount;
  input.topic = topic;
  input.odometry = odometry;
  if (!frames.empty()) input.frames = io::parseFrameRange(frames);
  return input;
}

Map loadMap(const py::object& path) {
  Map result;
  result.path = pathText(path);
  result.is_file = true;
  Stopwatch watch;
  result.map =
      released([&] { return std::make_shared<const map::SemanticMap>(map::loadMap(result.path)); });
  result.load_ms = watch.lap_ms();
  return result;
}

py::object readAny(const py::object& given, const io::InputOptions& options) {
  const std::string path = pathText(given);
  io::InputOptions input = options;
  Work work{Options()};
  switch (released([&] { return tools::chooseKind(path, input, work.job()); })) {
    case io::InputKind::map:
      return py::cast(loadMap(given));
    case io::InputKind::graph: {
      auto place =
          released([&] { return withEdges(tools::readLabelledGraph(path, input, work.job())); });
      work.takeNotes();
      return py::cast(Graph{path, options, std::move(place)});
    }
    default: {
      std::shared_ptr<FrameSource> source =
          released([&] { return io::openRecording(path, input); });
      work.takeNotes();
      return py::cast(Recording{path, options, std::move(source), {}});
    }
  }
}

const Frame readFrame(const Recording& recording, py::ssize_t index) {
  const auto size = static_cast<py::ssize_t>(recording.source->size());
  const py::ssize_t at = index < 0 ? index + size : index;
  if (at < 0 || at >= size)
    throw py::index_error(fmt::format("frame {} of a recording of {}", index, size));
  return released([&] { return recording.source->read(static_cast<std::size_t>(at)); });
}

std::shared_ptr<const LabelledCloud> cloudOf(const Recording& recording, py::ssize_t index) {
  Frame frame = readFrame(recording, index);
  if (frame.sensor == Sensor::camera)
    throw UsageError(recording.source->name() +
                     ": its frames are images: see depth(), label_image() and cloud()");
  return std::make_shared<const LabelledCloud>(std::move(frame.cloud));
}

template <class Pixel>
py::array imageOf(Image<Pixel> image) {
  const auto kept = std::make_shared<const Image<Pixel>>(std::move(image));
  const py::ssize_t height = kept->height, width = kept->width, bytes = sizeof(Pixel);
  return viewOf(kept->pixels.data(), {height, width}, {width * bytes, bytes}, kept);
}

std::vector<Eigen::Isometry3d> posesOf(const Recording& recording) {
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < recording.source->size(); ++i)
    poses.push_back(recording.source->pose(i));
  return poses;
}

py::tuple wholeCloud(const Recording& recording, double voxel_m, const py::kwargs& options) {
  Work work(optionsOf(options));
  auto cloud = released([&] {
    const std::unique_ptr<FrameSource> source =
        recording.path.empty() ? ownedSource(recording.source)
                               : tools::openInput(recording.path, recording.input, work.job());
    return std::make_shared<const LabelledCloud>(
        tools::liftAll(*withClasses(*source, work.job().options), work.job(), voxel_m));
  });
  work.takeNotes();
  return py::make_tuple(pointsOf(cloud), labelsOf(cloud));
}

void saveRecording(const Recording& recording, const py::object& folder, int threads) {
  const std::string path = pathText(folder);
  released([&] {
    io::writeRecording(path, *recording.source, recording.truth, threads,
                       [](std::size_t, std::size_t) { checkSignals(); });
    return 0;
  });
}

/// The recordings of what a map is built of, in its order.
std::vector<Source> partsOf(const Source& source) {
  const bool is_list =
      py::isinstance<py::list>(source.what) || py::isinstance<py::tuple>(source.what);
  if (!is_list || source.isArrays()) return {source};
  std::vector<Source> parts;
  for (const py::handle item : source.what) {
    Source part = source;
    part.what = py::reinterpret_borrow<py::object>(item);
    if (part.isArrays())
      throw UsageError("recordings, graphs and maps of a list cannot stand beside arrays");
    parts.push_back(std::move(part));
  }
  return parts;
}

map::SemanticMap mapOfGraph(const Graph& graph, Work& work) {
  return released([&] {
    return buildMap(graph.place->graph, graph.place->labels,
                    graph.path.empty() ? "graph" : graph.path, work.job().options);
  });
}

/// A recording with the classes that a map is made of. `labels` are those of the map that it is
/// added to, or of the first recording.
std::unique_ptr<FrameSource> placeSource(const Recording& recording, const LabelSet* labels,
                                         Work& work) {
  const tools::Job& job = work.job();
  io::InputOptions input = recording.input;
  if (labels != nullptr) input.map_labels = *labels;
  if (!recording.path.empty()) return tools::openPlaceInput(recording.path, input, job);
  auto source =
      withRolesByShape(ownedSource(recording.source), job.options.lift, job.options.threads);
  if (labels == nullptr || source->labels().empty() || source->labels() == *labels) return source;
  return tools::inClassesOfMap(std::move(source), input, job.narrate);
}

/// One map of all recordings, and one of each graph or map.
std::vector<map::SemanticMap> mapsOf(const Source& source, const LabelSet* added_to, Work& work) {
  std::vector<map::SemanticMap> maps;
  std::vector<Recording> recordings;
  for (const Source& part : partsOf(source)) {
    if (py::isinstance<Map>(part.what))
      maps.push_back(*part.what.cast<const Map&>().map);
    else if (py::isinstance<Graph>(part.what))
      maps.push_back(mapOfGraph(part.what.cast<const Graph&>(), work));
    else
      recordings.push_back(part.recording(added_to));
  }
  if (recordings.empty()) return maps;
  map::SemanticMap map = released([&] {
    std::vector<std::unique_ptr<FrameSource>> owned;
    std::vector<const FrameSource*> sources;
    for (const Recording& recording : recordings) {
      const LabelSet* labels = added_to != nullptr ? added_to
                               : owned.empty()     ? nullptr
                                                   : &owned.front()->labels();
      owned.push_back(placeSource(recording, labels, work));
      sources.push_back(owned.back().get());
    }
    return tools::mapOfRecordings(sources, work.job());
  });
  maps.insert(maps.begin(), std::move(map));
  return maps;
}

void requireBlobs(const map::SemanticMap& map) {
  if (!map.graph.empty() || map.bev.sampleCount() > 0 || map::pointCount(map) > 0) return;
  throw Error(map.sources.empty() ? "map" : map.sources.front(),
              "nothing to make a map of: no blob of any known class");
}

/// Adds to a map, and notes if the addition lies as if its frame were another one.
void add(const map::SemanticMap& part, const std::string& name, Work& work, map::SemanticMap& map) {
  tools::logConsistencyChecks(map, name, part, work.job().options, work.job().narrate);
  appendToMap(map, part, work.job().options);
}

Map build(const Source& source, const py::kwargs& arguments) {
  Work work(optionsOf(arguments));
  std::vector<map::SemanticMap> parts = mapsOf(source, nullptr, work);
  Map result;
  result.map = released([&] {
    auto map = std::make_shared<map::SemanticMap>(std::move(parts.front()));
    for (std::size_t i = 1; i < parts.size(); ++i)
      add(parts[i], map->sources.empty() ? "map" : map->sources.front(), work, *map);
    return map;
  });
  requireBlobs(*result.map);
  if (!result.map->sources.empty()) result.path = result.map->sources.front();
  result.notes = work.takeNotes();
  return result;
}

void append(Map& map, const Source& source, const py::kwargs& arguments) {
  Options options = optionsOf(arguments);
  options.size = sizeText(map.map->size);
  Work work(std::move(options));
  const std::vector<map::SemanticMap> parts = mapsOf(source, &map.map->labels, work);
  auto grown = released([&] {
    auto result = std::make_shared<map::SemanticMap>(*map.map);
    for (const map::SemanticMap& part : parts) add(part, map.path, work, *result);
    return result;
  });
  map.map = std::move(grown);
  map.is_file = false;
  map.notes = work.takeNotes();
}

void save(Map& map, const py::object& path) {
  const std::string file = pathText(path);
  released([&] {
    const map::MapLock lock(file);
    map::saveMap(file, *map.map);
    return 0;
  });
}

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
    graph::connectByRadius(place->graph, atSize(options, sizeFor(options, place->graph)).edges);
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

void bindRecording(py::module_& module) {
  py::class_<Recording>(module, "Recording",
                        "Frames of a file or folder, or of a simulated drive, in order. Frames are "
                        "read when they are asked for.")
      .def("__len__", [](const Recording& r) { return r.source->size(); })
      .def("__repr__",
           [](const Recording& r) {
             return fmt::format("<xview.Recording {}: {} frames>", r.source->name(),
                                r.source->size());
           })
      .def_property_readonly(
          "name", [](const Recording& r) { return r.source->name(); }, "The path as given.")
      .def_property_readonly(
          "sensor",
          [](const Recording& r) {
            const Sensor sensor = r.source->sensor();
            return sensor == Sensor::camera  ? "camera"
                   : sensor == Sensor::lidar ? "lidar"
                                             : "cloud";
          },
          "'camera' (depth and label images), 'lidar' (scans in the frame of the sensor) or "
          "'cloud' (clouds without a view-point).")
      .def_property_readonly(
          "classes", [](const Recording& r) { return namesOf(r.source->labels()); },
          "Class ids and names; empty if the recording has no labels.")
      .def_property_readonly(
          "notes", [](const Recording& r) { return r.source->notes(); },
          "What the reader guessed or left out, and why.")
      .def_property_readonly(
          "poses", [](const Recording& r) { return arrayOf(posesOf(r)); },
          "T_odom_sensor of all frames, float64 (N, 4, 4): p_odom = T @ p_sensor [m].")
      .def_property_readonly(
          "truth",
          [](const Recording& r) -> py::object {
            if (r.truth.empty()) return py::none();
            return arrayOf(r.truth);
          },
          "T_map_sensor of all frames of a simulated drive, float64 (N, 4, 4) [m], else None.")
      .def_property_readonly(
          "stamps",
          [](const Recording& r) {
            std::vector<double> stamps;
            for (std::size_t i = 0; i < r.source->size(); ++i) stamps.push_back(r.source->stamp(i));
            return py::array_t<double>(static_cast<py::ssize_t>(stamps.size()), stamps.data());
          },
          "Times of all frames, float64 (N,) [s].")
      .def(
          "points", [](const Recording& r, py::ssize_t i) { return pointsOf(cloudOf(r, i)); },
          py::arg("frame"),
          "Points of a frame, float32 (M, 3) in the frame of the sensor [m]; float64 if they are "
          "far from the origin.")
      .def(
          "labels", [](const Recording& r, py::ssize_t i) { return labelsOf(cloudOf(r, i)); },
          py::arg("frame"), "Class ids of the points of a frame, uint32 (M,).")
      .def(
          "depth", [](const Recording& r, py::ssize_t i) { return imageOf(readFrame(r, i).depth); },
          py::arg("frame"),
          "Depth image of a camera's frame, float32 (H, W), along the optical axis [m]; 0 = no "
          "measurement.")
      .def(
          "label_image",
          [](const Recording& r, py::ssize_t i) { return imageOf(readFrame(r, i).label); },
          py::arg("frame"), "Class ids of a camera's frame, uint16 (H, W).")
      .def("cloud", &wholeCloud, py::arg("voxel_m") = 0.1,
           "All frames as one cloud: points float32 (M, 3) in the odometry frame [m] and class ids "
           "uint32 (M,). One point per voxel and class; voxel_m = 0 keeps all.")
      .def("save", &saveRecording, py::arg("folder"), py::arg("threads") = 0,
           "Writes a sequence folder (camera) or a SemanticKITTI folder (scans), with "
           "groundtruth.txt if the truth is known. The folder appears whole or not at all.");
}

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

void bindMap(py::module_& module) {
  py::class_<Map>(module, "Map", "A place that is kept, to localize in. z is up.")
      .def_static(
          "build",
          [](const py::object& source, const py::object& labels, const py::object& poses,
             const py::object& stamps, const py::object& classes, const py::kwargs& options) {
            return build({source, labels, poses, stamps, classes}, options);
          },
          py::arg("source"), py::arg("labels") = py::none(), py::arg("poses") = py::none(),
          py::arg("stamps") = py::none(), py::arg("classes") = py::none(),
          "Of a Recording, a Graph, several of them in one frame, or of arrays: points (N, 3) "
          "float32 or float64 [m] in the frame of the map, or a list of them. labels: class ids "
          "(N,) that mean what `classes` says; without them classes come from the shapes of the "
          "points. poses: T_map_sensor (4, 4) per cloud, whose points are then in the frame of the "
          "sensor. Options are those of `xview map --help-all`, such as size='room' or "
          "blobs__min_points=20. Raises Error, UsageError.")
      .def_static("load", &loadMap, py::arg("path"), "Reads a .xvm file. Raises Error.")
      .def("save", &save, py::arg("path"), "Writes a .xvm file, whole or not at all. Raises Error.")
      .def(
          "append",
          [](Map& map, const py::object& source, const py::object& labels, const py::object& poses,
             const py::object& stamps, const py::object& classes, const py::kwargs& options) {
            append(map, {source, labels, poses, stamps, classes}, options);
          },
          py::arg("source"), py::arg("labels") = py::none(), py::arg("poses") = py::none(),
          py::arg("stamps") = py::none(), py::arg("classes") = py::none(),
          "Adds what build() takes, in the frame of the map. A Localizer made before is not "
          "changed. Raises Error with the map as it was.")
      .def("__repr__",
           [](const Map& m) {
             return fmt::format("<xview.Map {}: {} vertices, {} key frames, {} points>", m.path,
                                m.map->graph.size(), m.map->poses.size(), m.map->cloud.size());
           })
      .def_property_readonly(
          "path", [](const Map& m) { return m.path; }, "The file, or what it was built of first.")
      .def_property_readonly(
          "sources", [](const Map& m) { return m.map->sources; }, "What it was built of.")
      .def_property_readonly(
          "size", [](const Map& m) { return sizeText(m.map->size); },
          "'town', 'room', 'desk', or the typical spacing of neighbouring things [m].")
      .def_property_readonly(
          "classes", [](const Map& m) { return namesOf(m.map->labels); }, "Class ids and names.")
      .def_property_readonly(
          "graph",
          [](const Map& m) {
            return Graph{"", {}, released([&] { return withEdges(*m.map); })};
          },
          "Its things.")
      .def_property_readonly(
          "points",
          [](const Map& m) {
            return pointsOf(std::shared_ptr<const LabelledCloud>(m.map, &m.map->cloud));
          },
          "Its thinned cloud, (M, 3) [m], float64 where it lies far from the origin.")
      .def_property_readonly(
          "labels",
          [](const Map& m) {
            return labelsOf(std::shared_ptr<const LabelledCloud>(m.map, &m.map->cloud));
          },
          "Class ids of its points, uint32 (M,).")
      .def_property_readonly(
          "poses", [](const Map& m) { return arrayOf(m.map->poses); },
          "T_map_sensor of its key frames, float64 (K, 4, 4) [m].")
      .def_property_readonly(
          "notes", [](const Map& m) { return m.notes; },
          "What was guessed or left out when it was made.");
}

}  // namespace

bool Source::isArrays() const {
  if (py::isinstance<Recording>(what) || py::isinstance<Graph>(what) || py::isinstance<Map>(what))
    return false;
  if (!py::isinstance<py::list>(what) && !py::isinstance<py::tuple>(what)) return true;
  const auto items = what.cast<py::sequence>();
  return items.size() == 0 || Source{items[0], {}, {}, {}, {}}.isArrays();
}

Recording Source::recording(const LabelSet* known) const {
  if (py::isinstance<Recording>(what)) {
    if (!labels.is_none() || !poses.is_none() || !stamps.is_none() || !classes.is_none())
      throw UsageError(
          "labels, poses, stamps and classes belong to arrays; a recording has its own");
    return what.cast<Recording>();
  }
  if (labels.is_none() && !classes.is_none()) throw UsageError("classes without labels");
  LabelSet set;
  if (!labels.is_none() && !classes.is_none())
    set = labelSetOf(classes);
  else if (!labels.is_none())
    set = known != nullptr && !known->empty() ? *known : genericLabelSet(idsIn(labels));
  Recording recording;
  recording.source = recordingOf(what, labels, poses, stamps, set);
  return recording;
}

std::unique_ptr<FrameSource> ownedSource(std::shared_ptr<FrameSource> source) {
  return std::make_unique<SharedRecording>(std::move(source));
}

tools::QueryInput queryOf(const Source& source, const LabelSet& map_labels, double last_m,
                          Work& work) {
  const auto readFile = [&](const std::string& path, const io::InputOptions& input) {
    return released([&] {
      return tools::readQuery(path, tools::InputFlags(input), work.job(), map_labels, last_m);
    });
  };
  tools::QueryInput result;
  io::InputOptions in_map;
  in_map.map_labels = map_labels;
  const auto takePlace = [&](const std::string& name, Place place) {
    result.path = name;
    result.whole = tools::inClassesOfMap(name, std::move(place), in_map, work.job().narrate);
    result.labels = result.whole->labels;
  };
  if (py::isinstance<Map>(source.what)) {
    const auto& map = source.what.cast<const Map&>();
    if (map.is_file) return readFile(map.path, {});
    takePlace(map.path.empty() ? "map" : map.path, makeQuery(*map.map, work.job().options));
    return result;
  }
  if (py::isinstance<Graph>(source.what)) {
    const auto& graph = source.what.cast<const Graph&>();
    if (!graph.path.empty()) return readFile(graph.path, graph.input);
    takePlace("graph", makeQuery(graph.place->graph, graph.place->labels, work.job().options));
    return result;
  }
  const Recording recording = source.recording(&map_labels);
  if (!recording.path.empty()) return readFile(recording.path, recording.input);
  result = openRecording(recording, map_labels, work);
  return released([&] {
    tools::FrameReport report(*result.source, work.job().narrate);
    result.whole = makeQuery(*result.source, work.job().options,
                             [&](const PreprocessedFrame& frame) { report.add(frame); });
    report.say();
    result.labels = result.whole->labels;
    return std::move(result);
  });
}

tools::QueryInput openRecording(const Recording& recording, const LabelSet& map_labels,
                                Work& work) {
  return released([&] {
    if (!recording.path.empty())
      return tools::openQuery(recording.path, tools::InputFlags(recording.input), work.job(),
                              map_labels);
    tools::QueryInput input;
    input.path = recording.source->name();
    const LabelSet& own = recording.source->labels();
    if (own.empty() || (knowsShapesOnly(map_labels) && !knowsShapesOnly(own)))
      input.source = withShapeLabels(ownedSource(recording.source), label::labelsOfShapes(),
                                     work.job().options.lift);
    else
      input.source = placeSource(recording, &map_labels, work);
    input.labels = input.source->labels();
    return input;
  });
}

void bindPlaces(py::module_& module) {
  bindRecording(module);
  bindGraph(module);
  bindMap(module);
  module.def(
      "read",
      [](const py::object& path, const std::string& labels, const std::string& frames,
         const std::string& kind, const std::string& label_field, const std::string& instance_field,
         const std::string& mount, const std::string& topic, const std::string& odometry) {
        return readAny(path, inputOptions(labels, frames, kind, label_field, instance_field, mount,
                                          topic, odometry));
      },
      py::arg("path"), py::kw_only(), py::arg("labels") = "", py::arg("frames") = "",
      py::arg("kind") = "", py::arg("label_field") = "", py::arg("instance_field") = "",
      py::arg("mount") = "", py::arg("topic") = "", py::arg("odometry") = "",
      "Anything that `xview localize` takes: a Recording, a Graph, or a Map. labels: a shipped "
      "label set by name, a classes.yaml by path, or 'shapes'. frames: 'A:B[:STEP]', half-open. "
      "topic, odometry: of a bag; empty = look. "
      "Raises Error with path and place.");
  module.def("load_map", &loadMap, py::arg("path"), "Reads a .xvm file. Raises Error.");
}

}  // namespace xview::python
