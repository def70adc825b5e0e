// SPDX-License-Identifier: BSD-3-Clause
#include "xview/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {
namespace {

using test::messageOf;

class OptionsFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(folder_ / "options.yaml", std::ios::binary) << text;
    return folder_ / "options.yaml";
  }
  std::string messageFor(const std::string& text) {
    const std::string path = write(text);
    return messageOf([&] { applyOptionsFile(options_, path); });
  }

  test::TemporaryFolder folder_;
  Options options_;
};

const OptionEntry* find(const std::vector<OptionEntry>& entries, const std::string& key) {
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const OptionEntry& entry) { return entry.key == key; });
  return found == entries.end() ? nullptr : &*found;
}

TEST(ListOptions, NamesEveryFieldOnceWithItsGroupValueDefaultAndRule) {
  Options options;
  options.walks.walk_length = 5;
  const std::vector<OptionEntry> entries = listOptions(options);
  std::set<std::string> keys;
  for (const OptionEntry& entry : entries) {
    EXPECT_TRUE(keys.insert(entry.key).second) << entry.key;
    EXPECT_FALSE(entry.help.empty()) << entry.key;
  }
  const OptionEntry* length = find(entries, "walks.walk_length");
  ASSERT_NE(length, nullptr);
  EXPECT_EQ(length->value, "5");
  EXPECT_EQ(length->fallback, "4");
  EXPECT_NE(length->help.find("in [2, 8]"), std::string::npos) << length->help;
  ASSERT_NE(find(entries, "seed"), nullptr);
  ASSERT_NE(find(entries, "merge.mode"), nullptr);
}

TEST(ListOptions, EveryDefaultIsLegal) {
  Options options;
  for (const OptionEntry& entry : listOptions(options)) {
    EXPECT_NO_THROW(setOption(options, entry.key, entry.value)) << entry.key << " " << entry.value;
  }
  EXPECT_EQ(toYaml(options), toYaml(Options()));
}

TEST(SetOption, SetsEachTypeOfOption) {
  Options options;
  setOption(options, "walks.num_walks", "300");
  setOption(options, "blobs.tolerance_m", "2.5e-1");
  setOption(options, "match.rare_words", "false");
  setOption(options, "merge.mode", "first_observation");
  EXPECT_EQ(options.walks.num_walks, 300);
  EXPECT_DOUBLE_EQ(options.blobs.tolerance_m, 0.25);
  EXPECT_FALSE(options.match.rare_words);
  EXPECT_EQ(options.merge.mode, "first_observation");
}

TEST(SetOption, NamesTheNearestKnownKey) {
  Options options;
  EXPECT_THROW(setOption(options, "walks.num_walk", "3"), UsageError);
  EXPECT_EQ(messageOf([&] { setOption(options, "walks.num_walk", "3"); }),
            "unknown option walks.num_walk; the nearest known one is walks.num_walks");
}

TEST(SetOption, SaysTheViolatedRule) {
  Options options;
  EXPECT_EQ(messageOf([&] { setOption(options, "walks.walk_length", "0"); }),
            "walks.walk_length = 0, must be in [2, 8]");
  EXPECT_EQ(messageOf([&] { setOption(options, "walks.walk_length", "four"); }),
            "walks.walk_length = four, must be a whole number");
  EXPECT_EQ(messageOf([&] { setOption(options, "merge.mode", "bow"); }),
            "merge.mode = bow, must be one of running_mean, first_observation");
  EXPECT_EQ(messageOf([&] { setOption(options, "match.rare_words", "maybe"); }),
            "match.rare_words = maybe, must be true or false");
}

TEST(SetOption, RefusesWhatOnlyStartsAsANumber) {
  Options options;
  for (const char* text : {"", "4x", "4.5", " 4", "1e1", "0x4", "99999999999999999999"}) {
    EXPECT_THROW(setOption(options, "walks.walk_length", text), UsageError) << "'" << text << "'";
  }
  for (const char* text : {"", "nan", "inf", "0,5", "0.5m"}) {
    EXPECT_THROW(setOption(options, "blobs.tolerance_m", text), UsageError) << "'" << text << "'";
  }
  EXPECT_EQ(toYaml(options), toYaml(Options()));
}

