// SPDX-License-Identifier: BSD-3-Clause
#include "place/measure_size.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <utility>

#include "base/random.h"
#include "localizer/simulated_drive.h"
#include "search/likelihoods.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"
#include "xview/map/semantic_map.h"

namespace xview {
namespace {

using test::simulatedDrive;

/// A drive through a model of the town.
class ModelDrive : public ForwardingSource {
 public:
  ModelDrive(const FrameSource& drive, double size) : ForwardingSource(drive), size_(size) {}
  Eigen::Isometry3d pose(std::size_t i) const override {
    Eigen::Isometry3d T = ForwardingSource::pose(i);
    scaleLengths(size_, T);
    return T;
  }
  Frame read(std::size_t i) const override {
    Frame frame = ForwardingSource::read(i);
    scaleLengths(size_, frame);
    return frame;
  }

 private:
  double size_;
};

Options ofSize(const std::string& size) {
  Options options;
  options.size = size;
  return options;
}

/// A window of the drive back through a model of the town, in the model's map.
Localization answerInModel(double size, const map::SemanticMap& map,
                           const std::string& likelihoods = search::kRooms) {
  const ModelDrive rear(*simulatedDrive().sessions.at("rear"), size);
  Options options = ofSize(sizeText(map.size));
  options.places.likelihoods = likelihoods;  // else those of the size
  const std::vector<PreprocessedFrame> frames = preprocessRecording(rear, options);
  const Query query = makeQuery(frames.data() + 5, frames.data() + 45, map.labels, options);
  return Localizer(map, options).localize(query);
}

map::SemanticMap mapOfModel(double size) {
  const ModelDrive forward(*simulatedDrive().sessions.at("forward"), size);
  return buildMap({&forward}, ofSize(sizeText(size)));
}

TEST(MeasuredSizes, AModelOfATownGivesTheAnswerOfTheTownInItsOwnLengths) {
  const Localization town = answerInModel(kTownScale, simulatedDrive().map);
  ASSERT_TRUE(town.accepted()) << town.reason;
  const map::SemanticMap room_map = mapOfModel(kRoomScale), desk_map = mapOfModel(kDeskScale);
  const Localization room = answerInModel(kRoomScale, room_map),
                     desk = answerInModel(kDeskScale, desk_map);
  for (const auto& [size, model] : {std::pair(kRoomScale, &room), {kDeskScale, &desk}}) {
    EXPECT_EQ(model->hypotheses[0].score, town.hypotheses[0].score);
    EXPECT_EQ(model->T_map_sensor.translation(), size * town.T_map_sensor.translation());
    EXPECT_EQ(model->covariance(0, 0), size * size * town.covariance(0, 0));
    EXPECT_EQ(model->covariance(5, 5), town.covariance(5, 5));
    EXPECT_EQ(model->confidence, room.confidence) << "small places are judged alike";
    EXPECT_EQ(model->reason, room.reason);
  }
  EXPECT_EQ(room_map.graph.size(), simulatedDrive().map.graph.size());
  EXPECT_EQ(desk_map.graph.size(), simulatedDrive().map.graph.size());
}

/// The same counts under another name.
TEST(MeasuredSizes, AreToldByThePlaceAndNotByTheNameOfItsLikelihoods) {
  const map::SemanticMap map = mapOfModel(kRoomScale);
  const std::string own = testing::TempDir() + "/own_likelihoods.txt";
  std::ofstream(own) << toText(search::readLikelihoods(search::kRooms));
  const Localization built_in = answerInModel(kRoomScale, map),
                     learned = answerInModel(kRoomScale, map, own);
  std::remove(own.c_str());
  EXPECT_EQ(learned.hypotheses[0].score, built_in.hypotheses[0].score);
  EXPECT_FALSE(learned.statistics.dense.map_overlap) << "what rooms show is hidden by furniture";
  EXPECT_TRUE(learned.statistics.dense.indoors);
  EXPECT_EQ(learned.confidence, built_in.confidence);
  EXPECT_EQ(learned.reason, built_in.reason);
}

TEST(MeasuredSizes, AMapKeepsItsSizeInItsFile) {
  const map::SemanticMap map = mapOfModel(kDeskScale);
  const std::string path = testing::TempDir() + "/model.xvm";
  map::saveMap(path, map);
  const map::SemanticMap read = map::unpacked(map::openMap(path));
  std::remove(path.c_str());
  EXPECT_EQ(read.size, kDeskScale);
  EXPECT_EQ(map.bev.cell_m, read.bev.cell_m);
  EXPECT_EQ(map.bev.sampleCount(), read.bev.sampleCount());
  EXPECT_TRUE(answerInModel(kDeskScale, read).accepted());
}

TEST(MeasuredSizes, RecordingsAndGraphsTellTheirSize) {
  const FrameSource& forward = *simulatedDrive().sessions.at("forward");
  for (const auto& [factor, size] :
       {std::pair(1., kTownScale), {0.25, kRoomScale}, {1. / 32, kDeskScale}}) {
    const ModelDrive drive(forward, factor);
    EXPECT_EQ(measureSize(std::vector<const FrameSource*>{&drive}).size, size)
        << measureSize(std::vector<const FrameSource*>{&drive}).reason;
    SemanticGraph graph = simulatedDrive().map.graph;
    scaleLengths(factor, graph);
    EXPECT_EQ(measureSize(graph).size, size) << measureSize(graph).reason;
  }
  EXPECT_EQ(measureSize(SemanticGraph()).size, kTownScale);
}

/// As it happens to a scan: a cloud of points whose density falls with the square of the range.
class OneCloud : public ForwardingSource {
 public:
  OneCloud(const std::function<Eigen::Vector3d(Random&, int)>& point)
      : ForwardingSource(*simulatedDrive().sessions.at("forward")) {
    cloud_.sensor = Sensor::cloud;
    Random random(1);
    for (int i = 0; i < 50000; ++i) {
      const Eigen::Vector3f p = point(random, i).cast<float>();
      cloud_.cloud.points.emplace_back(p.x(), p.y(), p.z());
    }
  }
  std::size_t size() const override { return 1; }
  Sensor sensor() const override { return Sensor::cloud; }
  Frame read(std::size_t) const override { return cloud_; }

