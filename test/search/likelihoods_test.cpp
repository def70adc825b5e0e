// SPDX-License-Identifier: BSD-3-Clause
#include "search/likelihoods.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "base/random.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::search {
namespace {

LikelihoodTable randomTable(std::uint64_t seed) {
  Random random(seed);
  LikelihoodTable table;
  for (auto& viewpoint : table.counts) {
    for (DistanceCounts& counts : viewpoint) {
      for (double& n : counts.at_true) n = random.below(100000);
      for (double& n : counts.at_wrong) n = random.below(100000);
    }
  }
  return table;
}

/// A channel whose samples are near at true poses and far at wrong ones.
LikelihoodTable tellingTable(BevChannel channel, double samples) {
  LikelihoodTable table;
  DistanceCounts& counts = table.at(Viewpoint::ground, channel);
  for (int b = 0; b < kDistanceBins; ++b) {
    counts.at_true[b] = samples * std::pow(0.5, b);
    counts.at_wrong[b] = samples * std::pow(0.5, kDistanceBins - b);
  }
  return table;
}

void expectParseError(const std::string& text, const std::string& place) {
  const std::string said = test::messageOf<Error>([&] { parseLikelihoods(text, "table.txt"); });
  EXPECT_NE(said.find(place), std::string::npos) << text << ": " << said;
  EXPECT_EQ(said.find('\n'), std::string::npos) << "one line";
}

TEST(Likelihoods, SurviveTheirTextForm) {
  const LikelihoodTable table = randomTable(3);
  const LikelihoodTable again = parseLikelihoods(toText(table), "memory");
  for (std::size_t v = 0; v < 2; ++v) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      EXPECT_EQ(again.counts[v][c].at_true, table.counts[v][c].at_true);
      EXPECT_EQ(again.counts[v][c].at_wrong, table.counts[v][c].at_wrong);
    }
  }
  EXPECT_EQ(toText(again), toText(table));
}

TEST(Likelihoods, BadLinesAreNamedByPathAndLine) {
  const std::string good = "# a comment\n\nground road true 1 2 3 4 5 6 7 8 9\n";
  EXPECT_NO_THROW(parseLikelihoods(good, "table.txt"));
  EXPECT_NO_THROW(parseLikelihoods("", "table.txt"));
  EXPECT_NO_THROW(parseLikelihoods("ground road true 1 2 3 4 5 6 7 8 9\r\n", "table.txt"));
  expectParseError(good + "space road true 1 2 3 4 5 6 7 8 9\n", "table.txt:4");
  expectParseError(good + "ground rode true 1 2 3 4 5 6 7 8 9\n", "table.txt:4");
  expectParseError(good + "ground road maybe 1 2 3 4 5 6 7 8 9\n", "table.txt:4");
  expectParseError("ground road wrong 1 2 3 4 5 6 7 8\n", "table.txt:1");
  expectParseError("ground road wrong 1 2 3 4 5 6 7 8 9 10\n", "table.txt:1");
  expectParseError("ground road wrong 1 2 3 4 -5 6 7 8 9\n", "table.txt:1");
  expectParseError("ground road wrong 1 2 x 4 5 6 7 8 9\n", "table.txt:1");
  expectParseError("ground road\n", "table.txt:1");
}

TEST(Likelihoods, AddUp) {
  LikelihoodTable a = randomTable(1);
  const LikelihoodTable before = a, b = randomTable(2);
  a.add(b);
  for (int bin = 0; bin < kDistanceBins; ++bin) {
    const DistanceCounts &sum = a.at(Viewpoint::air, BevChannel::tree),
                         &x = before.at(Viewpoint::air, BevChannel::tree),
                         &y = b.at(Viewpoint::air, BevChannel::tree);
    EXPECT_EQ(sum.at_true[bin], x.at_true[bin] + y.at_true[bin]);
    EXPECT_EQ(sum.at_wrong[bin], x.at_wrong[bin] + y.at_wrong[bin]);
  }
}

TEST(Likelihoods, ThatComeWithTheProgramKnowEveryUsualChannelFromAllViewpoints) {
  const LikelihoodTable& table = defaultLikelihoods();
  for (const Viewpoint v : {Viewpoint::ground, Viewpoint::air, Viewpoint::ground_in_air}) {
    const LogRatios ratios = logRatios(table, v, nullptr, 0);
    for (const BevChannel c : {BevChannel::road, BevChannel::building, BevChannel::pole,
                               BevChannel::border_road_sidewalk}) {
      const auto i = static_cast<std::size_t>(c);
      EXPECT_GT(ratios.value[i][0], 0) << toString(c);
      EXPECT_LT(ratios.value[i][kDistanceBins - 1], 0) << toString(c);
      EXPECT_GT(ratios.expected[i], 0) << toString(c);
    }
  }
}

