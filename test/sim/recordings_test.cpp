// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recordings.h"
#include "support/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {
namespace {

SimulationOptions smallSimulation() {
  SimulationOptions options;
  options.route_length_m = 60;
  options.width = 80;
  options.height = 60;
  options.town.blocks_x = options.town.blocks_y = 2;
  options.lidar.rings = 16;
  options.lidar.azimuths = 256;
  options.sessions = {true, true, true, true, true, true, true};
  return options;
}

using Sessions = std::map<std::string, std::unique_ptr<SimulatedRecording>>;

Sessions byName(const SimulationOptions& options) {
  Sessions sessions;
  for (auto& session : makeSessions(options)) {
    const std::string name = session->name();
    sessions[name] = std::move(session);
  }
  return sessions;
}

const Sessions& cleanSessions() {
  static const Sessions sessions = byName(smallSimulation());
  return sessions;
}

bool sameFrame(const Frame& a, const Frame& b) {
  bool same = a.depth.pixels == b.depth.pixels && a.label.pixels == b.label.pixels &&
              a.instance.pixels == b.instance.pixels && a.number == b.number &&
              a.stamp_s == b.stamp_s && a.T_odom_sensor.matrix() == b.T_odom_sensor.matrix() &&
              a.cloud.size() == b.cloud.size() &&
              test::instancesOf(a.cloud) == test::instancesOf(b.cloud);
  for (std::size_t i = 0; same && i < a.cloud.size(); ++i) {
    same = a.cloud.position(i) == b.cloud.position(i) &&
           a.cloud.points[i].label == b.cloud.points[i].label;
  }
  return same;
}

TEST(Recordings, AreThoseThatWereChosenWithForwardFirst) {
  SimulationOptions options = smallSimulation();
  options.sessions = SessionChoice();
  const auto sessions = makeSessions(options);
  ASSERT_EQ(sessions.size(), 3u);
  EXPECT_EQ(sessions[0]->name(), "forward");
  EXPECT_EQ(sessions[1]->name(), "rear");
  EXPECT_EQ(sessions[2]->name(), "aerial");
  EXPECT_EQ(cleanSessions().size(), 11u);
}

TEST(Recordings, FramesAreCompleteAndEvenlySpaced) {
  for (const auto& [name, session] : cleanSessions()) {
    EXPECT_NEAR(static_cast<double>(session->size()), 31, 2) << name;
    EXPECT_EQ(session->labels(), townLabels());
    for (std::size_t i = 1; i < session->size(); ++i) {
      EXPECT_GT(session->stamp(i), session->stamp(i - 1));
      EXPECT_NEAR((session->pose(i).translation() - session->pose(i - 1).translation()).norm(), 2,
                  0.6)
          << name;
    }
    const Frame frame = session->read(1);
    EXPECT_EQ(frame.sensor, session->sensor());
    EXPECT_EQ(frame.number, session->number(1));
    EXPECT_TRUE(frame.T_odom_sensor.isApprox(session->pose(1)));
    if (session->sensor() == Sensor::camera) {
      EXPECT_EQ(frame.depth.width, 80);
      EXPECT_EQ(frame.label.height, 60);
      EXPECT_EQ(frame.instance.pixels.size(), frame.label.pixels.size());
    } else {
      EXPECT_GT(frame.cloud.size(), 1000u);
    }
  }
}

TEST(Recordings, InWinterNothingGrowsAndTheHousesStandWhereTheyStood) {
  SimulationOptions options = smallSimulation();
  options.sessions = SessionChoice();
  options.sessions.forward2 = options.sessions.winter = true;
  const Sessions sessions = byName(options);
  const auto pixelsOf = [&](const char* session, std::uint16_t label) {
    std::size_t pixels = 0;
    for (const std::size_t i : {0u, 10u, 20u}) {
      const LabelImage image = sessions.at(session)->read(i).label;
      pixels += std::count(image.pixels.begin(), image.pixels.end(), label);
    }
    return pixels;
  };
  EXPECT_GT(pixelsOf("forward2", town_class::kVegetation), 100u);
  EXPECT_EQ(pixelsOf("winter", town_class::kVegetation), 0u);
  // What stood behind trees is seen as well.
  EXPECT_GE(pixelsOf("winter", town_class::kBuilding), pixelsOf("forward2", town_class::kBuilding));
  EXPECT_LT((sessions.at("winter")->truth(20).translation() -
             sessions.at("forward2")->truth(20).translation())
                .norm(),
            0.5);
}

TEST(Recordings, CleanOdometryIsTheTruthUpToOneUprightMotion) {
  for (const auto& [name, session] : cleanSessions()) {
    const Eigen::Isometry3d T_map_odom = session->truth(0) * session->pose(0).inverse();
    EXPECT_LT((T_map_odom.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-9) << name;
    for (std::size_t i = 0; i < session->size(); ++i) {
      EXPECT_LT(((T_map_odom * session->pose(i)).matrix() - session->truth(i).matrix()).norm(),
                1e-6)
          << name;
    }
    const bool is_mapping_drive = name == "forward" || name == "lidar";
    EXPECT_EQ(T_map_odom.isApprox(Eigen::Isometry3d::Identity(), 1e-6), is_mapping_drive) << name;
  }
}

TEST(Recordings, LookWhereTheirNamesSay) {
  const auto axis = [](const std::string& name, std::size_t i) {
    return Eigen::Vector3d(cleanSessions().at(name)->truth(i).linear().col(2));
  };
  const auto at = [](const std::string& name, std::size_t i) {
    return Eigen::Vector3d(cleanSessions().at(name)->truth(i).translation());
  };
  EXPECT_GT(axis("forward", 5).dot(axis("forward2", 5)), 0.99);
  EXPECT_LT(axis("forward", 5).dot(axis("rear", 5)), -0.99);
  EXPECT_NEAR(axis("forward", 5).dot(axis("oblique", 5)), std::cos(0.9), 0.05);
  EXPECT_LT(axis("aerial", 5).z(), -0.9);
  EXPECT_NEAR(at("aerial", 5).z() - at("forward", 5).z(), 45 - 1.7, 5);
  EXPECT_LT((at("forward", 5) - at("rear", 5)).norm(), 1);
  const std::size_t last = cleanSessions().at("reverse")->size() - 1;
  EXPECT_NEAR((at("forward", 0) - at("reverse", last)).norm(), 2.8, 2);
  EXPECT_LT(axis("forward", 0).dot(axis("reverse", last)), -0.9);
  EXPECT_GT((at("forward", 0) - at("elsewhere", 0)).norm(), 1e4);
  EXPECT_GT((at("forward", 0) - at("lidar_elsewhere", 0)).norm(), 1e4);
  EXPECT_LT((at("elsewhere", 3) - at("lidar_elsewhere", 3)).norm(), 5);
  EXPECT_GT((at("forward", 0) - at("aerial_elsewhere", 0)).norm(), 1e4);
  EXPECT_LT(axis("aerial_elsewhere", 5).z(), -0.9);
}

TEST(Recordings, ASecondCameraLooksBackAtTheSameInstants) {
  SimulationOptions options = smallSimulation();
  options.sessions.rear_now = true;
  const Sessions sessions = byName(options);
  const SimulatedRecording &forward = *sessions.at("forward"), &back = *sessions.at("rear_now");
  ASSERT_EQ(back.size(), forward.size());
  for (std::size_t i = 0; i < back.size(); i += 7) {
    EXPECT_EQ(back.stamp(i), forward.stamp(i));
    EXPECT_LT((back.truth(i).translation() - forward.truth(i).translation()).norm(), 0.05);
    EXPECT_LT(back.truth(i).linear().col(2).dot(forward.truth(i).linear().col(2)), -0.99);
  }
}

TEST(Recordings, WithLabelsOfANetworkMayHaveTrueDepth) {
  SimulationOptions options = smallSimulation();
  options.quality = "labels";
  const Sessions sessions = byName(options);
  const Frame clean = cleanSessions().at("rear")->read(5), frame = sessions.at("rear")->read(5);
  EXPECT_EQ(frame.depth.pixels, clean.depth.pixels);
  EXPECT_EQ(frame.T_odom_sensor.matrix(), clean.T_odom_sensor.matrix());
  EXPECT_NE(frame.label.pixels, clean.label.pixels);
}

TEST(Recordings, SeeTheSameTownInTheMapFrame) {
  // What the camera of `rear` sees must stand where `forward`'s map frame says: the road under the
  // camera.
  for (const char* name : {"forward", "rear", "reverse", "oblique", "lidar"}) {
    const auto& session = cleanSessions().at(name);
    const auto& forward = cleanSessions().at("forward");
    EXPECT_LT(std::abs(session->truth(3).translation().z() - forward->truth(3).translation().z()),
              3)
        << name;
  }
  const auto& aerial = cleanSessions().at("aerial");
  const Frame frame = aerial->read(8);
  const Camera& camera = aerial->camera();
  int seen = 0, on_ground = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (frame.label.at(x, y) != town_class::kRoad) continue;
      const double z = frame.depth.at(x, y);
      const Eigen::Vector3d p =
          aerial->truth(8) *
          Eigen::Vector3d((x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z);
      ++seen;
      on_ground +=
          std::abs(p.z() + 1.7 - cleanSessions().at("forward")->truth(8).translation().z()) < 4;
    }
  }
  EXPECT_GT(seen, 100);
  EXPECT_EQ(on_ground, seen);
}

TEST(Recordings, AreTheSameBytesForAnyThreadsAndRuns) {
  for (const char* quality : {"clean", "noisy"}) {
    SimulationOptions options = smallSimulation();
    options.quality = quality;
    options.threads = 1;
    const Sessions one = byName(options);
    options.threads = 2;
    const Sessions two = byName(options);
    for (const auto& [name, session] : one) {
      EXPECT_TRUE(sameFrame(session->read(4), two.at(name)->read(4))) << name;
      EXPECT_TRUE(sameFrame(session->read(4), session->read(4))) << name;
    }
  }
}

TEST(Recordings, OtherSeedIsAnotherTown) {
  SimulationOptions options = smallSimulation();
  options.seed = 2;
  options.sessions = {};
  EXPECT_FALSE(
      sameFrame(makeSessions(options)[0]->read(0), cleanSessions().at("forward")->read(0)));
}

TEST(Recordings, NoisyOnesDriftButTheMappingDrivesDoNot) {
  SimulationOptions options = smallSimulation();
  options.quality = "noisy";
  for (const auto& session : makeSessions(options)) {
    const std::size_t last = session->size() - 1;
    const Eigen::Isometry3d moved = session->truth(0).inverse() * session->truth(last);
    const Eigen::Isometry3d measured = session->pose(0).inverse() * session->pose(last);
    const double error = (moved.translation() - measured.translation()).norm();
    if (session->name() == "forward" || session->name() == "lidar") {
      EXPECT_LT(error, 1e-6);
    } else {
      EXPECT_GT(error, 0.05) << session->name();
    }
    EXPECT_LT(error, 2) << session->name();
  }
}

TEST(Recordings, OptionsOutOfRangeAreRefusedByName) {
  const auto message = [](const SimulationOptions& options) {
    return test::messageOf<UsageError>([&] { makeSessions(options); });
  };
  SimulationOptions options = smallSimulation();
  options.width = 0;
  EXPECT_EQ(message(options), "width = 0, must be in [16, 8192]");
  options = smallSimulation();
  options.quality = "dirty";
  EXPECT_EQ(message(options), "quality = dirty, must be one of clean, labels, noisy");
  options = smallSimulation();
  options.label_noise.accuracy = 2;
  EXPECT_EQ(message(options), "label_noise.accuracy = 2, must be in [0.3, 1]");
}

TEST(Recordings, EveryStyleGivesAllItsSessions) {
  for (const char* style : {"grid", "village", "campus", "office"}) {
    SimulationOptions options = smallSimulation();
    options.sim.style = style;
    options.quality = "noisy";
    options.route_length_m = 30;
    const bool indoors = options.sim.style == "office";
    const Sessions sessions = byName(options);
    EXPECT_EQ(sessions.size(), indoors ? 9u : 11u) << style;
    const Frame frame = sessions.at("rear")->read(0);
    std::size_t seen = 0;
    for (const float depth : frame.depth.pixels) {
      seen += depth > 0;
      if (indoors && depth > 0) {
        EXPECT_TRUE(depth >= 0.3f && depth <= 8.0f) << depth;
      }
    }
    EXPECT_GT(seen, frame.depth.pixels.size() / 3) << style;
    const LabelSet& labels = sessions.at("rear")->labels();
    for (const std::uint16_t label : frame.label.pixels) ASSERT_TRUE(labels.find(label)) << label;
  }
}

}  // namespace
}  // namespace xview
