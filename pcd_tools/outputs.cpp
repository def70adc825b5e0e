// SPDX-License-Identifier: BSD-3-Clause
#include "outputs.h"

#include <fmt/core.h>

#include <algorithm>
#include <boost/algorithm/string/case_conv.hpp>
#include <filesystem>

#include "compare/self_similarity.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"

namespace xview::tools {

std::string endingOf(const std::string& path) {
  return boost::algorithm::to_lower_copy(std::filesystem::path(path).extension().string());
}

Results::Results(const std::string& path) {
  if (!path.empty()) file_.emplace(path);
}

void Results::print(const std::string& lines, const Narrative& narrate) {
  const UninterruptedWrite whole;
  if (file_) {
    file_->write(lines + "\n");
    return file_->keepSoFar();
  }
  narrate.clearBar();
  fmt::print("{}\n", lines);
  std::fflush(stdout);
}

void Results::finish() {
  if (file_) file_->commit();
}

bool liesIn(const std::string& path, const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code failed;
  if (path.empty() || !fs::is_directory(folder, failed)) return false;
  const fs::path outer = fs::canonical(folder, failed);
  const fs::path inner = fs::weakly_canonical(fs::absolute(path), failed);
  const auto [left, rest] = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
  return left == outer.end() && rest != inner.end() && !rest->empty();
}

void requireOutside(const std::string& name, const std::string& output,
                    const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    if (liesIn(output, input))
      throw UsageError(
          fmt::format("{}{}{} lies in {}, which is read; give the output a path "
                      "outside of it",
                      name, name.empty() ? "" : " ", output, input));
  }
}

std::string wrongPlacesText(const map::SemanticMap& map) {
  const auto margins = wrongPlaceMargins(map);
  if (!margins) return "";
  return fmt::format("stand out by up to {:.1f} (points) and {:.0f} nats (views){}", margins->dense,
                     margins->likelihood,
                     margins->areOfCopies() ? ": streets or rooms of this map are copies of each "
                                              "other, of which short queries are ambiguous"
                                            : "");
}

std::string ownAcceptanceText(const map::SemanticMap& map) {
  std::string lengths;
  for (const OwnAcceptance& own : ownAcceptance(map)) {
    const auto percent = [&](std::size_t i) { return 100 * own.accepted[i] / own.stretches; };
    lengths += fmt::format("{}{:.3g} m: {} / {} / {} %", lengths.empty() ? "" : ", ", own.window_m,
                           percent(0), percent(1), percent(2));
  }
  return lengths.empty() ? ""
                         : lengths + " accepted at risks of 0.01 / 0.001 / 0.0001 by place alone";
}

void removeStale(const std::string& path, const Narrative& narrate, const char* why) {
  std::error_code problem;
  if (path.empty() || !std::filesystem::is_regular_file(path, problem)) return;
  if (!std::filesystem::remove(path, problem) || problem)
    throw Error(path, "is of an earlier query and cannot be removed: " + problem.message());
  narrate.note(path + " of an earlier query is removed" + why);
}

bool isCloudPath(const std::string& path) {
  return endingOf(path) == ".pcd" || endingOf(path) == ".ply";
}

bool isCloudFilePath(const std::string& path) {
  return isCloudPath(path) || endingOf(path) == ".las";
}

void requireCloudPath(const std::string& path) {
  if (!isCloudFilePath(path)) throw UsageError(path + ": a cloud ends with .pcd, .ply or .las");
  requireWritable(path);
}

void writeCloud(const std::string& path, const LabelledCloud& cloud, const LabelSet& labels) {
  if (endingOf(path) == ".pcd")
    io::writePcd(path, cloud, &labels);
  else if (endingOf(path) == ".las")
    io::writeLas(path, cloud, &labels);
  else
    io::writePly(path, cloud, &labels);
}

bool isDrawing(const std::string& path) {
  const std::string ending = endingOf(path);
  return ending == ".png" || ending == ".svg" || ending == ".html" || ending == ".vtk" ||
         isCloudPath(path);
}

void requireDrawingPath(const std::string& path, bool or_table) {
  if (!isDrawing(path) && !(or_table && endingOf(path) == ".csv"))
    throw UsageError(path + ": a drawing ends with .png, .svg, .html, .vtk, .ply or .pcd" +
                     (or_table ? ", a table with .csv" : ""));
  requireWritable(path);
}

void noteDoubles(const std::string& path, const LabelledCloud& cloud, const Narrative& narrate) {
  if (io::needsDoubles(cloud) && endingOf(path) != ".las")
    narrate.note(path +
                 " has doubles, as float32 has no millimetres 10 km from the origin; PCL, its "
                 "pcl_viewer and Autoware read float32 only: for them move the cloud, with lift "
                 "--transform");
}

void writeDrawing(const std::string& path, const Scene& scene, const Narrative& narrate) {
  const std::string ending = endingOf(path);
  if (ending == ".png") return writeFile(path, drawTopDown(scene, PictureFormat::png));
  if (ending == ".svg") return writeFile(path, drawTopDown(scene, PictureFormat::svg));
  if (ending == ".html") return writeFile(path, htmlPage(scene));
  if (ending == ".vtk") return writeFile(path, sceneMesh(scene, MeshFormat::vtk));
  if (ending == ".ply") return writeFile(path, sceneMesh(scene, MeshFormat::ply));
  LabelSet labels;
  const LabelledCloud cloud = sceneCloud(scene, labels);
  io::writePcd(path, cloud, &labels);
  noteDoubles(path, cloud, narrate);
}

}  // namespace xview::tools