TEST(Viewpoint, IsThatOfTheGroundForTwoViewsOfOneKind) {
  EXPECT_EQ(viewpointOf(false, false), Viewpoint::ground);
  EXPECT_EQ(viewpointOf(true, true), Viewpoint::ground);
  EXPECT_EQ(viewpointOf(true, false), Viewpoint::air);
  EXPECT_EQ(viewpointOf(false, true), Viewpoint::ground_in_air);
  LikelihoodTable table = defaultLikelihoods();
  const LogRatios ground = logRatios(table, Viewpoint::ground, nullptr, 0);
  constexpr auto kBuilding = static_cast<std::size_t>(BevChannel::building);
  EXPECT_NE(logRatios(table, Viewpoint::ground_in_air, nullptr, 0).value[kBuilding],
            ground.value[kBuilding]);
  table.counts[static_cast<std::size_t>(Viewpoint::ground_in_air)] = {};  // as older files have it
  EXPECT_EQ(logRatios(table, Viewpoint::ground_in_air, nullptr, 0).value[kBuilding],
            ground.value[kBuilding]);
}

TEST(LogRatio, OfUnknownAreaIsExactlyZero) {
  MapNull null{};
  for (auto& channel : null) channel.fill(1000);
  for (const LikelihoodTable& table : {defaultLikelihoods(), randomTable(4), LikelihoodTable()}) {
    for (const MapNull* map_null :
         {static_cast<const MapNull*>(nullptr), static_cast<const MapNull*>(&null)}) {
      const LogRatios ratios = logRatios(table, Viewpoint::ground, map_null, 0.5);
      for (const auto& channel : ratios.value) EXPECT_EQ(channel[kUnknownBin], 0.f);
    }
  }
}

TEST(LogRatio, IsClippedBelowOnly) {
  const LogRatios ratios =
      logRatios(tellingTable(BevChannel::building, 1e9), Viewpoint::ground, nullptr, 0);
  const auto& building = ratios.value[static_cast<std::size_t>(BevChannel::building)];
  EXPECT_EQ(building[kDistanceBins - 1], -2.5f);
  EXPECT_GT(building[0], 2.5f);
  for (const auto& channel : ratios.value) {
    for (const float v : channel) EXPECT_GE(v, -2.5f);
  }
}

TEST(LogRatio, FallsWithDistanceWhereTheCountsDo) {
  const LogRatios ratios =
      logRatios(tellingTable(BevChannel::pole, 1e6), Viewpoint::ground, nullptr, 0);
  const auto& pole = ratios.value[static_cast<std::size_t>(BevChannel::pole)];
  for (int b = 1; b < kDistanceBins; ++b) EXPECT_LE(pole[b], pole[b - 1]);
}

TEST(LogRatio, OfAChannelHardlySeenIsZero) {
  const LogRatios ratios =
      logRatios(tellingTable(BevChannel::pole, 9), Viewpoint::ground, nullptr, 0);
  for (const auto& channel : ratios.value) {
    for (const float v : channel) EXPECT_EQ(v, 0.f);
  }
}

TEST(LogRatio, ShrinksTowardsZeroWithFewCounts) {
  const auto i = static_cast<std::size_t>(BevChannel::pole);
  const LogRatios few =
      logRatios(tellingTable(BevChannel::pole, 40), Viewpoint::ground, nullptr, 0);
  const LogRatios many =
      logRatios(tellingTable(BevChannel::pole, 1e6), Viewpoint::ground, nullptr, 0);
  EXPECT_GT(few.value[i][0], 0);
  EXPECT_LT(few.value[i][0], many.value[i][0]);
}

TEST(LogRatio, FarSamplesSpeakAgainstAPoseAlsoWhereAllTheWayTheBorderIsStraight) {
  const LikelihoodTable table = tellingTable(BevChannel::border_road_terrain, 1e6);
  const auto i = static_cast<std::size_t>(BevChannel::border_road_terrain);
  MapNull straight{};
  straight[i][0] = 1e5;
  const LogRatios here = logRatios(table, Viewpoint::ground, &straight, 0.5);
  EXPECT_LT(here.value[i][kDistanceBins - 1], 0);
  EXPECT_LT(here.value[i][kDistanceBins - 2], here.value[i][0]);
}

