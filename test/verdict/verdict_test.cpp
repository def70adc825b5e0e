// SPDX-License-Identifier: BSD-3-Clause
#include "verdict/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "base/random.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::verdict {
namespace {

const VerdictOptions kOptions;

Verdict judged(const Evidence& e) { return judge(e, kOptions); }

Evidence goodView() {
  Evidence e;
  e.of_surfaces = true;
  e.score = 300;
  e.runner_up = e.best_unverified = 60;
  e.expected = 310;
  e.obstacles = {140, 150};
  e.map_coverage = 0.9;
  return e;
}

/// Of a bare graph, which has no parts, and of walks, which know no expected score.
Evidence goodGraph() {
  Evidence e;
  e.score = 48;
  e.runner_up = 2;
  e.expected = 55;
  e.map_coverage = 0.8;
  return e;
}

/// The second-best place was registered, too.
void verifySecondBest(Evidence& e) {
  e.alternatives.emplace_back();
  e.alternatives[0].score = e.runner_up;
}

/// Points whose registration converged.
DenseEvidence points(double agreement, double null_inlier_ratio,
                     std::optional<double> map_overlap = {},
                     std::optional<double> self_consistency = {},
                     std::optional<double> free_space_violation = {}) {
  DenseEvidence dense;
  dense.of = DenseEvidence::Of::points;
  dense.converged = true;
  dense.inlier_ratio = agreement;
  dense.null_inlier_ratio = null_inlier_ratio;
  dense.map_overlap = map_overlap;
  dense.self_consistency = self_consistency;
  dense.free_space_violation = free_space_violation;
  return dense;
}

Evidence randomEvidence(Random& random) {
  Evidence e;
  e.score = random.uniform(-50, 400);
  e.runner_up = random.uniform(-50, 200);
  e.expected = random.uniform(-50, 500);
  e.obstacles = {random.uniform(-50, 200), random.uniform(-10, 200)};
  e.map_coverage = random.uniform();
  e.windows = 1 + static_cast<int>(random.below(6));
  e.kept_if_true = random.uniform(0.05, 0.95);
  e.with_candidates = static_cast<int>(random.below(40));
  e.kept = static_cast<int>(random.below(40));
  e.kept_under_null = random.uniform(0, 40);
  e.third = random.uniform(-50, e.runner_up);
  e.dense.of = static_cast<DenseEvidence::Of>(random.below(3));
  e.dense.converged = random.below(2);
  e.dense.inlier_ratio = random.uniform();
  e.dense.null_inlier_ratio = random.uniform(0, 0.3);
  e.dense.aerial = random.below(2);
  e.dense.narrow = random.below(2);
  e.dense.indoors = !e.dense.narrow && random.below(2);
  if (random.below(2)) e.dense.conflict_ratio = random.uniform();
  if (random.below(2)) e.dense.obstacle_overlap = random.uniform(-1, 1.5);
  if (random.below(2)) e.dense.miss_ratio = random.uniform();
  if (random.below(2))
    e.dense.map_overlap = random.uniform(-1, 1);
  else if (random.below(2))
    e.dense.self_consistency = random.uniform();
  if (random.below(2)) e.dense.free_space_violation = random.uniform();
  e.of_surfaces = random.below(2);
  e.best_unverified = random.uniform(-50, e.runner_up);
  if (random.below(2)) e.alternatives = {static_cast<PlaceEvidence&>(e)};
  for (PlaceEvidence& rival : e.alternatives) {
    rival.score = e.runner_up;
    rival.dense.inlier_ratio = random.uniform();
  }
  return e;
}

TEST(Verdict, GoodEvidenceIsAcceptedWhateverItIsOf) {
  EXPECT_EQ(judged(goodView()).status, Status::accepted) << judged(goodView()).reason;
  EXPECT_GT(judged(goodView()).confidence, 0.99);
  EXPECT_EQ(judged(goodGraph()).status, Status::accepted) << judged(goodGraph()).reason;
  Evidence walks;
  walks.score = 60;
  walks.runner_up = 6;
  EXPECT_EQ(judged(walks).status, Status::accepted) << judged(walks).reason;
}

TEST(Verdict, AcceptedIsExactlyWhatReachesTheConfidence) {
  Random random(5);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const Evidence e = randomEvidence(random);
    VerdictOptions options;
    options.min_confidence = random.uniform(0.5, 0.9999);
    const Verdict v = judge(e, options);
    EXPECT_EQ(v.status == Status::accepted, v.confidence >= options.min_confidence);
    EXPECT_GE(v.confidence, 0);
    EXPECT_LE(v.confidence, 1);
    EXPECT_EQ(v.reason.find('\n'), std::string::npos);
    EXPECT_EQ(v.reason.find("nan"), std::string::npos) << v.reason;
    EXPECT_FALSE(v.reason.empty());
    if (v.status != Status::accepted) continue;
    ++accepted;
    EXPECT_TRUE(e.score > e.runner_up || v.statistics.dense_margin > 0)
        << "it stands out by something";
    EXPECT_GE(e.map_coverage, options.min_known_share);
  }
  EXPECT_GT(accepted, 100) << "or nothing was tested";
}