 private:
  Frame cloud_;
};

/// Check fix for: frames were given classes only to measure how far they see.
TEST(MeasuredSizes, AreToldWithoutClasses) {
  class Unreadable final : public RelabelledRecording {
   public:
    explicit Unreadable(const FrameSource& source)
        : RelabelledRecording(std::make_unique<ModelDrive>(source, 1), source.labels()) {}
    Frame read(std::size_t) const override { throw Error(name(), "asked for classes"); }
  };
  const FrameSource& drive = *simulatedDrive().sessions.at("rear");
  const Unreadable labelled(drive);
  EXPECT_EQ(measureSize({&labelled}).reason, measureSize({&drive}).reason);
}

TEST(MeasuredSizes, PlacesOfACloudCountAndNotItsPoints) {
  const auto scanned = [](double height_m, double width_m) {
    return OneCloud([=](Random& random, int i) -> Eigen::Vector3d {
      const double range = 2 * std::pow(width_m / 2, random.uniform());
      const double angle = random.uniform(0, 2 * M_PI);
      return {range * std::cos(angle), range * std::sin(angle),
              i % 3 == 0 ? random.uniform(0, height_m) : 0};
    });
  };
  const OneCloud street = scanned(5, 60), hall = scanned(2.5, 10);
  EXPECT_EQ(measureSize({&street}).size, kTownScale) << measureSize({&street}).reason;
  EXPECT_EQ(measureSize({&hall}).size, kRoomScale) << measureSize({&hall}).reason;
}

/// However far rooms go on side by side, their size is that of one.
TEST(MeasuredSizes, AFloorOfRoomsIsNoTown) {
  const OneCloud floor([](Random& random, int i) -> Eigen::Vector3d {
    const double x = random.uniform(0, 80), y = random.uniform(0, 70);
    if (i % 10 > 0) return {x, y, 3.0 * (i % 2)};
    return {x, 5 * std::floor(y / 5), random.uniform(0, 3)};
  });
  EXPECT_EQ(measureSize({&floor}).size, kRoomScale) << measureSize({&floor}).reason;
  const OneCloud noisy_field([](Random& random, int) -> Eigen::Vector3d {
    return {random.uniform(0, 200), random.uniform(0, 200), 0.5 * random.normal()};
  });
  EXPECT_EQ(measureSize({&noisy_field}).size, kTownScale) << measureSize({&noisy_field}).reason;
}

TEST(MeasuredSizes, AQueryOfAnotherSizeThanItsMapIsRefusedWithBothSizes) {
  const Query query = simulatedDrive().query("rear", 5, 20);
  const std::string said =
      test::messageOf<Error>([&] { Localizer(mapOfModel(kRoomScale), {}).localize(query); });
  EXPECT_NE(said.find("size town"), std::string::npos) << said;
  EXPECT_NE(said.find("--size room"), std::string::npos) << said;
}

}  // namespace
}  // namespace xview