TEST(LogRatio, CountsForLessWhereTheMapResemblesItself) {
  const LikelihoodTable table = tellingTable(BevChannel::pole, 1e6);
  const auto i = static_cast<std::size_t>(BevChannel::pole);
  MapNull null{};
  null[i] =
      table.at(Viewpoint::ground, BevChannel::pole).at_true;  // wrong poses look like true ones
  const LogRatios learned = logRatios(table, Viewpoint::ground, nullptr, 0.5);
  const LogRatios none = logRatios(table, Viewpoint::ground, &null, 0);
  const LogRatios half = logRatios(table, Viewpoint::ground, &null, 0.5);
  const LogRatios all = logRatios(table, Viewpoint::ground, &null, 1);
  EXPECT_EQ(none.value[i], learned.value[i]);
  EXPECT_LT(half.value[i][0], none.value[i][0]);
  constexpr double kOfOtherWrongPoses = 0.06;  // off the path
  EXPECT_NEAR(all.value[i][0], 0, kOfOtherWrongPoses);
  EXPECT_NEAR(half.value[i][0], 0.5 * none.value[i][0], kOfOtherWrongPoses);
}

TEST(LogRatio, ExpectedIsTheMeanAtTruePoses) {
  const LikelihoodTable table = tellingTable(BevChannel::pole, 1e9);
  const auto i = static_cast<std::size_t>(BevChannel::pole);
  const LogRatios ratios = logRatios(table, Viewpoint::ground, nullptr, 0);
  double total = 0, sum = 0;
  for (int b = 0; b < kDistanceBins; ++b) {
    const double n = table.at(Viewpoint::ground, BevChannel::pole).at_true[b];
    total += n;
    sum += n * ratios.value[i][b];
  }
  EXPECT_NEAR(ratios.expected[i], sum / total, 1e-4);
}

std::string temporaryFile(const std::string& text) {
  const std::string path = testing::TempDir() + "xview_likelihoods_test.txt";
  std::ofstream(path) << text;
  return path;
}

TEST(LikelihoodFile, HoldsTheCountsThatWereWritten) {
  const LikelihoodTable written = randomTable(3);
  const std::string path = temporaryFile(toText(written));
  const LikelihoodTable read = readLikelihoods(path);
  for (std::size_t v = 0; v < written.counts.size(); ++v) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      EXPECT_EQ(read.counts[v][c].at_true, written.counts[v][c].at_true);
      EXPECT_EQ(read.counts[v][c].at_wrong, written.counts[v][c].at_wrong);
    }
  }
  std::remove(path.c_str());
}

TEST(LikelihoodFile, OfShapesCountsAPostOnce) {
  const LogRatios ratios = logRatios(readLikelihoods(kShapes), Viewpoint::ground, nullptr, 0);
  const auto expected = [&](BevChannel c) { return ratios.expected[static_cast<std::size_t>(c)]; };
  EXPECT_GT(expected(BevChannel::pole), 1);
  EXPECT_EQ(expected(BevChannel::pole_like), 0);
}

TEST(LikelihoodFile, OfShapesInLabelsIsThatOfLabelsFromTheGroundAndThatOfShapesFromTheAir) {
  const LikelihoodTable mixed = readLikelihoods(kShapesInLabels), shapes = readLikelihoods(kShapes);
  for (const BevChannel c : {BevChannel::road, BevChannel::building, BevChannel::pole}) {
    EXPECT_EQ(mixed.at(Viewpoint::ground, c).at_true,
              defaultLikelihoods().at(Viewpoint::ground, c).at_true);
    for (const Viewpoint v : {Viewpoint::air, Viewpoint::ground_in_air})
      EXPECT_EQ(mixed.at(v, c).at_true, shapes.at(v, c).at_true);
  }
}

TEST(LikelihoodFile, ThatIsMissingOrEmptyOrSomethingElseIsAnError) {
  EXPECT_THROW(readLikelihoods("/no/such/file.txt"), Error);
  EXPECT_THROW(readLikelihoods(testing::TempDir()), Error) << "a folder";
  for (const std::string text :
       {"", "# nothing\n", "ground road true 0 0 0 0 0 0 0 0 0\n", "SQLite format 3"}) {
    const std::string path = temporaryFile(text);
    EXPECT_THROW(readLikelihoods(path), Error) << "'" << text << "'";
    std::remove(path.c_str());
  }
}

}  // namespace
}  // namespace xview::search