TEST(Verdict, FloorsThatAreAlikeAreAmbiguousAndManyFloorsAskForMore) {
  Evidence e = goodView();
  e.dense = points(0.8, 0.05, 0.9);
  const Verdict alone = judged(e);
  ASSERT_EQ(alone.status, Status::accepted);
  e.storeys = 4;
  e.other_storey = 0.4;
  const Verdict among_four = judged(e);
  EXPECT_EQ(among_four.status, Status::accepted);
  EXPECT_LT(among_four.confidence, alone.confidence);
  e.other_storey = 0.6;
  EXPECT_EQ(judged(e).status, Status::ambiguous);
  EXPECT_EQ(judged(e).reason_code, ReasonCode::ambiguous);
  EXPECT_NE(judged(e).reason.find("60 %"), std::string::npos) << judged(e).reason;
  e.other_storey = 0;
  e.storeys = 1e12;
  EXPECT_NE(judged(e).status, Status::accepted);
}

TEST(Verdict, PointsWhoseRegistrationDidNotConvergeAreNeverAccepted) {
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    Evidence e = randomEvidence(random);
    e.score *= 10;
    e.dense.of = DenseEvidence::Of::points;
    e.dense.converged = false;
    EXPECT_NE(judged(e).status, Status::accepted);
  }
  Evidence e = goodView();
  e.score = e.expected = 3000;
  e.dense.of = DenseEvidence::Of::points;
  EXPECT_EQ(judged(e).reason.substr(0, 83),
            "the best place does not hold: the registration does not converge there");
}

TEST(Verdict, ConfidenceNeverFallsWithBetterEvidence) {
  const auto improvements = {
      +[](Evidence& e) { e.score += 10; },
      +[](Evidence& e) { e.runner_up -= 10; },
      +[](Evidence& e) { e.best_unverified -= 10; },
      +[](Evidence& e) {
        for (PlaceEvidence& rival : e.alternatives) rival.dense.inlier_ratio -= 0.1;
      },
      +[](Evidence& e) { e.obstacles.score += 10; },
      +[](Evidence& e) { e.map_coverage += 0.05; },
      +[](Evidence& e) { e.dense.inlier_ratio += 0.1; },
      +[](Evidence& e) { e.dense.null_inlier_ratio -= 0.1; },
      +[](Evidence& e) {
        if (e.dense.map_overlap) *e.dense.map_overlap += 0.1;
      },
      +[](Evidence& e) {
        if (e.dense.conflict_ratio) *e.dense.conflict_ratio *= 0.8;
      },
      +[](Evidence& e) {
        if (e.dense.obstacle_overlap) *e.dense.obstacle_overlap += 0.1;
      },
      +[](Evidence& e) {
        if (e.dense.miss_ratio) *e.dense.miss_ratio *= 0.8;
      },
      +[](Evidence& e) {
        if (e.dense.free_space_violation) *e.dense.free_space_violation *= 0.5;
      },
  };
  Random random(6);
  int grown = 0;
  for (int i = 0; i < 2000; ++i) {
    Evidence worse = randomEvidence(random);
    worse.expected = std::abs(worse.expected) + 1;
    for (const auto& improve : improvements) {
      Evidence better = worse;
      improve(better);
      EXPECT_GE(judged(better).confidence, judged(worse).confidence);
      grown += judged(better).confidence > judged(worse).confidence;
    }
  }
  EXPECT_GT(grown, 1000);
}

TEST(Verdict, ViewsThatAgreeMoreTellMoreThanPointsThatDo) {
  const auto marginBy = [](DenseEvidence::Of of, double more) {
    PlaceEvidence next;
    next.score = 250;
    next.dense.of = of;
    next.dense.converged = true;
    next.dense.inlier_ratio = 0.3;
    next.dense.map_overlap = 0;
    Evidence e = goodView();
    e.dense = next.dense;
    e.dense.inlier_ratio += more;
    e.best_unverified = 0;
    e.alternatives = {next};
    return statisticsOf(e).dense_margin;
  };
  using Of = DenseEvidence::Of;
  EXPECT_NEAR(marginBy(Of::views, 0), marginBy(Of::points, 0), 1e-12);
  EXPECT_GT(marginBy(Of::points, 0.1), marginBy(Of::points, 0) + 1);
  EXPECT_GT(marginBy(Of::views, 0.1), marginBy(Of::points, 0.1) + 0.5);
}

