// SPDX-License-Identifier: BSD-3-Clause
// Recordings in the classes of one data set, sought in maps of another.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "pipeline/simulated_drive.h"
#include "xview/io/label_files.h"
#include "xview/types/error.h"
#include "xview/types/label_match.h"

namespace xview {
namespace {

using test::simulatedDrive;

bool namesAny(const LabelSet& labels, std::initializer_list<Kind> kinds) {
  const auto& classes = labels.classes();
  return std::any_of(classes.begin(), classes.end(), [&](const auto& entry) {
    return entry.second.role != Role::ignored &&
           std::find(kinds.begin(), kinds.end(), entry.second.kind) != kinds.end();
  });
}

/// True if one of two sets knows all that the other knows of ground, or both know poles.
bool shareEnough(const LabelSet& a, const LabelSet& b) {
  const auto hasFineGround = [](const LabelSet& labels) {
    return namesAny(labels, {Kind::road}) && namesAny(labels, {Kind::sidewalk}) &&
           namesAny(labels, {Kind::terrain});
  };
  const auto hasPoles = [](const LabelSet& labels) { return namesAny(labels, {Kind::pole}); };
  return (hasFineGround(a) && hasFineGround(b)) || (hasPoles(a) && hasPoles(b));
}

/// What the drive would have recorded had its classes been those of a shipped set.
class DriveIn {
 public:
  explicit DriveIn(const std::string& set)
      : labels(io::shippedLabelSet(set)), match_(simulatedDrive().labels, labels) {
    const auto& sessions = simulatedDrive().sessions;
    const TranslatedRecording forward(*sessions.at("forward"), match_);
    map = buildMap({&forward}, {});
    query = queryOf("rear");
  }
  Query queryOf(const std::string& session) const {
    const TranslatedRecording recording(*simulatedDrive().sessions.at(session), match_);
    const std::vector<FrameDigest> frames = digestRecording(recording, {});
    return makeQuery(frames.data() + 10, frames.data() + 40, labels, {});
  }

  LabelSet labels;
  map::SemanticMap map;
  Query query;

 private:
  LabelMatch match_;
};

TEST(LabelSets, ARecordingInOneShippedSetIsFoundInAMapOfAnyOther) {
  std::vector<std::unique_ptr<DriveIn>> drives;
  for (const std::string& set : io::shippedLabelSets()) {
    if (set == "shapes" || set == "airsim") continue;  // these have no classes of their own
    drives.push_back(std::make_unique<DriveIn>(set));
  }
  ASSERT_GE(drives.size(), 12u);
  const Eigen::Vector3d truth = simulatedDrive().sessions.at("rear")->truth(39).translation();
  for (const auto& in : drives) {
    const Localizer localizer(in->map, {});
    for (const auto& of : drives) {
      if (!shareEnough(of->labels, in->labels)) continue;
      const Localization fix = localizer.localize(of->query);
      EXPECT_EQ(fix.status, Status::accepted)
          << of->labels.name() << " in " << in->labels.name() << ": " << fix.reason;
      EXPECT_LT((fix.T_map_sensor.translation() - truth).norm(), 1)
          << of->labels.name() << " in " << in->labels.name();
    }
  }
}

TEST(LabelSets, AStrangerInAnotherSetIsRefused) {
  const DriveIn kitti("semantic_kitti");
  const Localizer localizer(kitti.map, {});
  EXPECT_NE(localizer.localize(DriveIn("nuscenes").queryOf("elsewhere")).status, Status::accepted);
}

TEST(LabelSets, WithoutAnyCommonClassTheAnswerSaysSo) {
  Query query = simulatedDrive().query("rear", 10, 40);
  query.labels = io::shippedLabelSet("airsim");  // ids of objects, without names that tell
  const Localization fix = Localizer(simulatedDrive().map, {}).localize(query);
  EXPECT_EQ(fix.status, Status::rejected);
  EXPECT_NE(fix.reason.find("no class in common"), std::string::npos) << fix.reason;
  query.labels = genericLabelSet({0, 2, 3, 4});
  EXPECT_NE(Localizer(simulatedDrive().map, {}).localize(query).reason.find("--labels"),
            std::string::npos);
}

TEST(LabelSets, PartsOfAMapMayHaveOtherSets) {
  const DriveIn cityscapes("cityscapes"), nuscenes("nuscenes");
  map::SemanticMap map = cityscapes.map;
  appendToMap(map, nuscenes.map, {});
  EXPECT_EQ(map.labels, cityscapes.labels);
  for (const Vertex& vertex : map.graph.vertices)
    EXPECT_NE(map.labels.find(vertex.label), nullptr) << vertex.label;
  map::SemanticMap stranger = nuscenes.map;
  stranger.labels = genericLabelSet({1, 2});
  EXPECT_THROW(appendToMap(map, stranger, {}), Error);
}

TEST(QueryCheck, NamesTheCauseInsteadOfItsLastSymptom) {
  const auto& drive = simulatedDrive();
  const auto reasonFor = [](const map::SemanticMap& map, const Query& query, Options options = {}) {
    const Localization fix = Localizer(map, options).localize(query);
    EXPECT_EQ(fix.status, Status::rejected);
    EXPECT_TRUE(fix.hypotheses.empty());
    return fix.reason;
  };
  const Query query = drive.query("rear", 10, 40);
  map::SemanticMap nothing;
  nothing.labels = drive.labels;
  EXPECT_NE(reasonFor(nothing, query).find("the map is empty"), std::string::npos);
  Options far;
  far.prior.near = "100000,0,10";
  const std::string reason = reasonFor(drive.map, query, far);
  EXPECT_NE(reason.find("the prior is outside of the map: x 100000.0"), std::string::npos)
      << reason;
}

}  // namespace
}  // namespace xview
