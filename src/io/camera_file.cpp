// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "xview/io/atomic_file.h"
#include "xview/io/image_files.h"
#include "xview/types/error.h"
#include "yaml_file.h"

namespace xview {
namespace {

constexpr int kMaxSide = 32768;

void requireAll(const std::string& path, const YAML::Node& root,
                const std::vector<std::string>& required) {
  std::string missing;
  for (const std::string& key : required) {
    if (!root[key]) missing += (missing.empty() ? "" : ", ") + key;
  }
  if (!missing.empty()) throw Error(path, "missing: " + missing);
}

double positive(const YamlFile& file, const std::string& key) {
  const double value = file.number(file.root()[key], key);
  if (value <= 0) file.fail(file.root()[key], key + ": expected a number above 0");
  return value;
}

std::string rangeLine(const char* key, double metres) {
  char text[64];
  std::snprintf(text, sizeof text, "%s: %.17g\n", key, metres);
  return text;
}

}  // namespace

Camera readCamera(const std::string& path) {
  const std::vector<std::string> required = {"width", "height", "fx",         "fy",
                                             "cx",    "cy",     "depth_scale"};
  std::vector<std::string> known = required;
  known.insert(known.end(), {"depth", "sensor", "min_range", "max_range"});
  const YamlFile file = YamlFile::read(path);
  const YAML::Node root = file.root();
  if (root.IsNull()) throw Error(path, "the file is empty, expected width, height, fx, …");
  file.requireKeys(root, known);
  requireAll(path, root, required);

  Camera camera;
  camera.width = static_cast<int>(file.integer(root["width"], "width", 1, kMaxSide));
  camera.height = static_cast<int>(file.integer(root["height"], "height", 1, kMaxSide));
  camera.fx = positive(file, "fx");
  camera.fy = positive(file, "fy");
  camera.cx = file.number(root["cx"], "cx");
  camera.cy = file.number(root["cy"], "cy");
  camera.depth_scale = positive(file, "depth_scale");
  if (root["depth"]) {
    const std::string depth = file.text(root["depth"], "depth");
    if (depth != "range" && depth != "planar") {
      file.fail(root["depth"], "depth: expected range or planar, found '" + depth + "'");
    }
    camera.depth_is_range = depth == "range";
  }
  if (root["min_range"]) camera.min_range_m = file.number(root["min_range"], "min_range");
  if (root["max_range"]) camera.max_range_m = positive(file, "max_range");
  if (!(camera.min_range_m >= 0 && camera.min_range_m < camera.max_range_m)) {
    file.fail(root["min_range"], "min_range: expected 0 <= min_range < max_range");
  }
  return camera;
}

void writeCamera(const std::string& path, const Camera& camera) {
  char text[400];
  std::snprintf(text, sizeof text,
                "width: %d\nheight: %d\nfx: %.17g\nfy: %.17g\ncx: %.17g\ncy: %.17g\n"
                "depth_scale: %.17g\ndepth: %s\n",
                camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
                camera.depth_scale, camera.depth_is_range ? "range" : "planar");
  AtomicFile file(path);
  file.write(text);
  if (camera.min_range_m > 0) file.write(rangeLine("min_range", camera.min_range_m));
  if (std::isfinite(camera.max_range_m)) file.write(rangeLine("max_range", camera.max_range_m));
  file.commit();
}

}  // namespace xview
