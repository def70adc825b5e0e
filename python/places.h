// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "inputs.h"
#include "work.h"
#include "xview/io/recording.h"
#include "xview/map/semantic_map.h"

namespace xview::python {

/// Frames of a file or folder, of arrays, or of a simulated drive.
struct Recording {
  std::string path;        ///< of the file or folder; empty if it is in memory
  io::InputOptions input;  ///< how that is read
  std::shared_ptr<FrameSource> source;
  std::vector<Eigen::Isometry3d> truth;  ///< T_map_sensor per frame, if it is known
};

/// A bare graph.
struct Graph {
  std::string path;                    ///< of the file; empty if it is in memory
  io::InputOptions input;              ///< how that is read
  std::shared_ptr<const Place> place;  ///< its labels and its graph
};

/// Graph and labels of a place, with its edges made.
std::shared_ptr<const Place> withEdges(const Place& place);

/// A map, which may be in a file. What is appended makes another one, so that whoever localizes in
/// the former is not disturbed.
struct Map {
  std::shared_ptr<const map::SemanticMap> map;  ///< of a file as map::openMap() has it
  std::string path;                             ///< that it was read from, or built of
  bool is_file = false;                         ///< the path holds what `map` is
  double load_ms = 0;
  std::vector<std::string> notes;

  /// What was appended since, for the record of the file that it is saved to.
  struct Addition {
    std::string note;
    map::Visit visit;
    Options options;
  };
  std::vector<Addition> added;
  std::shared_ptr<const map::SemanticMap> begun;  ///< before the first of them
  std::string file;  ///< that holds `begun` and how it came to be; empty if none does
  std::filesystem::file_time_type file_time;  ///< of it then
};

Map loadMap(const py::object& path);
/// Its content with nothing packed. Called with the interpreter's lock. Throws Error.
const map::SemanticMap& unpacked(Map& map);

/// What localize, Map.build, Map.append and graph take: a Recording, a Graph, a Map, or arrays with
/// what belongs to them.
struct Source {
  py::object what, labels, poses, stamps, classes;

  bool isArrays() const;
  /// The clouds of arrays. Ids of labels mean what `classes` says, else what `known` says; without
  /// either they are bare ids.
  Recording recording(const LabelSet* known) const;
};

/// A query of anything, in a map of these classes. Called with the interpreter's lock, which is let
/// go of while frames are read.
tools::QueryInput queryOf(const Source& source, const LabelSet& map_labels, double last_m,
                          Work& work);

/// A recording whose frames have classes for a map of these, but are not read yet.
tools::QueryInput openRecording(const Recording& recording, const LabelSet& map_labels, Work& work);

/// A recording with the classes that a map is made of. `labels` are those of the map that it is
/// added to, or of the first recording.
std::unique_ptr<FrameSource> placeSource(const Recording& recording, const LabelSet* labels,
                                         Work& work);

/// The recording as an owner of its own, for functions that take one over.
std::unique_ptr<FrameSource> ownedSource(std::shared_ptr<FrameSource> source);

void bindRecording(py::module_& module);
void bindGraph(py::module_& module);
void bindMap(py::module_& module);       ///< Map, load_map
void bindPlaces(py::module_& module);    ///< read
void bindLocalize(py::module_& module);  ///< Localizer, Fix, Tracker
void bindResearch(py::module_& module);  ///< simulate, graph, walks, descriptors, match, evaluate

}  // namespace xview::python
