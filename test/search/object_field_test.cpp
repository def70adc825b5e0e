// SPDX-License-Identifier: BSD-3-Clause
#include "search/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/pose.h"
#include "base/random.h"
#include "search/raster.h"
#include "support/label_sets.h"

namespace xview::search {
namespace {

constexpr double kPi = 3.14159265358979323846;
enum Id : std::uint32_t { kPole = 1, kTree, kSign, kWall, kCar, kSky };

LabelSet someLabels() {
  return xview::test::labelSetOf("test", {{kPole, "pole", Role::object, Kind::pole},
                                          {kTree, "tree", Role::object, Kind::vegetation},
                                          {kSign, "sign", Role::object, Kind::sign},
                                          {kWall, "wall", Role::surface, Kind::building},
                                          {kCar, "car", Role::dynamic, Kind::vehicle},
                                          {kSky, "sky", Role::ignored, Kind::none}});
}

void addVertex(SemanticGraph& graph, std::uint32_t label, const Eigen::Vector3d& position) {
  Vertex v;
  v.label = label;
  v.position = position;
  graph.vertices.push_back(v);
  graph.neighbours.emplace_back();
}

/// Scattered objects and some straight walls in a square of the given side around `centre`.
SemanticGraph randomMap(double side, int objects, std::uint64_t seed,
                        const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  Random random(seed);
  SemanticGraph graph;
  const auto anywhere = [&] {
    return Eigen::Vector3d(centre + Eigen::Vector3d(random.uniform(-0.5, 0.5) * side,
                                                    random.uniform(-0.5, 0.5) * side,
                                                    random.uniform(-2, 2)));
  };
  constexpr std::uint32_t kObjects[] = {kPole, kTree, kSign, kCar};
  for (int i = 0; i < objects; ++i) addVertex(graph, kObjects[random.below(4)], anywhere());
  for (int i = 0; i < objects / 20; ++i) {
    const Eigen::Vector3d start = anywhere();
    const double angle = random.uniform(0, kPi);
    for (int k = 0; k < 8; ++k) {
      addVertex(graph, kWall,
                start + 3.0 * k * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    }
  }
  return graph;
}

struct Question {
  SemanticGraph query;
  Eigen::Isometry3d T_map_query;
};

/// What is within `radius` of a place, with noise, some of it missing, in a frame of its own.
Question ask(const SemanticGraph& map, const Eigen::Vector2d& place, double radius, double sigma,
             double missing, std::uint64_t seed) {
  Random random(seed);
  Question question;
  question.T_map_query =
      poseFromYaw({place.x() + random.uniform(-50, 50), place.y() + random.uniform(-50, 50), 12},
                  random.uniform(-kPi, kPi));
  for (const Vertex& v : map.vertices) {
    if ((v.position.head<2>() - place).norm() > radius || random.uniform() < missing) continue;
    const Eigen::Vector3d noise(sigma * random.normal(), sigma * random.normal(),
                                sigma * random.normal());
    addVertex(question.query, v.label, question.T_map_query.inverse() * (v.position + noise));
  }
  return question;
}

void expectPose(const Eigen::Isometry3d& found, const Question& question,
                const Eigen::Vector2d& place, double metres) {
  const Eigen::Vector3d p =
      question.T_map_query.inverse() * Eigen::Vector3d(place.x(), place.y(), 0);
  EXPECT_LE((found * p - question.T_map_query * p).norm(), metres);
  EXPECT_LE(rotationBetween(found, question.T_map_query), 0.03);
}

/// A field of a bare graph, asked for graphs.
class Index {
 public:
  Index(const SemanticGraph& map, const LabelSet& labels, const SearchOptions& options = {})
      : options_(options), field_(makeObjectField(map, labels, options)) {}

  SearchResult search(const SemanticGraph& query, const PlacePrior& prior = {},
                      const std::optional<Eigen::Vector3d>& focus = {}, int threads = 1) const {
    return search::search(*field_->prepare({nullptr, &query, focus}), {prior}, options_, threads);
  }
  PlaceHypothesis best(const SemanticGraph& query) const { return search(query).places.at(0); }
  PlaceHypothesis verify(const SemanticGraph& query, const Eigen::Isometry3d& T_map_query) const {
    return field_->prepare({nullptr, &query, {}})->verify(T_map_query);
  }
  double score(const SemanticGraph& query, const Eigen::Isometry3d& T_map_query) const {
    return field_->prepare({nullptr, &query, {}})->score(T_map_query);
  }
  std::size_t size() const { return field_->size(); }

 private:
  SearchOptions options_;
  std::unique_ptr<const Field> field_;
};

/// Score of the best other place; 0 if there is none.
double bestWrong(const SearchResult& result) {
  return result.places.size() > 1 ? result.places[1].score() : 0;
}

void expectSame(const SearchResult& a, const SearchResult& b) {
  ASSERT_EQ(a.places.size(), b.places.size());
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    EXPECT_TRUE(a.places[i].T_map_query.matrix() == b.places[i].T_map_query.matrix());
    EXPECT_EQ(a.places[i].score(), b.places[i].score());
    EXPECT_EQ(a.places[i].pairs.size(), b.places[i].pairs.size());
  }
}

TEST(ObjectField, FindsNoisyQueriesInAMapOfAnySize) {
  for (const double side : {300.0, 900.0, 2500.0}) {
    const SemanticGraph map = randomMap(side, static_cast<int>(side * side / 400), 1);
    const Index index(map, someLabels());
    for (std::uint64_t i = 0; i < 5; ++i) {
      SCOPED_TRACE(testing::Message() << side << " m, query " << i);
      const Eigen::Vector2d place(side * (0.15 * static_cast<double>(i) - 0.3), side * 0.1);
      const Question question = ask(map, place, 45, 0.4, 0.25, 100 + i);
      const SearchResult result = index.search(question.query);
      ASSERT_FALSE(result.places.empty());
      expectPose(result.places[0].T_map_query, question, place, 0.6);
      EXPECT_GT(result.places[0].score(), bestWrong(result) + 10);
    }
  }
}

/// The fine raster of a large map, which is written where it is looked at.
TEST(ObjectField, ASquareOfTheFineRasterIsCompleteOnceItIsAskedFor) {
  const SemanticGraph map = randomMap(400, 2000, 8);
  Observation seen;
  seen.graph = &map;
  const auto field = makeObjectField(map, someLabels(), {}),
             whole = makeObjectField(map, someLabels(), {});
  const auto query = field->prepare(seen), query_of_whole = whole->prepare(seen);
  const RasterLevels levels = query->rasterLevels(), all = query_of_whole->rasterLevels();
  ASSERT_TRUE(levels.fine.write_first);
  all.fine.write_first(-200, -200, 400);
  EXPECT_TRUE(levels.fine.raster.tiles().empty()) << "nothing is written before";
  int written = 0;
  for (const std::int32_t x : {-32, 0, 32}) {  // on the borders of blocks of 32 m
    constexpr std::int32_t kSide = 10;
    const auto lock = levels.fine.write_first(x, x, kSide);
    for (std::int32_t cy = x; cy < x + kSide; ++cy) {
      for (std::int32_t cx = x; cx < x + kSide; ++cx) {
        for (std::size_t c = 0; c < all.fine.raster.channels(); ++c) {
          ASSERT_EQ(levels.fine.raster.at(c, cx, cy), all.fine.raster.at(c, cx, cy));
          written += levels.fine.raster.at(c, cx, cy) > 0;
        }
      }
    }
  }
  EXPECT_GT(written, 100);
  EXPECT_LT(levels.fine.raster.tiles().size(), all.fine.raster.tiles().size());
}

TEST(ObjectField, PoseIsEquivariantToMotionOfTheQuery) {
  const SemanticGraph map = randomMap(600, 900, 2);
  const Index index(map, someLabels());
  Question question = ask(map, {40, -60}, 50, 0.3, 0.2, 3);
  const Eigen::Isometry3d before = index.best(question.query).T_map_query;
  const Eigen::Isometry3d motion = poseFromYaw({300, -200, 7}, 1.1);
  for (Vertex& v : question.query.vertices) v.position = motion * v.position;
  const Eigen::Isometry3d after = index.best(question.query).T_map_query * motion;
  const Eigen::Vector3d p = question.T_map_query.inverse() * Eigen::Vector3d(40, -60, 0);
  EXPECT_LE((after * p - before * p).norm(), 0.05);
  EXPECT_LE(rotationBetween(before, after), 2e-3);
}

TEST(ObjectField, LargeMapCoordinatesLoseNothing) {
  const Eigen::Vector3d utm(372000.25, 4840000.5, 210);
  const SemanticGraph map = randomMap(400, 400, 4, utm);
  const Index index(map, someLabels());
  const Eigen::Vector2d place = utm.head<2>() + Eigen::Vector2d(30, 20);
  const Question question = ask(map, place, 50, 0, 0, 5);
  const SearchResult result = index.search(question.query);
  ASSERT_FALSE(result.places.empty());
  expectPose(result.places[0].T_map_query, question, place, 0.1);
}

TEST(ObjectField, InliersAreTheVerticesThatTheQueryCameFrom) {
  const SemanticGraph map = randomMap(400, 400, 6);
  const Index index(map, someLabels());
  const Question question = ask(map, {0, 0}, 50, 0.1, 0, 7);
  const PlaceHypothesis best = index.best(question.query);
  std::size_t right = 0;
  for (const Correspondence& c : best.pairs) {
    const Vertex &q = question.query.vertices.at(c.query), &m = map.vertices.at(c.map);
    right += q.label == m.label && (question.T_map_query * q.position - m.position).norm() < 1;
    EXPECT_GE(c.similarity, 0.5f);
    EXPECT_LE(c.similarity, 1.0f);
  }
  EXPECT_GE(right, question.query.size() * 9 / 10);
  std::vector<std::uint32_t> used;
  for (const Correspondence& c : best.pairs) used.push_back(c.map);
  std::sort(used.begin(), used.end());
  EXPECT_EQ(std::adjacent_find(used.begin(), used.end()), used.end())
      << "a map vertex serves two query vertices";
}

TEST(ObjectField, IsTheSameForAnyNumberOfThreads) {
  const SemanticGraph map = randomMap(1000, 2500, 8);
  const Index index(map, someLabels());
  const Question question = ask(map, {100, 100}, 50, 0.5, 0.3, 9);
  const SearchResult one = index.search(question.query);
  for (const int threads : {0, 2, 5})
    expectSame(index.search(question.query, {}, {}, threads), one);
}

TEST(ObjectField, TellsAllOfAsManyPlacesAsAskedFor) {
  const SemanticGraph map = randomMap(400, 500, 40);
  const Question question = ask(map, {0, 0}, 50, 0.3, 0.2, 41);
  const SearchResult many = Index(map, someLabels()).search(question.query);
  ASSERT_GT(many.places.size(), 3u);
  for (const int wanted : {0, 1, 3}) {
    SearchOptions options;
    options.hypotheses = wanted;
    const SearchResult few = Index(map, someLabels(), options).search(question.query);
    const auto described = std::count_if(few.places.begin(), few.places.end(),
                                         [](const PlaceHypothesis& h) { return h.expected != 0; });
    EXPECT_EQ(described, std::max(1, wanted));
    EXPECT_EQ(few.places[0].score(), many.places[0].score());
    EXPECT_EQ(few.places[1].score(), many.places[1].score());
  }
}

TEST(ObjectField, ExactVerticesGiveAnExactPose) {
  const SemanticGraph map = randomMap(400, 1200, 42);  // so dense that neighbours are in the way
  const Index index(map, someLabels());
  const Question question = ask(map, {0, 0}, 50, 0, 0.1, 43);
  expectPose(index.best(question.query).T_map_query, question, {0, 0}, 0.02);
}

TEST(ObjectField, OrderOfTheQueryDoesNotMatter) {
  const SemanticGraph map = randomMap(400, 1200, 44);
  const Index index(map, someLabels());
  Question question = ask(map, {0, 0}, 50, 0.6, 0.3, 45);
  const PlaceHypothesis forward = index.best(question.query);
  std::reverse(question.query.vertices.begin(), question.query.vertices.end());
  const PlaceHypothesis backward = index.best(question.query);
  EXPECT_NEAR(forward.score(), backward.score(), 0.5);
  const Eigen::Vector3d p = question.T_map_query.inverse() * Eigen::Vector3d(0, 0, 0);
  EXPECT_LE((forward.T_map_query * p - backward.T_map_query * p).norm(), 0.05);
}

TEST(ObjectField, OneClassIsEnough) {
  Random random(10);
  SemanticGraph map;
  for (int i = 0; i < 1000; ++i)
    addVertex(map, 7, {random.uniform(-400, 400), random.uniform(-400, 400), 0});
  const Index index(map, LabelSet("unknown"));
  const Question question = ask(map, {100, -50}, 60, 0.4, 0.2, 11);
  const SearchResult result = index.search(question.query);
  ASSERT_FALSE(result.places.empty());
  expectPose(result.places[0].T_map_query, question, {100, -50}, 0.6);
}

TEST(ObjectField, OtherPlacesScoreLowAgainstWhatIsExpected) {
  const SemanticGraph map = randomMap(800, 1600, 12), elsewhere = randomMap(800, 1600, 13);
  const Index index(map, someLabels());
  for (std::uint64_t i = 0; i < 4; ++i) {
    const PlaceHypothesis right = index.best(ask(map, {0, 0}, 50, 0.3, 0.2, 20 + i).query);
    const PlaceHypothesis wrong = index.best(ask(elsewhere, {0, 0}, 50, 0.3, 0.2, 30 + i).query);
    EXPECT_GT(right.score() / right.expected, 0.7);
    EXPECT_LT(wrong.score() / wrong.expected, 0.4);
  }
}

/// Samples of curved walls and few objects, each wall sampled anew at every visit.
SemanticGraph denseVisit(std::uint64_t town_seed, std::uint64_t visit_seed, double side) {
  Random town(town_seed), visit(visit_seed);
  SemanticGraph graph;
  for (int wall = 0; wall < static_cast<int>(side * side / 400); ++wall) {
    Eigen::Vector3d p(town.uniform(-0.5, 0.5) * side, town.uniform(-0.5, 0.5) * side, 0);
    double angle = town.uniform(-kPi, kPi);
    const double length = town.uniform(10, 30), bend = town.uniform(-0.05, 0.05);
    double next = visit.uniform(0, 2.8);
    for (double at = 0; at < length; at += 0.4) {
      p += 0.4 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
      angle += 0.4 * bend;
      if (at < next) continue;
      next += 2.8;
      if (visit.uniform() < 0.2) continue;
      addVertex(graph, kWall,
                p + 0.4 * Eigen::Vector3d(visit.normal(), visit.normal(), 0.2 * visit.normal()));
    }
  }
  for (int pole = 0; pole < static_cast<int>(side * side / 1500); ++pole) {
    const Eigen::Vector3d p(town.uniform(-0.5, 0.5) * side, town.uniform(-0.5, 0.5) * side, 0);
    if (visit.uniform() < 0.8) addVertex(graph, kPole, p);
  }
  return graph;
}

TEST(ObjectField, ATruePlaceOfSurfacesSampledAnewIsExpectedToBeatWrongOnes) {
  const Index index(denseVisit(1, 10, 500), someLabels());
  for (std::uint64_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d place(60.0 * static_cast<double>(i) - 90, 40);
    const Question question = ask(denseVisit(1, 20 + i, 500), place, 45, 0, 0, 30 + i);
    const SearchResult result = index.search(question.query);
    const PlaceHypothesis& right = result.places.at(0);
    expectPose(right.T_map_query, question, place, 1);
    EXPECT_GT(right.score() / right.expected, 0.7);
    EXPECT_GT(right.expected, bestWrong(result));
  }
}

/// A place, and the same 500 m to the east on a hill.
SemanticGraph twice(const SemanticGraph& block, double slope = 0) {
  SemanticGraph both = block;
  for (const Vertex& v : block.vertices)
    addVertex(both, v.label, v.position + Eigen::Vector3d(500, 0, slope * v.position.x()));
  return both;
}

TEST(ObjectField, TwoEqualPlacesLeaveNoMargin) {
  const SemanticGraph block = randomMap(200, 120, 14);
  const Index index(twice(block), someLabels());
  const SearchResult result = index.search(ask(block, {0, 0}, 50, 0.2, 0.2, 15).query);
  ASSERT_GE(result.places.size(), 2u);
  EXPECT_NEAR(result.places[0].score(), bestWrong(result), 2);
  EXPECT_NEAR(std::abs(result.places[0].centre.x - result.places[1].centre.x), 500, 1);
}

TEST(ObjectField, HillsTellEqualPlacesApart) {
  const SemanticGraph block = randomMap(200, 120, 14);
  const auto marginWith = [&](double slope) {
    const Index index(twice(block, slope), someLabels());
    const SearchResult result = index.search(ask(block, {0, 0}, 50, 0.2, 0.2, 15).query);
    return result.places.at(0).score() - bestWrong(result);
  };
  EXPECT_LT(marginWith(0), 1);
  EXPECT_GT(marginWith(0.08), 3);
}

TEST(ObjectField, PosesOfOthersAreRefinedAndScoredAlike) {
  const SemanticGraph map = randomMap(500, 700, 16);
  const Index index(map, someLabels());
  const Question question = ask(map, {20, 30}, 50, 0.3, 0.2, 17);
  const PlaceHypothesis found = index.best(question.query);
  const Eigen::Isometry3d near_by = poseFromYaw({1.0, -0.8, 0}, 0.01) * question.T_map_query;
  const Eigen::Isometry3d far_off = poseFromYaw({60, 0, 0}, 0) * question.T_map_query;
  const PlaceHypothesis climbed = index.verify(question.query, near_by);
  EXPECT_NEAR(climbed.score(), found.score(), 1.5);
  expectPose(climbed.T_map_query, question, {20, 30}, 0.6);
  EXPECT_LT(index.verify(question.query, far_off).score(), 0.5 * found.score());
}

TEST(ObjectField, ThePriorIsObeyed) {
  const SemanticGraph block = randomMap(200, 120, 18);
  const Index index(twice(block), someLabels());
  const Question question = ask(block, {0, 0}, 50, 0.2, 0.2, 19);
  for (const double shift : {0.0, 500.0}) {
    const Eigen::Vector3d focus = question.T_map_query.inverse() * Eigen::Vector3d(0, 0, 0);
    PlacePrior prior;
    prior.near = PlacePrior::Circle{shift, 0, 20};
    const SearchResult result = index.search(question.query, prior, focus);
    ASSERT_FALSE(result.places.empty());
    EXPECT_NEAR((result.places[0].T_map_query * focus).x(), shift, 1);
    prior.heading = PlacePrior::Heading{yawOf(question.T_map_query.linear()) + kPi, 0.5};
    for (const PlaceHypothesis& h : index.search(question.query, prior, focus).places) {
      EXPECT_LE(std::abs(angleDifference(h.centre.yaw, prior.heading->yaw)), 0.51);
    }
  }
}

TEST(ObjectField, ATiltedQueryIsLevelled) {
  const SemanticGraph map = randomMap(400, 500, 24);
  const Index index(map, someLabels());
  Question question = ask(map, {0, 0}, 50, 0.1, 0.1, 25);
  const Eigen::Isometry3d tilt(Eigen::AngleAxisd(0.03, Eigen::Vector3d(0.6, 0.8, 0)));
  for (Vertex& v : question.query.vertices) v.position = tilt * v.position;
  question.T_map_query = question.T_map_query * tilt.inverse();
  const PlaceHypothesis best = index.best(question.query);
  expectPose(best.T_map_query, question, {0, 0}, 0.5);
  EXPECT_LE(rotationBetween(best.T_map_query, question.T_map_query), 0.01);
}

TEST(ObjectField, AFlatQueryIsNotTilted) {
  const SemanticGraph map = randomMap(400, 500, 26);
  const Index index(map, someLabels());
  Question question = ask(map, {0, 0}, 50, 0.1, 0.1, 27);
  for (Vertex& v : question.query.vertices) v.position.z() = 0;
  const PlaceHypothesis best = index.best(question.query);
  EXPECT_NEAR(best.T_map_query.linear()(2, 2), 1, 1e-12);
}

TEST(ObjectField, OutliersNeverRaiseTheScore) {
  const SemanticGraph map = randomMap(400, 500, 28);
  const Index index(map, someLabels());
  Question question = ask(map, {0, 0}, 50, 0.2, 0.1, 29);
  double last = index.verify(question.query, question.T_map_query).score();
  Random random(30);
  const auto isFree = [&](const Eigen::Vector3d& p) {
    return std::none_of(map.vertices.begin(), map.vertices.end(), [&](const Vertex& v) {
      return v.label == kPole && (v.position - p).head<2>().norm() < 5;
    });
  };
  for (int added = 0; added < 10;) {
    const Eigen::Vector3d p(random.uniform(-40, 40), random.uniform(-40, 40), 0);
    if (!isFree(p)) continue;
    addVertex(question.query, kPole, question.T_map_query.inverse() * p);
    ++added;
    const double score = index.verify(question.query, question.T_map_query).score();
    EXPECT_LT(score, last);
    last = score;
  }
}

TEST(ObjectField, AMirroredPlaceIsNotBelieved) {
  const SemanticGraph map = randomMap(500, 700, 31);
  const Index index(map, someLabels());
  Question question = ask(map, {0, 0}, 50, 0.1, 0, 32);
  const double right = index.best(question.query).score();
  for (Vertex& v : question.query.vertices) v.position.x() *= -1;
  const SearchResult mirrored = index.search(question.query);
  ASSERT_FALSE(mirrored.places.empty());
  EXPECT_LT(mirrored.places[0].score(), 0.3 * right);
}

TEST(ObjectField, AQueryOfManyKilometresIsFoundAsAWhole) {
  SemanticGraph map = randomMap(9000, 3000, 40);
  for (const Eigen::Vector3d& village :
       {Eigen::Vector3d(3000, 3500, 0), Eigen::Vector3d(-3200, 1000, 0)}) {
    for (const Vertex& v : randomMap(400, 200, 41, village).vertices)
      addVertex(map, v.label, v.position);
  }
  const Index index(map, someLabels());
  const Question question = ask(map, {0, 0}, 7000, 0.3, 0.3, 42);
  const SearchResult result = index.search(question.query);
  ASSERT_FALSE(result.places.empty());
  // Samples of walls that noise has brought within 2.5 m count once.
  EXPECT_GT(result.vertices, 0.97 * static_cast<double>(question.query.size()));
  const PlaceHypothesis& best = result.places[0];
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(4000, 4000), Eigen::Vector2d(-4000, 1000)}) {
    const Eigen::Vector3d p =
        question.T_map_query.inverse() * Eigen::Vector3d(corner.x(), corner.y(), 0);
    EXPECT_LE((best.T_map_query * p - question.T_map_query * p).head<2>().norm(), 0.5);
  }
  EXPECT_GT(best.pairs.size(), question.query.size() * 9 / 10);
  EXPECT_GT(best.score(), 0.5 * best.expected);
}

