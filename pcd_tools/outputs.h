// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "narrative.h"
#include "process/atomic_file.h"
#include "view/scene.h"
#include "xview/base/labelled_cloud.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// Where the results of a command go: to standard output as they come, or into a file that appears
/// at the end. Of an interrupted program the results so far stay in either, each of them whole.
class Results {
 public:
  explicit Results(const std::string& path);  ///< empty: standard output. Throws Error
  void print(const std::string& lines, const Narrative& narrate);  ///< adds a line break
  void finish();                                                   ///< throws Error
  std::FILE* screen() const { return file_ ? nullptr : stdout; }

 private:
  std::optional<AtomicFile> file_;
};

/// True if the path is in the folder, or would be if it existed; false for the folder itself, and
/// if it is none.
bool liesIn(const std::string& path, const std::string& folder);
/// Throws UsageError if the output, which `name` names, would be written into an input that is a
/// folder: it would be written over a file of the input, or be taken for one.
void requireOutside(const std::string& name, const std::string& output,
                    const std::vector<std::string>& inputs);

/// How many of a map's own stretches would be accepted, over their length and the risk, as a line;
/// empty if the map was not asked.
std::string ownAcceptanceText(const map::SemanticMap& map);
/// How far wrong places of the map stand out, and whether its streets or rooms are copies. Empty if
/// that was not measured.
std::string wrongPlacesText(const map::SemanticMap& map);

constexpr const char* kNothingToWrite = ": there is no accepted pose to write";
constexpr const char* kUntilItIsFound = " until there is an accepted pose";
/// Removes what an earlier run left at the path, because this run has nothing to write there, or
/// not yet, and says so.
void removeStale(const std::string& path, const Narrative& narrate,
                 const char* why = kNothingToWrite);

std::string endingOf(const std::string& path);  ///< with the point: ".pcd"

bool isCloudPath(const std::string& path);      ///< true if the ending is .pcd or .ply
bool isCloudFilePath(const std::string& path);  ///< the same or .las

/// Throws UsageError unless isCloudFilePath, Error if it cannot be written; called
/// before the work, not after it.
void requireCloudPath(const std::string& path);
/// PCD, PLY or LAS by the ending of the path, coloured by class.
void writeCloud(const std::string& path, const LabelledCloud& cloud, const LabelSet& labels);
/// Says so if the cloud was written as doubles, which not all programs read.
void noteDoubles(const std::string& path, const LabelledCloud& cloud, const Narrative& narrate);

/// True if the ending is one that writeDrawing knows: .png, .svg, .html, .vtk, .ply, .pcd.
bool isDrawing(const std::string& path);

/// Throws UsageError unless isDrawing or, where a table can be asked for, the ending is .csv; Error
/// if it cannot be written; called before the work, not after it.
void requireDrawingPath(const std::string& path, bool or_table = false);

/// Everything that is in the scene, by the ending: .png and .svg from above; .html as a page; .vtk
/// and .ply as a mesh, .pcd as a cloud.
void writeDrawing(const std::string& path, const Scene& scene, const Narrative& narrate);

}  // namespace xview::tools