TEST(SetOption, RefusesPriorsAndScalesThatMakeNoSense) {
  Options options;
  EXPECT_EQ(messageOf([&] { setOption(options, "prior.near", "1,2"); }),
            "prior.near = 1,2, must be x,y,radius");
  EXPECT_EQ(messageOf([&] { setOption(options, "prior.yaw", "north,5"); }),
            "prior.yaw = north,5, 'north' is not a number");
  EXPECT_EQ(messageOf([&] { setOption(options, "scale", "2,1"); }),
            "scale = 2,1, must be 0.1 < LOW <= HIGH < 10");
  EXPECT_EQ(toYaml(options), toYaml(Options()));
  setOption(options, "scale", "free");
  setOption(options, "prior.near", "1,2,3");
  setOption(options, "prior.near", "");
  EXPECT_EQ(options.scale, "free");
  EXPECT_EQ(options.prior.near, "") << "nothing said is legal";
}

TEST_F(OptionsFile, ChangesOnlyWhatItNames) {
  EXPECT_EQ(messageFor("walks:\n  num_walks: 17\nseed: 5\n"), "");
  EXPECT_EQ(options_.walks.num_walks, 17);
  EXPECT_EQ(options_.seed, 5);
  EXPECT_EQ(options_.walks.walk_length, match::WalkOptions().walk_length);
}

TEST_F(OptionsFile, MayBeEmptyOrAllComments) {
  EXPECT_EQ(messageFor(""), "");
  EXPECT_EQ(messageFor("# nothing\n"), "");
  EXPECT_EQ(messageFor("walks:\n"), "");
  EXPECT_EQ(toYaml(options_), toYaml(Options()));
}

TEST_F(OptionsFile, SaysPathAndLineOfWhatIsWrong) {
  const std::string path = folder_ / "options.yaml";
  EXPECT_EQ(messageFor("seed: 3\nwalks:\n  num_walk: 3\n"),
            path + ":3: unknown option walks.num_walk; the nearest known one is walks.num_walks");
  EXPECT_EQ(messageFor("walk:\n  num_walks: 3\n"),
            path + ":1: unknown option walk; the nearest known one is walks");
  EXPECT_EQ(messageFor("walks:\n  walk_length: 0\n"),
            path + ":2: walks.walk_length = 0, must be in [2, 8]");
  EXPECT_EQ(messageFor("prior:\n  near: \"1,2,0\"\n"),
            path + ":2: prior.near = 1,2,0, the radius must be positive");
  EXPECT_EQ(messageFor("\nwalks: 3\n"),
            path + ":2: walks is a group of options, expected `key: value` lines below it");
  EXPECT_EQ(messageFor("seed: [1, 2]\n"), path + ":1: seed needs one value");
  EXPECT_EQ(messageFor("seed:\n"), path + ":1: seed needs one value");
  EXPECT_EQ(messageFor("seed: 1\nseed: 2\n"), path + ":2: seed is given a second time");
  EXPECT_EQ(messageFor("- seed\n"), path + ":1: expected `key: value` lines");
  EXPECT_EQ(messageFor("seed: 1\n  walks: [\n").substr(0, path.size() + 12), path + ":2: not YAML");
}

TEST_F(OptionsFile, LeavesTheOptionsAloneIfAnythingIsWrong) {
  messageFor("seed: 7\nwalks:\n  walk_length: 99\n");
  EXPECT_EQ(options_.seed, Options().seed);
}

TEST_F(OptionsFile, ThatIsMissingOrAFolderIsAnError) {
  EXPECT_THROW(applyOptionsFile(options_, folder_ / "absent.yaml"), Error);
  EXPECT_THROW(applyOptionsFile(options_, folder_.path()), Error);
}

TEST_F(OptionsFile, RoundTripsThroughYaml) {
  options_.seed = 123;
  options_.method = "search";
  options_.blobs.tolerance_m = 1.0 / 3;
  options_.match.rare_words = false;
  const std::string yaml = toYaml(options_);
  const std::string path = write(yaml);
  Options read;
  applyOptionsFile(read, path);
  EXPECT_EQ(toYaml(read), yaml);
  EXPECT_EQ(read.blobs.tolerance_m, options_.blobs.tolerance_m);
  EXPECT_EQ(read.method, "search");
}

TEST(ToYaml, MarksDefaults) {
  Options options;
  options.seed = 2;
  const std::string yaml = toYaml(options);
  EXPECT_NE(yaml.find("\nseed: 2\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("walks:\n  num_walks: 0  # default\n"), std::string::npos) << yaml;
}

TEST_F(OptionsFile, ValuesThatAProgramSetsAreCheckedLikeThoseOfAFile) {
  Options options;
  EXPECT_NO_THROW(requireValid(options));
  options.places.cell_m = -3;
  EXPECT_THROW(requireValid(options), UsageError);
}

}  // namespace
}  // namespace xview
