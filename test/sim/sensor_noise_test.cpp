// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensor_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/recordings.h"

namespace xview {
namespace {

const std::vector<Frame>& cleanFrames() {
  static const std::vector<Frame> frames = [] {
    SimulationOptions options;
    options.route_length_m = 120;
    options.frame_spacing_m = 12;
    options.sessions.rear = options.sessions.aerial = false;
    const auto sessions = makeSessions(options);
    std::vector<Frame> result;
    for (std::size_t i = 0; i < sessions[0]->size(); ++i) result.push_back(sessions[0]->read(i));
    return result;
  }();
  return frames;
}

double accuracy(const Frame& truth, const Frame& noisy) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < truth.label.pixels.size(); ++i) {
    right += truth.label.pixels[i] == noisy.label.pixels[i];
  }
  return static_cast<double>(right) / static_cast<double>(truth.label.pixels.size());
}

TEST(LabelNoise, KeepsItsAccuracyOnEveryFrame) {
  for (const double wanted : {0.6, 0.83, 0.95, 0.99}) {
    LabelNoise noise;
    noise.accuracy = wanted;
    noise.variation = 0;
    for (const Frame& frame : cleanFrames()) {
      EXPECT_NEAR(accuracy(frame, withLabelNoise(frame, noise, 1)), wanted, 0.005);
    }
  }
}

TEST(LabelNoise, VariesBetweenFramesAroundItsMean) {
  double sum = 0, lowest = 1, highest = 0;
  for (const Frame& frame : cleanFrames()) {
    const double a = accuracy(frame, withLabelNoise(frame, LabelNoise(), 1));
    sum += a;
    lowest = std::min(lowest, a);
    highest = std::max(highest, a);
  }
  EXPECT_NEAR(sum / static_cast<double>(cleanFrames().size()), 0.83, 0.025);
  EXPECT_GT(highest - lowest, 0.01);
}

TEST(LabelNoise, PerfectAccuracyChangesNothing) {
  LabelNoise noise;
  noise.accuracy = 1;
  const Frame& frame = cleanFrames()[0];
  EXPECT_EQ(withLabelNoise(frame, noise, 1).label.pixels, frame.label.pixels);
}

TEST(LabelNoise, ComesInBlobsAndNotAsSpeckles) {
  const Frame& truth = cleanFrames()[2];
  const Frame noisy = withLabelNoise(truth, LabelNoise(), 1);
  const auto wrong = [&](int x, int y) { return truth.label.at(x, y) != noisy.label.at(x, y); };
  int pairs = 0, both = 0;
  for (int y = 0; y < truth.label.height; ++y) {
    for (int x = 0; x + 1 < truth.label.width; ++x) {
      pairs += wrong(x, y);
      both += wrong(x, y) && wrong(x + 1, y);
    }
  }
  EXPECT_GT(both, 0.7 * pairs);  // white noise would give 0.17
}

TEST(LabelNoise, ConfusesPlausiblyAndDropsTheInstance) {
  int road_as_sidewalk = 0, road_as_car = 0;
  for (const Frame& truth : cleanFrames()) {
    const Frame noisy = withLabelNoise(truth, LabelNoise(), 1);
    for (std::size_t i = 0; i < truth.label.pixels.size(); ++i) {
      const auto from = truth.label.pixels[i], to = noisy.label.pixels[i];
      ASSERT_EQ(noisy.instance.pixels[i], from == to ? truth.instance.pixels[i] : 0);
      road_as_sidewalk += from == town_class::kRoad && to == town_class::kSidewalk;
      road_as_car += from == town_class::kRoad && to == town_class::kCar;
    }
  }
  EXPECT_GT(road_as_sidewalk, 10 * road_as_car);
}

TEST(LabelNoise, ThinThingsAreMissedMoreOften) {
  double thin = 0, thin_right = 0, road = 0, road_right = 0;
  for (const Frame& truth : cleanFrames()) {
    const Frame noisy = withLabelNoise(truth, LabelNoise(), 1);
    for (std::size_t i = 0; i < truth.label.pixels.size(); ++i) {
      const bool right = truth.label.pixels[i] == noisy.label.pixels[i];
      if (truth.label.pixels[i] == town_class::kPole) thin += 1, thin_right += right;
      if (truth.label.pixels[i] == town_class::kRoad) road += 1, road_right += right;
    }
  }
  ASSERT_GT(thin, 100);
  EXPECT_LT(thin_right / thin, road_right / road);
  EXPECT_GT(thin_right / thin, 0.05);
}