/// The same evidence says less where wrong places of the map show nearly as much.
TEST(Verdict, EvidenceIsComparedWithWrongPlacesOfTheMapAtHand) {
  Evidence e = goodView();
  e.dense = points(0.2, 0.05);
  e.dense.miss_ratio = 0.3;
  e.dense.obstacle_overlap = 0.7;
  const auto confidenceAmong = [&](const std::vector<WrongPlace>& wrong_places) {
    return judge(e, kOptions, defaultVerdictModel(), wrong_places).confidence;
  };
  const WrongPlace usual{kUsualWrongPlaceAboveNull, kUsualWrongPlaceMissRatio, {}, {}};
  const std::vector<WrongPlace> alike(60, {0.3, 0.2, {}, {}}), unique(60, {0.02, 0.6, {}, {}});
  e.runner_up = e.best_unverified = 240;
  e.dense.conflict_ratio = 0.25;
  for (const bool narrow : {false, true}) {
    e.dense.narrow = narrow;
    e.dense.map_overlap = narrow ? std::nullopt : std::optional(0.05);
    EXPECT_NEAR(confidenceAmong({}), confidenceAmong({60, usual}), 1e-12);
    EXPECT_NEAR(confidenceAmong({}), confidenceAmong({60, WrongPlace{}}), 1e-12) << "not asked";
    EXPECT_LT(confidenceAmong(alike), confidenceAmong({}));
    EXPECT_LT(confidenceAmong({}), confidenceAmong(unique));
  }
  const Statistics s = judge(e, kOptions, defaultVerdictModel(), alike).statistics;
  EXPECT_NEAR(s.wrong_place_above_null, (60 * 0.3 + 4 * kUsualWrongPlaceAboveNull) / 64, 1e-12);
  EXPECT_NEAR(s.wrong_place_miss_ratio, (60 * 0.2 + 4 * kUsualWrongPlaceMissRatio) / 64, 1e-12);
}

/// Check fix for: in streets of flush houses right places were refused though none of the wrong
/// ones fitted nearly as closely.
TEST(Verdict, WrongPlacesSayLittleOfAPlaceThatFitsFarMoreCloselyThanAllOfThem) {
  Evidence e = goodView();
  const auto oddsAt = [&](double inlier_ratio, double off) {
    e.dense = points(inlier_ratio, 0);
    std::vector<WrongPlace> wrong_places(30, {0.35 - off, 0.3, {}, {}});
    wrong_places.resize(60, {0.35 + off, 0.3, {}, {}});
    const Statistics s = judge(e, kOptions, defaultVerdictModel(), wrong_places).statistics;
    return termsOf(s)[kWrongPlaceAboveNull];
  };
  EXPECT_DOUBLE_EQ(oddsAt(0.75, 0.05), 0);
  EXPECT_GT(oddsAt(0.75, 0.15), 0.2) << "some of them fit nearly as closely";
  EXPECT_GT(oddsAt(0.45, 0.05), 0.2) << "it fits as they do";
  EXPECT_GT(oddsAt(0.57, 0.05), oddsAt(0.62, 0.05));
}

TEST(Verdict, APoseThatIsOpenByMetresIsNotRight) {
  Evidence e = goodView();
  const double confidence = judged(e).confidence;
  e.sigma_m = 0.3;
  EXPECT_NEAR(judged(e).confidence, confidence, 1e-12);
  e.sigma_m = 5;
  EXPECT_EQ(judged(e).status, Status::rejected);
  EXPECT_NEAR(judged(e).confidence, 0.4515 * confidence, 1e-3) << "3 m are 0.6 sigma";
  EXPECT_NE(judged(e).reason.find("open"), std::string::npos) << judged(e).reason;
}

TEST(Verdict, ALayoutWhoseHousesContradictIsRefused) {
  Evidence e = goodView();
  e.score = 130;
  e.obstacles.score = -14;
  EXPECT_EQ(judged(e).status, Status::rejected) << "roads alone repeat between towns";
  e.obstacles.score = 30;
  EXPECT_LT(judged(e).confidence, judged(goodView()).confidence);
}

TEST(Verdict, WithoutAnythingUprightTheRestDecides) {
  Evidence e = goodView();
  e.obstacles = {};
  EXPECT_EQ(judged(e).status, Status::accepted);
}

TEST(Verdict, TwoPlacesAreAmbiguousOnlyIfEachCouldBeBelieved) {
  Evidence e = goodView();
  e.runner_up = 290;
  e.third = 280;
  EXPECT_EQ(judged(e).status, Status::ambiguous) << "several places fit as a true one would";
  e.expected = 600;
  EXPECT_EQ(judged(e).status, Status::rejected) << "a stranger fits everywhere a little";
  e.expected = 310;
  e.third = 60;
  EXPECT_EQ(judged(e).status, Status::ambiguous);
  e.second_best_distance_m = 84;
  EXPECT_NE(judged(e).reason.find("84 m apart"), std::string::npos) << judged(e).reason;
  e.dense.of = DenseEvidence::Of::points;
  e.dense.converged = true;
  e.dense.inlier_ratio = 0.05;
  EXPECT_EQ(judged(e).status, Status::rejected) << "neither can be where nothing lies on its like";
}

