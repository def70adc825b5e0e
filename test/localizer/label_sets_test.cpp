// SPDX-License-Identifier: BSD-3-Clause
// Recordings in the classes of one data set, sought in maps of another.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "base/label_match.h"
#include "localizer/simulated_drive.h"
#include "place/raw_recording.h"
#include "support/nightly.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace xview {
namespace {

using test::simulatedDrive;

/// What the drive would have recorded had its classes been those of a shipped set.
class DriveIn {
 public:
  explicit DriveIn(const std::string& set)
      : labels(io::shippedLabelSet(set)), query(queryOf("rear")) {}

  const LabelSet labels;
  const Query query;

  Query negative() const { return queryOf("elsewhere"); }
  map::SemanticMap map() const { return buildMap({recordingOf("forward").get()}, {}); }

 private:
  std::unique_ptr<FrameSource> recordingOf(const std::string& session) const {
    const FrameSource& given = *simulatedDrive().sessions.at(session);
    if (knowsShapesOnly(labels))
      return withShapeLabels(std::make_unique<PosedRecording>(given, Eigen::Isometry3d::Identity()),
                             labels, {});
    return std::make_unique<TranslatedRecording>(given,
                                                 LabelMatch(simulatedDrive().labels, labels));
  }
  Query queryOf(const std::string& session) const {
    const std::unique_ptr<FrameSource> recording = recordingOf(session);
    std::vector<PreprocessedFrame> frames;
    for (std::size_t i = 10; i < 40; ++i)
      frames.push_back(preprocessFrame(recording->read(i), labels, {}));
    return makeQuery(frames.data(), frames.data() + frames.size(), labels, {});
  }
};

/// Of every other map that of a set that is near or far in the list, by turns; all at night.
bool isAsked(std::size_t recording, std::size_t map, std::size_t sets) {
  const std::size_t step = (recording + sets - map) % sets;
  return test::isNightly() || step == (map % 4 == 0 ? 1 : sets / 2);
}

/// What one set cannot name must neither be missed in the other nor be found there by chance.
TEST(LabelSets, ARecordingInOneShippedSetIsFoundInAMapOfAnyOther) {
  const auto hasPosts = [](const LabelSet& labels) {
    return std::any_of(labels.classes().begin(), labels.classes().end(), [](const auto& entry) {
      return entry.second.kind == Kind::pole && entry.second.role != Role::ignored;
    });
  };
  std::vector<std::unique_ptr<DriveIn>> drives;
  for (const std::string& set : io::shippedLabelSets()) {
    // Classes of airsim are numbers of things, and those of nyu40 are of rooms.
    if (set != "airsim" && set != "nyu40") drives.push_back(std::make_unique<DriveIn>(set));
  }
  ASSERT_GE(drives.size(), 16u);
  const Eigen::Vector3d truth = simulatedDrive().sessions.at("rear")->truth(39).translation();
  int asked = 0, accepted = 0;
  std::string refused;
  for (std::size_t i = 0; i < drives.size(); i += test::isNightly() ? 1 : 2) {
    const Localizer localizer(drives[i]->map(), {});
    for (std::size_t j = 0; j < drives.size(); ++j) {
      if (!isAsked(j, i, drives.size())) continue;
      const LabelSet &of = drives[j]->labels, &in = drives[i]->labels;
      SCOPED_TRACE(of.name() + " in " + in.name());
      const Localization fix = localizer.localize(drives[j]->query);
      // Shapes say little but posts of what a set without posts names.
      const bool is_by_shape = knowsShapesOnly(of) != knowsShapesOnly(in);
      if (!is_by_shape || (hasPosts(of) && hasPosts(in))) {
        ++asked;
        if (fix.status != Status::accepted) refused += of.name() + " in " + in.name() + "\n";
        accepted += fix.status == Status::accepted;
      }
      if (fix.status == Status::accepted) {
        EXPECT_LT((fix.T_map_sensor.translation() - truth).norm(), 0.5);
      }
      if ((i + j) % 4 != 0) continue;
      const Localization strange = localizer.localize(drives[j]->negative());
      EXPECT_NE(strange.status, Status::accepted) << strange.reason;
    }
  }
  EXPECT_GT(asked, test::isNightly() ? 200 : 5);
  EXPECT_GE(accepted, 0.97 * asked) << "a map of five classes tells less:\n" << refused;
}

/// Check fix for: the vertices of a map that is read late were unpacked after its classes had
/// become those of shapes, and met none of a raw query.
TEST(LabelSets, ARawQueryHasOneAnswerHoweverTheMapIsOpened) {
  const test::TemporaryFolder folder;
  map::saveMap(folder / "map.xvm", simulatedDrive().map);
  const Query raw = DriveIn("shapes").query;
  const Localization late = Localizer(map::openMap(folder / "map.xvm")).localize(raw),
                     whole =
                         Localizer(map::unpacked(map::openMap(folder / "map.xvm"))).localize(raw);
  EXPECT_GT(whole.matches, 0);
  EXPECT_EQ(late.matches, whole.matches);
  EXPECT_EQ(late.T_map_query.matrix(), whole.T_map_query.matrix());
  EXPECT_EQ(late.confidence, whole.confidence);
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
  map::SemanticMap map = cityscapes.map();
  appendToMap(map, nuscenes.map(), {});
  EXPECT_EQ(map.labels, cityscapes.labels);
  for (const Vertex& vertex : map.graph.vertices)
    EXPECT_NE(map.labels.find(vertex.label), nullptr) << vertex.label;
  map::SemanticMap negative = nuscenes.map();
  negative.labels = genericLabelSet({1, 2});
  EXPECT_THROW(appendToMap(map, negative, {}), Error);
}

TEST(QueryCheck, NamesTheCauseInsteadOfItsLastSymptom) {
  const auto& drive = simulatedDrive();
  const auto reasonFor = [](const map::SemanticMap& map, const Query& query) {
    const Localization fix = Localizer(map, Options{}).localize(query);
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
  EXPECT_THROW(Localizer(drive.map, far), UsageError);
}

}  // namespace
}  // namespace xview