TEST(LabelNoise, SameSeedSameErrorsOtherSeedOthers) {
  const Frame& frame = cleanFrames()[1];
  const Frame a = withLabelNoise(frame, LabelNoise(), 1);
  EXPECT_EQ(a.label.pixels, withLabelNoise(frame, LabelNoise(), 1).label.pixels);
  EXPECT_NE(a.label.pixels, withLabelNoise(frame, LabelNoise(), 2).label.pixels);
}

TEST(LabelNoise, ErrorsThatStickReturnInTheNextFrameOfTheSameView) {
  const auto agreement = [](double persistence) {
    LabelNoise noise;
    noise.variation = 0;
    noise.persistence = persistence;
    Frame frame = cleanFrames()[1];
    const Frame truth = frame;
    const Frame a = withLabelNoise(frame, noise, 1);
    frame.number += 1;  // the next image from the same place
    const Frame b = withLabelNoise(frame, noise, 1);
    int both = 0, either = 0;
    for (std::size_t i = 0; i < truth.label.pixels.size(); ++i) {
      const bool wrong_a = a.label.pixels[i] != truth.label.pixels[i];
      const bool wrong_b = b.label.pixels[i] != truth.label.pixels[i];
      both += wrong_a && wrong_b;
      either += wrong_a || wrong_b;
    }
    return static_cast<double>(both) / either;
  };
  EXPECT_GT(agreement(1), agreement(0) + 0.2);
}

TEST(DepthNoise, GrowsWithTheSquareOfDepth) {
  const auto sigma = [](float z) {
    Frame frame;
    frame.camera = pinholeCamera(100, 100, 1.5);
    frame.depth = DepthImage(100, 100, z);
    const Frame noisy = withDepthNoise(frame, DepthNoise(), 1);
    double squares = 0;
    int count = 0;
    for (const float value : noisy.depth.pixels) {
      if (value <= 0) continue;
      squares += (value - z) * (value - z);
      ++count;
    }
    return std::sqrt(squares / count);
  };
  EXPECT_NEAR(sigma(10) / sigma(5), 4, 0.4);
  const Camera camera = pinholeCamera(100, 100, 1.5);
  const DepthNoise noise;
  EXPECT_NEAR(sigma(5), 25 / (camera.fx * noise.baseline_m) * noise.disparity_sigma_px, 0.03);
}

TEST(DepthNoise, LosesItsShareOfThePixelsAndAddsNone) {
  std::size_t had = 0, lost = 0;
  for (const Frame& truth : cleanFrames()) {
    const Frame noisy = withDepthNoise(truth, DepthNoise(), 1);
    for (std::size_t i = 0; i < truth.depth.pixels.size(); ++i) {
      ASSERT_TRUE(truth.depth.pixels[i] > 0 || noisy.depth.pixels[i] == 0);
      had += truth.depth.pixels[i] > 0;
      lost += truth.depth.pixels[i] > 0 && noisy.depth.pixels[i] <= 0;
      ASSERT_LE(noisy.depth.pixels[i], DepthNoise().max_range_m * 1.001);
    }
  }
  EXPECT_GT(lost, 0.015 * static_cast<double>(had));
  EXPECT_LT(lost, 0.08 * static_cast<double>(had));
}

TEST(DepthNoise, NearThingsGrowOverTheirEdges) {
  Frame frame;
  frame.camera = pinholeCamera(100, 100, 1.5);
  frame.depth = DepthImage(100, 100, 30);
  for (int y = 0; y < 100; ++y) {
    for (int x = 40; x < 60; ++x) frame.depth.at(x, y) = 5;
  }
  DepthNoise noise;
  noise.invalid_share = 0;
  const Frame noisy = withDepthNoise(frame, noise, 1);
  const auto near = std::count_if(noisy.depth.pixels.begin(), noisy.depth.pixels.end(),
                                  [](float z) { return z > 0 && z < 8; });
  EXPECT_GT(near, 2050);
  EXPECT_LT(near, 2600);
}

