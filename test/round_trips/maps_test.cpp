// SPDX-License-Identifier: BSD-3-Clause
// Maps, their changes and what was added to them are read as they were written.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <filesystem>

#include "map/sample_map.h"
#include "round_trips/generators.h"

namespace xview::map {
namespace {

using test::isSame;

constexpr double kStep_m = 0.01;  ///< to which plan view and cloud are rounded

std::string freshFile() {
  const std::string path = test::scratch("map.xvm");
  std::filesystem::remove(path);
  return path;
}

SemanticMap writtenAndRead(const SemanticMap& map) {
  const std::string path = freshFile();
  saveMap(path, map);
  return unpacked(openMap(path));
}

bool isNear(const LabelledCloud& a, const LabelledCloud& b) {
  const auto has = [&](const LabelledCloud& all, const Point& point, const Eigen::Vector3d& p) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all.points[i].label == point.label && all.points[i].instance == point.instance &&
          (all.position(i) - p).cwiseAbs().maxCoeff() < kStep_m)
        return true;
    }
    return false;
  };
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!has(b, a.points[i], a.position(i)) || !has(a, b.points[i], b.position(i))) return false;
  return true;
}

/// All that is kept exactly; plan views are compared by their numbers.
void expectKept(const SemanticMap& read, const SemanticMap& map) {
  RC_ASSERT(isSame(read.labels, map.labels));
  RC_ASSERT(isSame(read.graph, map.graph));
  RC_ASSERT(read.sources == map.sources);
  RC_ASSERT(read.options_yaml == map.options_yaml);
  RC_ASSERT(read.frames == map.frames);
  RC_ASSERT(read.stamps_s == map.stamps_s);
  RC_ASSERT(read.source_of_pose == map.source_of_pose);
  RC_ASSERT(read.poses.size() == map.poses.size());
  for (std::size_t i = 0; i < map.poses.size(); ++i)
    RC_ASSERT(read.poses[i].matrix() == map.poses[i].matrix());
  RC_ASSERT(isNear(read.cloud, map.cloud));
  RC_ASSERT(read.bev.aerial == map.bev.aerial);
  RC_ASSERT(read.bev.known.size() == map.bev.known.size());
  RC_ASSERT(read.bev.sampleCount() == map.bev.sampleCount());
  RC_ASSERT(read.wrong_places.size() == map.wrong_places.size());
  for (std::size_t i = 0; i < map.wrong_places.size(); ++i) {
    RC_ASSERT(read.wrong_places[i].above_null == map.wrong_places[i].above_null);
    RC_ASSERT(read.wrong_places[i].miss_ratio == map.wrong_places[i].miss_ratio);
    RC_ASSERT(read.wrong_places[i].dense_margin == map.wrong_places[i].dense_margin);
    RC_ASSERT(read.wrong_places[i].likelihood_margin == map.wrong_places[i].likelihood_margin);
  }
  RC_ASSERT(read.own_stretches.size() == map.own_stretches.size());
  for (std::size_t i = 0; i < map.own_stretches.size(); ++i) {
    RC_ASSERT(read.own_stretches[i].window_m == map.own_stretches[i].window_m);
    RC_ASSERT(read.own_stretches[i].confidence == map.own_stretches[i].confidence);
  }
}

RC_GTEST_PROP(MapRoundTrip, KeepsAMapAndFromThenOnEveryBit, ()) {
  const SemanticMap map = *test::anyMap();
  const SemanticMap read = writtenAndRead(map);
  expectKept(read, map);
  RC_ASSERT(isSame(writtenAndRead(read), read));
}

RC_GTEST_PROP(MapRoundTrip, KeepsWhatAChangeAddedAndTakesItBack, ()) {
  const SemanticMap before = *test::anyMap(), after = *test::anyMap();
  const Visit visit{*test::anyMap(), *test::anyLength(3)};
  const std::string note = *test::anyText(), path = freshFile();
  saveMap(path, before);
  const SemanticMap first = unpacked(openMap(path));
  saveRevision(path, after, note, &visit);
  expectKept(unpacked(openMap(path)), after);
  const std::vector<Revision> revisions = readRevisions(path);
  RC_ASSERT(revisions.size() == 1U);
  RC_ASSERT(revisions[0].note == note);
  const Visit read = loadVisit(path, 0);
  expectKept(read.place, visit.place);
  RC_ASSERT(read.sigma_m == visit.sigma_m);
  RC_ASSERT(undoRevision(path));
  RC_ASSERT(isSame(unpacked(openMap(path)), first));
  RC_ASSERT(!undoRevision(path));
}

}  // namespace
}  // namespace xview::map