TEST(ObjectField, AQueryOfManyKilometresFromElsewhereScoresFarBelowATrueOne) {
  const Index index(randomMap(6000, 2500, 43), someLabels());
  const SearchResult result = index.search(randomMap(6000, 2500, 44));
  for (const PlaceHypothesis& h : result.places) EXPECT_LT(h.score(), 0.1 * h.expected);
}

TEST(ObjectField, AStrayVertexFarAwayDoesNotHideThePlace) {
  const SemanticGraph map = randomMap(500, 700, 45);
  const Index index(map, someLabels());
  Question question = ask(map, {20, 30}, 50, 0.3, 0.2, 46);
  addVertex(question.query, kPole, {20000, -5000, 0});
  const SearchResult result = index.search(question.query);
  ASSERT_FALSE(result.places.empty());
  expectPose(result.places[0].T_map_query, question, {20, 30}, 0.6);
}

TEST(ObjectField, DegenerateInputsGiveNoHypothesis) {
  const SemanticGraph map = randomMap(200, 100, 20);
  const LabelSet labels = someLabels();
  const SemanticGraph empty;
  SemanticGraph foreign, broken, sky;
  addVertex(foreign, 99, {0, 0, 0});
  addVertex(broken, kPole, {std::numeric_limits<double>::quiet_NaN(), 0, 0});
  addVertex(sky, kSky, {0, 0, 0});
  const Index index(map, labels), nothing(empty, labels);
  EXPECT_EQ(nothing.size(), 0u);
  EXPECT_TRUE(nothing.search(map).places.empty());
  EXPECT_TRUE(index.search(empty).places.empty());
  EXPECT_TRUE(index.search(foreign).places.empty());
  EXPECT_TRUE(index.search(broken).places.empty());
  EXPECT_TRUE(index.search(sky).places.empty());
  EXPECT_EQ(index.verify(empty, Eigen::Isometry3d::Identity()).score(), 0);
}