TEST(Verdict, PointsDecideBetweenPlacesThatScoreAlike) {
  Evidence e = goodView();
  e.score = 160;
  e.runner_up = 90;
  e.dense.of = DenseEvidence::Of::points;
  verifySecondBest(e);
  e.alternatives[0].dense = points(0.1, 0.04);
  EXPECT_NE(judged(e).status, Status::accepted) << "points that do not settle";
  e.dense.converged = true;
  e.dense.inlier_ratio = 0.12;
  e.dense.null_inlier_ratio = 0.04;
  EXPECT_NE(judged(e).status, Status::accepted) << judged(e).reason;
  e.dense.inlier_ratio = 0.5;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.alternatives[0].dense.inlier_ratio = 0.5;
  EXPECT_NE(judged(e).status, Status::accepted) << "points agree at the next place as well";
  e.alternatives[0].dense.inlier_ratio = 0.1;
  e.dense.null_inlier_ratio = 0.35;
  EXPECT_NE(judged(e).status, Status::accepted) << "in a room full of chairs chairs meet chairs";
}

/// Aisles look alike from above, not to the centimetre.
TEST(Verdict, APlaceThatItsPointsStandOutByNeedNotScoreBest) {
  Evidence e = goodView();
  e.score = 200;
  e.expected = 210;
  e.runner_up = 230;
  verifySecondBest(e);
  e.dense = points(0.6, 0.1, {}, 0.7, 0.01);
  e.alternatives[0].dense = points(0.35, 0.1, {}, 0.7, 0.2);
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  EXPECT_NE(judged(e).reason.find("looks like it from above"), std::string::npos)
      << judged(e).reason;
  e.alternatives[0].dense = e.dense;
  EXPECT_LE(judged(e).confidence, 0.5) << "one of two at best";
  e.alternatives.clear();
  e.best_unverified = 230;
  EXPECT_LE(judged(e).confidence, 0.5) << "nobody looked at it: it may fit as well";
}

TEST(Verdict, StrangersHangOverTheEdgeOfTheMap) {
  Evidence e = goodView();
  e.score = 190;
  e.expected = 290;
  e.obstacles = {60, 120};
  e.dense = points(0.25, 0.03, 0.4);
  const double inside = judged(e).confidence;
  e.map_coverage = 0.4;
  EXPECT_LT(1 - inside, 0.4 * (1 - judged(e).confidence));
}

/// Check fix for: a bare graph needed a margin of 71 nats, where no wrong one of 1116 had 15.
TEST(Verdict, AMarginOfVerticesSaysMoreThanOneOfSurfaces) {
  Evidence e = goodGraph();
  e.score = 32;
  e.runner_up = 10;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.expected = 200;
  EXPECT_EQ(judged(e).status, Status::accepted) << "what a true pose scores is not known";
  e.expected = e.score;
  e.of_surfaces = true;
  EXPECT_EQ(judged(e).status, Status::rejected) << "roads and houses score by hundreds of nats";
  e.score = 300;
  const double confidence = judged(e).confidence;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.expected = 2000;
  EXPECT_GT(1 - judged(e).confidence, 3 * (1 - confidence)) << "most of it is not in the map";
}

/// Check fix for: 8 of 67 graphs whose tiles were exchanged were accepted where one tile fits.
TEST(Verdict, VerticesOfAGraphThatAreNotInTheMapCount) {
  Evidence e = goodGraph();
  e.score = 22;
  e.runner_up = 0;
  e.vertices = 100;
  e.paired = 80;
  const Verdict most = judged(e);
  EXPECT_EQ(most.status, Status::accepted) << most.reason;
  EXPECT_NEAR(most.statistics.vertex_inlier_ratio, 0.8, 1e-12);
  e.paired = 18;
  EXPECT_EQ(judged(e).status, Status::rejected) << judged(e).reason;
}

TEST(Verdict, SaysHowMuchMoreWouldTell) {
  Evidence e = goodView();
  e.score = 60;
  e.runner_up = 30;
  e.third = 28;
  e.expected = 60;
  e.obstacles = {};
  e.travel_m = 30;
  ASSERT_EQ(judged(e).status, Status::rejected) << judged(e).reason;
  EXPECT_NE(judged(e).reason.find("m more would tell"), std::string::npos) << judged(e).reason;
  e.travel_m = 0;
  EXPECT_EQ(judged(e).reason.find("more would tell"), std::string::npos) << "it did not move";
}

TEST(Verdict, RefusedByAHairSaysAtWhichRiskItIsAccepted) {
  constexpr const char* kSaid = "accepted at a risk of ";
  Random random(6);
  int said = 0;
  for (int i = 0; i < 20000; ++i) {
    const Evidence e = randomEvidence(random);
    VerdictOptions options;
    const Verdict refused = judge(e, options);
    const std::size_t at = refused.reason.find(kSaid);
    if (at == std::string::npos) continue;
    ++said;
    EXPECT_EQ(refused.status, Status::rejected);
    const double risk = std::stod(refused.reason.substr(at + std::strlen(kSaid)));
    EXPECT_GT(risk, 0.01);
    EXPECT_LE(risk, 0.1);
    options.min_confidence = 1 - risk;
    EXPECT_EQ(judge(e, options).status, Status::accepted) << refused.reason;
  }
  EXPECT_GT(said, 20);
}