TEST(Noise, OfAnEmptyFrameIsEmpty) {
  EXPECT_TRUE(withLabelNoise(Frame(), LabelNoise(), 1).label.empty());
  EXPECT_TRUE(withDepthNoise(Frame(), DepthNoise(), 1).depth.empty());
  EXPECT_TRUE(withLidarNoise(Frame(), LidarNoise(), 1).cloud.empty());
}

TEST(OwnMotion, LeavesWhatIsAheadAndShiftsWhatIsBehindByHalfATurnOfTravel) {
  Frame frame;
  for (const double yaw : {0.0, M_PI / 2, -M_PI / 2, M_PI - 1e-6, -M_PI + 1e-6}) {
    Point point;
    point.x = static_cast<float>(20 * std::cos(yaw));
    point.y = static_cast<float>(20 * std::sin(yaw));
    point.z = 1;
    frame.cloud.points.push_back(point);
  }
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  step.translation().x() = 2;
  const Frame moved = withOwnMotion(frame, step, 0.5);  // 1 m per turn
  const double shift[] = {0, -0.25, 0.25, -0.5, 0.5};
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    const Eigen::Vector3d d = moved.cloud.position(i) - frame.cloud.position(i);
    EXPECT_NEAR((d - Eigen::Vector3d(shift[i], 0, 0)).norm(), 0, 1e-4) << i;
  }
}

TEST(OwnMotion, OfAScannerThatTurnsIsUndoneByTheInverseMotion) {
  Frame frame;
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    Point point;
    point.x = static_cast<float>(random.uniform(-30, 30));
    point.y = static_cast<float>(random.uniform(-30, 30));
    point.z = static_cast<float>(random.uniform(-2, 5));
    if (point.getVector3fMap().head<2>().norm() > 5) frame.cloud.points.push_back(point);
  }
  Eigen::Isometry3d step(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ()));
  step.translation() = Eigen::Vector3d(0.9, 0.02, 0.01);
  const Frame raw = withOwnMotion(frame, step, 1);
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    const Eigen::Vector3d p = frame.cloud.position(i);
    const double turns = std::atan2(p.y(), p.x()) / (2 * M_PI);
    Eigen::Isometry3d T_now(Eigen::AngleAxisd(0.05 * turns, Eigen::Vector3d::UnitZ()));
    T_now.translation() = turns * step.translation();
    EXPECT_LT((T_now * raw.cloud.position(i) - p).norm(), 1e-4);
  }
}

TEST(LidarNoise, ShiftsAlongTheRayAndKeepsItsAccuracy) {
  Frame frame;
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    Point point;
    const double yaw = random.uniform(-3, 3), range = random.uniform(2, 50);
    point.x = static_cast<float>(range * std::cos(yaw));
    point.y = static_cast<float>(range * std::sin(yaw));
    point.z = 0;
    point.label = town_class::kBuilding;
    point.instance = static_cast<std::uint32_t>(i + 1);
    frame.cloud.points.push_back(point);
  }
  LidarNoise noise;
  noise.range_sigma_m = 0.05;
  const Frame noisy = withLidarNoise(frame, noise, 1);
  const auto n = static_cast<double>(noisy.cloud.size());
  EXPECT_NEAR(n / 20000, 1 - noise.dropout_share, 0.005);
  double right = 0, squares = 0;
  for (std::size_t i = 0; i < noisy.cloud.size(); ++i) {
    const bool is_right = noisy.cloud.points[i].label == town_class::kBuilding;
    right += is_right;
    if (!is_right) continue;
    const auto truth = frame.cloud.position(noisy.cloud.points[i].instance - 1);
    const Eigen::Vector3d error = noisy.cloud.position(i) - truth;
    EXPECT_LT(error.cross(truth.normalized()).norm(), 1e-4);
    squares += error.squaredNorm();
  }
  EXPECT_NEAR(right / n, noise.label_accuracy, 0.01);
  EXPECT_NEAR(std::sqrt(squares / right), 0.05, 0.003);
}

}  // namespace
}  // namespace xview