TEST(ObjectField, IgnoredAndBrokenVerticesOfTheMapAreLeftOut) {
  SemanticGraph map = randomMap(200, 100, 21);
  const std::size_t size = map.size();
  addVertex(map, kSky, {0, 0, 0});
  addVertex(map, kPole, {0, std::numeric_limits<double>::infinity(), 0});
  EXPECT_EQ(Index(map, someLabels()).size(), size);
}

TEST(ObjectField, OneVertexAndLinesAreNoTrouble) {
  SemanticGraph single, line;
  addVertex(single, kPole, {5, 5, 0});
  for (int i = 0; i < 30; ++i) addVertex(line, kWall, {3.0 * i, 0, 0});
  for (const SemanticGraph& map : {single, line}) {
    const SearchResult result = Index(map, someLabels()).search(map);
    for (const PlaceHypothesis& h : result.places) {
      EXPECT_TRUE(h.T_map_query.matrix().allFinite());
      EXPECT_TRUE(std::isfinite(h.score()));
    }
  }
}

TEST(ObjectField, UnknownAreaSpeaksNeitherForNorAgainst) {
  const SemanticGraph map = randomMap(300, 250, 22);
  const Index index(map, someLabels());
  const Question question = ask(map, {0, 0}, 50, 0.2, 0.2, 23);
  const Eigen::Isometry3d T_query_map = question.T_map_query.inverse();
  const auto scoreWithTenMore = [&](double x) {
    SemanticGraph query = question.query;
    for (int i = 0; i < 10; ++i)
      addVertex(query, kPole, T_query_map * Eigen::Vector3d(x, 10.0 * i - 45, 0));
    return index.score(query, question.T_map_query);
  };
  const double alone = index.score(question.query, question.T_map_query);
  // Where the centre of a query lies has a little to do with its score.
  EXPECT_NEAR(scoreWithTenMore(300), alone, 0.5);
  EXPECT_LT(scoreWithTenMore(47), alone - 2);
}

SemanticGraph poles() {
  SemanticGraph graph;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) addVertex(graph, kPole, {30.0 * i, 30.0 * j, 0});
  }
  return graph;
}

/// Score of the true pose of a query of all poles and of a sample of a wall that is not in the map.
double scoreWithWallAt(double x, double y) {
  SemanticGraph map = poles();
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) addVertex(map, kWall, {30.0 * i + 10 + 3 * k, 15, 0});
  }
  SemanticGraph query = poles();
  addVertex(query, kWall, {x, y, 0});
  return Index(map, someLabels()).verify(query, Eigen::Isometry3d::Identity()).score();
}

TEST(ObjectField, AWholeWallThatIsMissingSpeaksMoreAgainstAPoseThanAGapInWhatIsThere) {
  const double on_a_wall = scoreWithWallAt(43, 15), beside_a_pole = scoreWithWallAt(34, 62),
               on_its_own = scoreWithWallAt(45, 75);
  EXPECT_LT(beside_a_pole, on_a_wall);
  EXPECT_LT(on_its_own, beside_a_pole);
}

}  // namespace
}  // namespace xview::search
