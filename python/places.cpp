// SPDX-License-Identifier: BSD-3-Clause
#include "places.h"

#include <pybind11/stl.h>

#include "classes.h"
#include "place/raw_recording.h"
#include "place/shapes.h"
#include "xview/base/error.h"

namespace xview::python {
namespace {

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
  return std::make_unique<ForwardingSource>(std::move(source));
}

std::unique_ptr<FrameSource> placeSource(const Recording& recording, const LabelSet* labels,
                                         Work& work) {
  const tools::Job& job = work.job();
  io::InputOptions input = recording.input;
  if (labels != nullptr) input.map_labels = *labels;
  if (!recording.path.empty()) return tools::openPlaceInput(recording.path, input, job);
  auto source = withRolesByShape(ownedSource(recording.source), job.options.lift,
                                 job.options.threads, labels);
  if (labels == nullptr || source->labels().empty() || source->labels() == *labels) return source;
  return tools::inClassesOfMap(std::move(source), input);
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
    tools::tellHowClassesMeet(name, place, in_map, work.job().narrate);
    result.whole = std::move(place);
    result.labels = result.whole->labels;
  };
  if (py::isinstance<Map>(source.what)) {
    auto& map = source.what.cast<Map&>();
    if (map.is_file) return readFile(map.path, {});
    takePlace(map.path.empty() ? "map" : map.path, makeQuery(unpacked(map), work.job().options));
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
    tools::FrameReport report(*result.source, work.job().narrate, result.inMap());
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
      input.source =
          withShapeLabels(ownedSource(recording.source), labelsOfShapes(), work.job().options);
    else
      input.source = withRolesByShape(ownedSource(recording.source), work.job().options.lift,
                                      work.job().options.threads, &map_labels);
    input.labels = input.source->labels();
    input.options.map_labels = map_labels;
    if (!knowsShapesOnly(input.labels))
      tools::tellHowClassesMeet(input.path, input.labels, input.options, work.job().narrate);
    return input;
  });
}

void bindPlaces(py::module_& module) {
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
}

}  // namespace xview::python
