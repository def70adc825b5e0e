// SPDX-License-Identifier: BSD-3-Clause
#include "explanation_files.h"

#include <fmt/core.h>

#include <filesystem>

#include "drawing.h"
#include "xview/io/atomic_file.h"
#include "xview/types/error.h"
#include "xview/view/color_mesh.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

bool isOneFile(const std::string& path) { return fs::path(path).extension() == ".csv"; }

/// Without ending.
std::string stemOf(const std::string& path, int query, const Answer& answer) {
  if (isOneFile(path)) return fs::path(path).replace_extension().string();
  return fmt::format("{}/{:04}_{}-{}", path, query, answer.first_frame, answer.last_frame);
}

std::string numberOrNothing(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : std::string();
}

std::string csvLine(const Contribution& c) {
  const Eigen::Vector3d& p = c.map_position;
  std::string line = fmt::format("{},{},{},{:.3f},{:.3f},{:.3f},{},{},",
                                 c.kind == Contribution::Kind::sample ? "sample" : "vertex", c.name,
                                 toString(c.testimony), p.x(), p.y(), p.z(),
                                 numberOrNothing(c.nats, 3), numberOrNothing(c.expected, 3));
  if (c.partner_index) line += fmt::format("{}", *c.partner_index);
  line += c.partner ? fmt::format(",{:.3f},{:.3f},{:.3f},", c.partner->x(), c.partner->y(),
                                  c.partner->z())
                    : std::string(",,,,");
  return line + numberOrNothing(c.residual_m, 3) + "\n";
}

std::string toCsv(const Answer& answer, const Explanation& explanation) {
  std::string text = fmt::format("# {}: {}; confidence {:.4f}\n", toString(answer.fix.status),
                                 answer.fix.reason, answer.fix.confidence);
  text += "kind,name,testimony,x,y,z,nats,expected_nats,map_vertex,map_x,map_y,map_z,residual_m\n";
  for (const Contribution& c : explanation.contributions) text += csvLine(c);
  return text;
}

Color colorOf(Testimony testimony) {
  switch (testimony) {
    case Testimony::kept:
      return {30, 170, 60};
    case Testimony::contradicting:
      return {210, 40, 40};
    default:
      return {150, 150, 150};
  }
}

/// Each piece of the query where the pose puts it, with a line to its partner in the map.
ColorMesh meshOf(const Explanation& explanation) {
  ColorMesh mesh;
  for (const Contribution& c : explanation.contributions) {
    const bool is_vertex = c.kind == Contribution::Kind::vertex;
    addOctahedron(mesh, c.map_position, is_vertex ? 0.5 : 0.25, colorOf(c.testimony));
    if (c.partner) addTube(mesh, c.map_position, *c.partner, 0.05, colorOf(c.testimony));
  }
  return mesh;
}

}  // namespace

void checkExplanationPath(const std::string& path, bool is_one_query) {
  if (!path.empty() && isOneFile(path) && !is_one_query)
    throw UsageError("--explain " + path + " is for one query; name a folder for several");
  if (isOneFile(path)) requireWritable(path);
}

void writeExplanation(const std::string& path, int query, const Answer& answer,
                      const Explanation& explanation) {
  if (!isOneFile(path)) {
    std::error_code problem;
    fs::create_directories(path, problem);
    if (problem) throw Error(path, "cannot be made: " + problem.message());
  }
  const std::string stem = stemOf(path, query, answer);
  AtomicFile csv(stem + ".csv");
  csv.write(toCsv(answer, explanation));
  csv.commit();
  writeMesh(stem + ".ply", meshOf(explanation));
}

}  // namespace xview::tools
