// SPDX-License-Identifier: BSD-3-Clause
#include "places.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <filesystem>

#include "consistency_checks.h"
#include "map/contents.h"
#include "map_changes.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "xview/mapper.h"

namespace xview::python {
namespace {

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
    const auto use =
        added_to != nullptr ? tools::RecordingsUse::addition : tools::RecordingsUse::map;
    return tools::mapOfRecordings(sources, work.job(), use);
  });
  maps.insert(maps.begin(), std::move(map));
  return maps;
}

void requireBlobs(const map::SemanticMap& map) {
  if (!map.graph.empty() || map.bev.sampleCount() > 0 || map::countsOf(map).points > 0) return;
  throw Error(map.sources.empty() ? "map" : map.sources.front(),
              "nothing to make a map of: no blob of any known class");
}

Map build(const Source& source, const py::kwargs& arguments) {
  Work work(optionsOf(arguments));
  std::vector<map::SemanticMap> parts = mapsOf(source, nullptr, work);
  Map result;
  result.map = released([&] {
    auto map = std::make_shared<map::SemanticMap>(std::move(parts.front()));
    for (std::size_t i = 1; i < parts.size(); ++i) {
      tools::logConsistencyChecks(*map, map->sources.empty() ? "map" : map->sources.front(),
                                  parts[i], work.job().options, work.job().narrate);
      appendToMap(*map, parts[i], work.job().options);
    }
    return map;
  });
  requireBlobs(*result.map);
  if (!result.map->sources.empty()) result.path = result.map->sources.front();
  result.notes = work.takeNotes();
  return result;
}

/// Clouds of arrays have one name; on record each has its own.
void nameApart(const map::SemanticMap& map, map::SemanticMap& part) {
  const auto isTaken = [&](const std::string& name) {
    return std::find(map.sources.begin(), map.sources.end(), name) != map.sources.end();
  };
  for (std::string& source : part.sources) {
    const std::string name = source;
    for (int i = 2; name == kArrays && isTaken(source); ++i) source = fmt::format("{} {}", name, i);
  }
}

void requireFits(const map::SemanticMap& map, const std::string& name, const map::SemanticMap& part,
                 const Options& options) {
  const auto objection = tools::objectionTo(part, map, name, options);
  if (!objection) return;
  throw Error(
      part.sources.empty() ? "the addition" : part.sources.front(),
      *objection + (objection->back() == '?' ? " " : "; ") + "force=True adds it all the same");
}

void append(Map& map, const Source& source, bool force, const py::kwargs& arguments) {
  Options options = optionsOf(arguments);
  options.size = sizeText(map.map->size);
  Work work(std::move(options));
  std::vector<map::SemanticMap> parts = mapsOf(source, &map.map->labels, work);
  std::vector<Map::Addition> added = map.added;
  auto grown = released([&] {
    auto result = std::make_shared<map::SemanticMap>(*map.map);
    for (map::SemanticMap& part : parts) {
      nameApart(*result, part);
      if (!force) requireFits(*result, map.path, part, work.job().options);
      appendToMap(*result, part, work.job().options);
      std::string note = fmt::format("appended {}", fmt::join(part.sources, ", "));
      added.push_back({std::move(note), {std::move(part), 0}, work.job().options});
    }
    return result;
  });
  if (map.added.empty()) map.begun = map.map;
  map.added = std::move(added);
  map.map = std::move(grown);
  map.is_file = false;
  map.notes = work.takeNotes();
}

std::optional<std::filesystem::file_time_type> timeOf(const std::string& file) {
  std::error_code failed;
  const auto time = std::filesystem::last_write_time(file, failed);
  return failed ? std::nullopt : std::optional(time);
}

