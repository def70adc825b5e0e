// SPDX-License-Identifier: BSD-3-Clause
#include "frames_to_cloud.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "xview/depth_plausibility.h"
#include "xview/io/cloud_files.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"

namespace xview::tools {
void appendCloud(LabelledCloud& whole, const LabelledCloud& part) {
  if (whole.empty()) {
    whole = part;
    return;
  }
  const Eigen::Vector3f shift = (part.origin - whole.origin).cast<float>();
  whole.points.reserve(whole.size() + part.size());
  for (Point point : part.points) {
    point.getVector3fMap() += shift;
    whole.points.push_back(point);
  }
}

LabelledCloud liftAll(const FrameSource& source, const Job& job, LiftCounts& counts) {
  const Progress progress = job.narrate.progress("lift");
  constexpr std::size_t kBatch = 16;  // frames in memory at a time
  LabelledCloud whole;
  DepthPlausibility depths;
  for (std::size_t first = 0; first < source.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, source.size() - first);
    std::vector<LabelledCloud> parts(count);
    std::vector<LiftCounts> part_counts(count);
    parallelFor(count, job.options.threads, [&](std::size_t i) {
      parts[i] = lift(source.read(first + i), source.labels(), job.options.lift, &part_counts[i]);
    });
    for (std::size_t i = 0; i < count; ++i) {
      depths.add(part_counts[i], parts[i], source.pose(first + i).translation());
      appendCloud(whole, parts[i]);
      counts.lifted += part_counts[i].lifted;
      counts.no_depth += part_counts[i].no_depth;
      counts.out_of_range += part_counts[i].out_of_range;
      counts.ignored_class += part_counts[i].ignored_class;
    }
    if (progress) progress(first + count, source.size());
  }
  depths.require(source);
  if (whole.empty()) {
    throw Error(
        source.name(),
        fmt::format("no points to lift in {} frames: {} without depth, {} out of range, {} of "
                    "ignored or unknown classes",
                    source.size(), counts.no_depth, counts.out_of_range, counts.ignored_class));
  }
  return whole;
}

void checkCloudEnding(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending != ".pcd" && ending != ".ply")
    throw UsageError(path + ": a cloud ends with .pcd or .ply");
}

void writeCloud(const std::string& path, const LabelledCloud& cloud, const LabelSet& labels) {
  checkCloudEnding(path);
  if (std::filesystem::path(path).extension() == ".pcd")
    writePcd(path, cloud, &labels);
  else
    writePly(path, cloud, &labels);
}

}  // namespace xview::tools