TEST(Verdict, MoreWindowsNeedMore) {
  Evidence e = goodView();
  e.score = 130;
  e.expected = 130;
  e.obstacles = {};
  const double one = judged(e).confidence;
  e.windows = 4;
  EXPECT_LT(judged(e).confidence, one) << "sums of wrong places spread with the root of windows";
}

TEST(Verdict, WithoutEvidenceIsRejected) {
  EXPECT_EQ(judged({}).status, Status::rejected);
  EXPECT_EQ(judged({}).confidence, 0);
  Evidence no_number = goodView();
  no_number.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judged(no_number).status, Status::rejected);
  EXPECT_EQ(judged(no_number).confidence, 0);
  Evidence worse_than_chance = goodView();
  worse_than_chance.score = -50;
  worse_than_chance.runner_up = -800;
  EXPECT_EQ(judged(worse_than_chance).status, Status::rejected);
}

TEST(Verdict, OutsideTheMapIsRejectedAndSaysSo) {
  Evidence e = goodView();
  e.map_coverage = 0.1;
  EXPECT_EQ(judged(e).status, Status::rejected);
  EXPECT_LT(judged(e).confidence, 0.5);
  EXPECT_NE(judged(e).reason.find("10 %"), std::string::npos) << judged(e).reason;
}

TEST(Verdict, APlaceThatTheQueryDoesNotShowIsRefused) {
  Evidence e = goodView();
  e.dense = points(0.35, 0.05, 0.5);
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.score = 120;
  e.obstacles.score = 60;
  e.dense.map_overlap = -0.6;
  e.dense.miss_ratio = 0.6;
  EXPECT_NE(judged(e).status, Status::accepted);
  EXPECT_NE(judged(e).reason.find("does not show"), std::string::npos) << judged(e).reason;
}

/// Rooms are alike: what agrees is told by what a true place could show.
TEST(Verdict, PointsMustAgreeAsTheQueryAgreesWithItself) {
  Evidence e = goodView();
  e.runner_up = 0.7 * e.score;
  verifySecondBest(e);
  e.dense = points(0.4, 0.05, {}, 0.5);
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  const double margin = statisticsOf(e).dense_margin;
  e.dense.self_consistency = 0.8;
  EXPECT_LT(statisticsOf(e).dense_margin, margin - 1);
}

/// Check fix for: two frames of a camera, whose halves show little of one another because they
/// hardly overlap, were accepted 72 m off with a confidence of 1 - 1e-8, and two of 88 in another
/// town.
TEST(Verdict, PointsThatTheQueryHardlyHasTwiceAreNotHeldAgainstThem) {
  Evidence e = goodView();
  e.score = 49;
  e.runner_up = 35;
  e.best_unverified = 20;
  verifySecondBest(e);
  e.dense = points(0.2, 0.03, {}, 0.09);
  EXPECT_NE(judged(e).status, Status::accepted) << judged(e).confidence;
  e.dense = points(0.33, 0.01, {}, 0.23, 0.22);
  EXPECT_NE(judged(e).status, Status::accepted) << judged(e).confidence;
}

/// The evidence of a place whose margins do not decide alone.
Evidence closeCall() {
  Evidence e = goodView();
  e.runner_up = 140;
  e.best_unverified = 20;
  verifySecondBest(e);
  e.dense = points(0.4, 0.06, {}, 0.6, 0.1);
  e.alternatives[0].dense = points(0.25, 0.06, {}, 0.6, 0.1);
  return e;
}

/// Check fix for: a frame of a camera outdoors, whose points lie closely at a place that another
/// one resembles, was accepted 52 m off with a confidence of 1 - 1e-6.
TEST(Verdict, AFewFramesMustStandOutOfOtherPlacesToo) {
  Evidence e = goodView();
  e.score = 51.3;
  e.runner_up = 43.4;
  e.expected = 57.8;
  e.best_unverified = 20;
  e.map_coverage = 0.72;
  verifySecondBest(e);
  e.dense = points(0.565, 0, {}, 0.61);
  e.dense.narrow = true;
  e.dense.obstacle_overlap = 0.95;
  e.dense.conflict_ratio = 0.19;
  const double alone = judged(e).confidence;
  EXPECT_LT(alone, 0.999);
  e.alternatives[0].dense = points(0.5, 0, {}, 0.61);
  EXPECT_NE(judged(e).status, Status::accepted) << "the other one was looked at, too";
  e.score = 260;
  e.expected = 270;
  EXPECT_GT(judged(e).confidence, alone);
}

/// Check fix for: in offices nine of 2173 wrong answers were accepted, whose points lay as closely
/// as those of other rooms of the map do.
TEST(Verdict, ARoomMustFitBetterThanOtherRoomsOfItsMap) {
  Evidence e = closeCall();
  const auto in = [&](double above_null) {
    const std::vector<WrongPlace> wrong_places(60, {above_null, 0.4, {}, {}});
    return judge(e, kOptions, defaultVerdictModel(), wrong_places).status;
  };
  EXPECT_EQ(in(0.05), Status::accepted);
  EXPECT_NE(in(0.22), Status::accepted);
  e.dense.inlier_ratio = 0.75;
  EXPECT_EQ(in(0.22), Status::accepted);
}

