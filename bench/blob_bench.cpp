// SPDX-License-Identifier: BSD-3-Clause
// Are the blobs of a cloud the objects that were marked in it?
//
//   blob_bench CLOUD... [--config FILE.yaml] [--key.subkey VALUE]... [--support 9]
//
// Labels of the clouds number objects (mOSD: 20–29 are the parts of the first one, 30–39 of the
// second, …); up to `--support` they are what the objects stand on. Three ways to blob them, from
// the easiest: every part is a class of its own; every object is a class, so that blobs have to
// separate its disjoint parts; all objects are one class, so that blobs have to separate all of
// them. Precision and recall of objects whose overlap (intersection over union) with a blob exceeds
// 0.5. Points outside the objects are left out.
#include <fmt/core.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "cluster_overlap.h"
#include "session.h"
#include "xview/graph/blobs.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"
#include "xview/options_file.h"

namespace {

using namespace xview;
using namespace xview::bench;

struct Arguments {
  std::vector<std::string> clouds;
  std::uint32_t support = 9;
  Options options;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  a.clouds = parseArguments(
      argc, argv,
      {{"--config", [&](const std::string& value) { applyOptionsFile(a.options, value); }},
       {"--support",
        [&](const std::string& value) {
          a.support = static_cast<std::uint32_t>(std::stoul(value));
        }}},
      a.options, 1, "blob_bench CLOUD... [options]");
  return a;
}

/// The points of objects, thinned, and the part that each belongs to.
LabelledCloud readObjects(const std::string& path, const Arguments& a) {
  const LabelledCloud all = io::openRecording(path)->read(0).cloud;
  LabelledCloud objects;
  objects.origin = all.origin;
  for (const Point& p : all.points) {
    if (p.label > a.support && p.getVector3fMap().allFinite()) objects.points.push_back(p);
  }
  return a.options.blobs.voxel_m > 0 ? graph::thinByVoxel(objects, a.options.blobs.voxel_m)
                                     : objects;
}

template <class ClassOf>
void score(const std::string& name, const LabelledCloud& parts, const Arguments& a,
           ClassOf&& class_of) {
  LabelledCloud cloud = parts;
  std::vector<std::uint32_t> part_of_point, classes;
  for (Point& p : cloud.points) {
    part_of_point.push_back(p.label);
    p.label = class_of(p.label);
    classes.push_back(p.label);
  }
  std::vector<int> blob_of_point;
  graph::extractBlobs(cloud, genericLabelSet(classes), a.options.blobs, &blob_of_point);
  const ClusterScore s = scoreClusters(part_of_point, blob_of_point, {});
  fmt::print(
      "  {:<22} objects {:3}  blobs {:3}  precision {:5.1f} %  recall {:5.1f} %  overlap {:.3f}\n",
      name, s.objects, s.clusters, 100 * s.precision(), 100 * s.recall(), s.mean_overlap);
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  for (const std::string& path : a.clouds) {
    const LabelledCloud parts = readObjects(path, a);
    fmt::print("{}: {} points\n", std::filesystem::path(path).filename().string(), parts.size());
    score("a class per part", parts, a, [](std::uint32_t label) { return label; });
    score("a class per object", parts, a, [](std::uint32_t label) { return label / 10; });
    score("one class", parts, a, [](std::uint32_t) { return 1u; });
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