/// With what was appended on record, as `xview map --append` has it, behind the record of the file
/// that it was read from, unless that has changed since.
void writeWithRecord(const Map& map, const std::string& file) {
  const bool is_from_file = !map.file.empty() && timeOf(map.file) == map.file_time;
  tools::MapDraft draft =
      is_from_file ? tools::MapDraft(file, map.file) : tools::MapDraft(file, *map.begun);
  map::SemanticMap grown;  // before the last addition, of which *map.map is the outcome
  if (map.added.size() > 1) grown = is_from_file ? map::openMap(map.file) : *map.begun;
  for (std::size_t i = 0; i < map.added.size(); ++i) {
    const Map::Addition& addition = map.added[i];
    const bool is_last = i + 1 == map.added.size();
    if (!is_last) appendToMap(grown, addition.visit.place, addition.options);
    draft.add(is_last ? *map.map : grown, addition.note, addition.visit);
  }
  draft.commit();
}

void save(Map& map, const py::object& path) {
  const std::string file = pathText(path);
  released([&] {
    const map::MapLock lock(file);
    if (map.added.empty())
      map::saveMap(file, *map.map);
    else
      writeWithRecord(map, file);
    return 0;
  });
  map.added.clear();
  map.begun.reset();
  map.file = file;
  map.file_time = timeOf(file).value();
}

}  // namespace

Map loadMap(const py::object& path) {
  Map result;
  result.path = pathText(path);
  result.is_file = true;
  result.file = result.path;
  result.file_time = timeOf(result.file).value_or(std::filesystem::file_time_type());
  Stopwatch watch;
  result.map =
      released([&] { return std::make_shared<const map::SemanticMap>(map::openMap(result.path)); });
  result.load_ms = watch.lap_ms();
  return result;
}

const map::SemanticMap& unpacked(Map& map) {
  if (map::isPacked(*map.map)) {
    map.map =
        released([&] { return std::make_shared<const map::SemanticMap>(map::unpacked(*map.map)); });
  }
  return *map.map;
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
             const py::object& stamps, const py::object& classes, bool force,
             const py::kwargs& options) {
            append(map, {source, labels, poses, stamps, classes}, force, options);
          },
          py::arg("source"), py::arg("labels") = py::none(), py::arg("poses") = py::none(),
          py::arg("stamps") = py::none(), py::arg("classes") = py::none(), py::kw_only(),
          py::arg("force") = false,
          "Adds what build() takes, in the frame of the map. What contradicts the map, lies far "
          "from it or is in it already is refused unless force is true. A Localizer made before is "
          "not changed. save() puts it on record: `xview map --undo` takes it back. Raises Error "
          "with the map as it was.")
      .def("__repr__",
           [](const Map& m) {
             return fmt::format("<xview.Map {}: {}>", m.path, tools::contentsText(*m.map));
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
          [](Map& m) {
            const map::SemanticMap& whole = unpacked(m);
            auto place = released([&] { return withEdges(whole); });
            return Graph{"", {}, std::move(place)};
          },
          "Its things.")
      .def_property_readonly(
          "points",
          [](Map& m) {
            const LabelledCloud& cloud = unpacked(m).cloud;
            return pointsOf(std::shared_ptr<const LabelledCloud>(m.map, &cloud));
          },
          "Its thinned cloud, (M, 3) [m], float64 where it lies far from the origin.")
      .def_property_readonly(
          "labels",
          [](Map& m) {
            const LabelledCloud& cloud = unpacked(m).cloud;
            return labelsOf(std::shared_ptr<const LabelledCloud>(m.map, &cloud));
          },
          "Class ids of its points, uint32 (M,).")
      .def_property_readonly(
          "poses", [](const Map& m) { return arrayOf(m.map->poses); },
          "T_map_sensor of its key frames, float64 (K, 4, 4) [m].")
      .def_property_readonly(
          "notes", [](const Map& m) { return m.notes; },
          "What was guessed or left out when it was made.");
  module.def("load_map", &loadMap, py::arg("path"), "Reads a .xvm file. Raises Error.");
}

}  // namespace xview::python