TEST(Verdict, APlaceThatTheQuerySawThroughIsRefused) {
  Evidence e = closeCall();
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.dense.free_space_violation = e.alternatives[0].dense.free_space_violation = 2;
  EXPECT_NE(judged(e).status, Status::accepted);
  EXPECT_NE(judged(e).reason.find("saw through"), std::string::npos) << judged(e).reason;
}

/// From the air a town fits another one with its roads; roofs and crowns stand elsewhere.
TEST(Verdict, FromTheAirWhatTheMapHasNotSpeaksAgainstAPlace) {
  Evidence e = goodView();
  e.runner_up = 140;
  verifySecondBest(e);
  e.obstacles.score = 3;  // what a true pose would score is known badly from there
  e.dense = points(0.25, 0.1, 0.15);
  e.dense.of = DenseEvidence::Of::views;
  e.dense.conflict_ratio = 0.2;
  e.dense.aerial = true;
  e.map_coverage = 0.4;
  e.alternatives[0].dense = e.dense;
  e.alternatives[0].dense.inlier_ratio = 0.05;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.dense.conflict_ratio = 1;
  EXPECT_NE(judged(e).status, Status::accepted);
  EXPECT_NE(judged(e).reason.find("the map does not show"), std::string::npos) << judged(e).reason;
}

/// Check fix for: single frames lay closely in another town (0.47 above null) and were accepted
/// with a confidence of 1 - 1e-4.
TEST(Verdict, FromTheAirAPlaceMustStandOutOfOthers) {
  Evidence e = goodView();
  verifySecondBest(e);
  e.best_unverified = 20;
  e.score = 83;
  e.runner_up = e.alternatives[0].score = 69;
  e.map_coverage = 0.23;
  e.dense = points(0.51, 0.04, -0.05);
  e.dense.of = DenseEvidence::Of::views;
  e.dense.conflict_ratio = 0.13;
  e.dense.aerial = true;
  EXPECT_NE(judged(e).status, Status::accepted) << judged(e).confidence;
  e.score = 160;
  e.map_coverage = 0.45;
  e.dense.inlier_ratio = 0.4;
  e.dense.null_inlier_ratio = 0.16;
  e.dense.map_overlap = 0.09;
  e.dense.conflict_ratio = 0.24;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.runner_up = e.alternatives[0].score = 150;
  EXPECT_NE(judged(e).status, Status::accepted) << judged(e).confidence;
}

TEST(Verdict, AStreetThatStandsOutButIsNotShownIsRefused) {
  Evidence e = closeCall();
  e.dense.map_overlap = 0.35;
  e.alternatives[0].dense.map_overlap = 0.1;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.dense.map_overlap = -0.5;
  e.alternatives[0].dense.map_overlap = -0.75;
  e.dense.miss_ratio = 0.4;
  EXPECT_NE(judged(e).status, Status::accepted);
  EXPECT_NE(judged(e).reason.find("the query does not show"), std::string::npos)
      << judged(e).reason;
  // Check fix for: where nothing is in conflict the reason was the self-consistency, which is not
  // measured beside a map overlap.
  e.dense.conflict_ratio = 0.1;
  e.dense.self_consistency.reset();
  EXPECT_NE(judged(e).reason.find("the query does not show"), std::string::npos)
      << judged(e).reason;
}

/// A copy of a street with other houses between its own: it fits the better the longer it is.
TEST(Verdict, WhatStandsElsewhereIsAsGoodAReasonAsWhatIsMissing) {
  Evidence e = closeCall();
  e.dense.conflict_ratio = 0.2;
  EXPECT_EQ(judged(e).status, Status::accepted) << judged(e).reason;
  e.dense.conflict_ratio = 1;
  EXPECT_NE(judged(e).status, Status::accepted);
  EXPECT_NE(judged(e).reason.find("the map does not show"), std::string::npos) << judged(e).reason;
}

/// A similar room of another building is clearly better than the other rooms of the map, but its
/// inlier ratio is far below the self-consistency of the query.
TEST(Verdict, ASimilarRoomReachesLessThanTheSelfConsistency) {
  Evidence e = goodView();
  e.runner_up = 140;
  verifySecondBest(e);
  const std::vector<WrongPlace> similar_rooms(20, WrongPlace{0.2, {}, {}, {}});
  const auto fitting = [&](double inlier_ratio, double elsewhere) {
    e.dense = points(inlier_ratio, 0.08, {}, 0.65, 0.02);
    e.alternatives[0].dense = points(elsewhere, 0.08);
    return judge(e, kOptions, defaultVerdictModel(), similar_rooms);
  };
  EXPECT_EQ(fitting(0.6, 0.4).status, Status::accepted) << fitting(0.6, 0.4).reason;
  const Verdict similar_room = fitting(0.36, 0.16);
  EXPECT_EQ(similar_room.reason_code, ReasonCode::contradicted) << similar_room.reason;
  EXPECT_NE(similar_room.reason.find("65 % between halves of the query"), std::string::npos);
}

/// The reason names the term that is farthest from what it is of right answers.
TEST(Verdict, SaysWhatDecides) {
  Evidence e = closeCall();
  e.map_coverage = 0.16;
  e.runner_up = e.alternatives[0].score = 20;
  e.dense.inlier_ratio = 0.4;
  e.alternatives[0].dense.inlier_ratio = 0.3;
  EXPECT_EQ(judged(e).reason_code, ReasonCode::out_of_map) << judged(e).reason;
  e = closeCall();
  e.dense.inlier_ratio = 0.07;
  e.alternatives[0].dense.inlier_ratio = 0;
  EXPECT_EQ(judged(e).reason_code, ReasonCode::contradicted) << judged(e).reason;
  EXPECT_NE(judged(e).reason.find("inlier ratio"), std::string::npos) << judged(e).reason;
  e = closeCall();
  e.alternatives[0].dense = e.dense;
  e.runner_up = e.third = e.alternatives[0].score = 140;
  e.score = 150;
  e.expected = 400;
  EXPECT_EQ(judged(e).reason_code, ReasonCode::too_short) << judged(e).reason;
}

/// Check fix for: what the second-best place refused was said to be open by metres.
TEST(Verdict, SaysThatASecondPlaceFitsNearlyAsClosely) {
  Evidence e = goodView();
  e.runner_up = 140;
  verifySecondBest(e);
  e.dense = points(0.9, 0, 0.9);
  e.alternatives[0].dense = points(0.9, 0, 0.9);
  const Verdict v = judged(e);
  EXPECT_EQ(v.status, Status::rejected);
  EXPECT_EQ(v.reason_code, ReasonCode::too_short) << v.reason;
  EXPECT_NE(v.reason.find("nearly as closely"), std::string::npos) << v.reason;
}

TEST(Witnesses, SayWhatEachKnows) {
  Evidence e = goodView();
  e.with_candidates = 30;
  e.kept_if_true = 0.6;
  e.kept_under_null = 8;
  e.kept = 20;
  EXPECT_GT(judged(e).witnesses.correspondences, 5);
  e.kept = 7;
  EXPECT_LT(judged(e).witnesses.correspondences, -5);
  e.dense = points(0.6, 0.05);
  EXPECT_GT(judged(e).witnesses.dense, 0);
  e.dense.inlier_ratio = 0.1;
  EXPECT_LT(judged(e).witnesses.dense, 0);
  EXPECT_EQ(judged(goodGraph()).witnesses.dense, 0) << "without points nothing is said";
}

// ---- The model ----

/// Answers of a world in which confidence is what `truth` says.
std::vector<JudgedStatistics> answersOf(const VerdictModel& truth, int count) {
  Random random(11);
  std::vector<JudgedStatistics> answers;
  for (int i = 0; i < count; ++i) {
    const Evidence e = randomEvidence(random);
    if (e.score <= 0) continue;
    const Verdict v = judge(e, kOptions, truth);
    const double odds = v.witnesses.place + v.witnesses.dense;
    answers.push_back({v.statistics, random.uniform() < 1 / (1 + std::exp(-odds)),
                       static_cast<std::size_t>(i % 8)});
  }
  return answers;
}

TEST(VerdictModel, IsFoundFromAnswers) {
  VerdictModel truth;
  truth.bare[kMargin] = 0.9;
  truth.registered[kMargin] = 1.2;
  truth.registered[kInlierRatio] = 0.8;
  truth.registered[kOverlap] = 3;
  truth.registered[kMapCoverage] = 1.5;
  truth.registered[kFreeSpace] = 2;
  const VerdictModel found = fitVerdictModel(answersOf(truth, 120000));
  // Calibration scales all alike.
  const double scale = found.registered[kMargin] / truth.registered[kMargin];
  for (const Term t : {kInlierRatio, kOverlap, kMapCoverage, kFreeSpace})
    EXPECT_NEAR(found.registered[t], scale * truth.registered[t],
                0.15 * scale * truth.registered[t])
        << toString(t);
  EXPECT_GT(found.bare[kMargin], 0.2);
}

/// Answers of three bands of one witness, in worlds that are alike.
std::vector<JudgedStatistics> answersOfBands(double right_of_surest) {
  struct Band {
    double map_overlap, right;
  };
  std::vector<JudgedStatistics> answers;
  Statistics statistics;
  statistics.dense_margin = 12;
  statistics.dense = points(0.5, 0.1, 0.5);
  for (const Band& band : {Band{0.1, 0.05}, Band{0.35, 0.5}, Band{0.6, right_of_surest}}) {
    statistics.dense.map_overlap = band.map_overlap;
    for (std::size_t i = 0; i < 4000; ++i)
      answers.push_back({statistics, static_cast<double>(i) < 4000 * band.right, i % 4});
  }
  return answers;
}

double logOddsOf(const Statistics& s, const VerdictModel& model) {
  return model.weightsFor(s).logOdds(termsOf(s));
}

/// What is said is the share of wrong ones among all that are at least as sure, with a reserve.
TEST(VerdictModel, OfAnswersThatAreAcceptedAsManyAreRightAsTheySay) {
  constexpr double kRight = 0.95;
  const std::vector<JudgedStatistics> answers = answersOfBands(kRight);
  const double said = logOddsOf(answers.back().statistics, fitVerdictModel(answers));
  const double rights = 0.05 + 0.5 + kRight;
  const double right = kRight / rights, wrong = (1 - kRight) / (3 - rights);
  EXPECT_LT(said, std::log(right / wrong)) << "no surer than it is";
  EXPECT_GT(said, std::log(right / wrong) - 2.5) << "not much less";
}

TEST(VerdictModel, IsTheSurerTheFewerOfTheSurestAreWrong) {
  const auto sureOf = [](double right) {
    const std::vector<JudgedStatistics> answers = answersOfBands(right);
    return logOddsOf(answers.back().statistics, fitVerdictModel(answers));
  };
  EXPECT_GT(sureOf(0.95), sureOf(0.9));
  EXPECT_GT(sureOf(0.99), sureOf(0.95));
  EXPECT_LT(sureOf(1), 20) << "no wrong one bounds it, so it is bounded";
}

/// A witness that is right in one world only sets weights that other worlds do not confirm.
TEST(VerdictModel, IsCalibratedOnWorldsThatDidNotSetTheWeights) {
  const auto sureOf = [](bool one_world) {
    std::vector<JudgedStatistics> answers = answersOfBands(0.95);
    for (std::size_t i = 0; i < answers.size(); ++i) {
      JudgedStatistics& answer = answers[i];
      // Coverage tells right from wrong in worlds 0 and 1 and not in others.
      const bool tells = answer.group < 2 || one_world;
      answer.statistics.map_coverage = (tells ? answer.right : i % 3 == 0) ? 0.9 : 0.3;
      if (one_world) answer.group = 0;
    }
    Statistics surest = answers.back().statistics;
    surest.map_coverage = 0.9;
    return logOddsOf(surest, fitVerdictModel(answers));
  };
  EXPECT_GT(sureOf(true), sureOf(false) + 1);
}

TEST(VerdictModel, LeavesATermOutThatWouldCountTheWrongWay) {
  std::vector<JudgedStatistics> answers = answersOfBands(0.95);
  for (JudgedStatistics& answer : answers)
    answer.statistics.map_coverage = answer.right ? 0.5 : 0.9;
  const VerdictModel found = fitVerdictModel(answers);
  EXPECT_NEAR(found.registered[kMapCoverage], 0, 1e-9);
  EXPECT_GT(found.registered[kOverlap], 1);
}

TEST(VerdictModel, WithoutAnswersOfBareGraphsTheirWeightsStay) {
  const VerdictModel found = fitVerdictModel(answersOfBands(0.95));
  EXPECT_EQ(found.bare.of, defaultVerdictModel().bare.of);
  EXPECT_NE(found.registered.of, defaultVerdictModel().registered.of);
}

/// What an answer lacks is as usual: it counts for as much as the median of right and wrong ones.
TEST(VerdictModel, WhatWasNotMeasuredIsAsUsual) {
  Statistics s;
  s.dense_margin = 6;
  s.dense = points(0.4, 0.05);
  const std::array<double, kTerms> terms = termsOf(s);
  EXPECT_EQ(terms[kOverlap], 0);
  EXPECT_EQ(terms[kFreeSpace], 0);
  EXPECT_EQ(terms[kWrongPlaceAboveNull], 0);
  s.dense.map_overlap = 0.6;
  s.dense.free_space_violation = 0.02;
  EXPECT_GT(termsOf(s)[kOverlap], 0);
  EXPECT_GT(termsOf(s)[kFreeSpace], 0);
}

TEST(VerdictModel, SurvivesItsFile) {
  const xview::test::TemporaryFolder folder;
  const std::string path = folder / "model.txt";
  std::ofstream(path) << toText(defaultVerdictModel());
  const VerdictModel read = readVerdictModel(path);
  for (std::size_t t = 0; t < kTerms; ++t)
    EXPECT_NEAR(read.registered.of[t], defaultVerdictModel().registered.of[t], 1e-2);
  EXPECT_NEAR(read.bare[kMargin], defaultVerdictModel().bare[kMargin], 1e-2);
  std::ofstream(path, std::ios::app) << "registered.hope 3\n";
  EXPECT_THROW(readVerdictModel(path), Error);
  std::ofstream(path) << "bare.margin much\n";
  EXPECT_THROW(readVerdictModel(path), Error);
}

TEST(VerdictModel, NeedsRightAndWrongAnswers) {
  std::vector<JudgedStatistics> answers = answersOf(defaultVerdictModel(), 100);
  for (JudgedStatistics& answer : answers) answer.right = true;
  EXPECT_THROW(fitVerdictModel(answers), Error);
  EXPECT_THROW(fitVerdictModel({}), Error);
}

}  // namespace
}  // namespace xview::verdict
