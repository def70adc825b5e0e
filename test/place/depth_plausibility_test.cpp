// SPDX-License-Identifier: BSD-3-Clause
#include "place/depth_plausibility.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "localizer/simulated_drive.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"
#include "xview/mapper.h"

namespace xview {
namespace {

using test::simulatedDrive;

/// The forward drive, its depths times a factor.
class ScaledRecording : public ForwardingSource {
 public:
  explicit ScaledRecording(float factor, bool stands = false)
      : ForwardingSource(*simulatedDrive().sessions.at("forward")),
        factor_(factor),
        stands_(stands) {}
  std::size_t size() const override { return 8; }
  Eigen::Isometry3d pose(std::size_t i) const override {
    return ForwardingSource::pose(stands_ ? 0 : i);
  }
  Frame read(std::size_t i) const override {
    Frame frame = ForwardingSource::read(stands_ ? 0 : i);
    for (float& z : frame.depth.pixels) z *= factor_;
    return frame;
  }
  const std::string& name() const override { return name_; }

 private:
  float factor_;
  bool stands_;
  std::string name_ = "scaled";
};

std::string complaintAbout(const FrameSource& source) {
  return test::messageOf<Error>([&] { preprocessRecording(source, {}); });
}

TEST(DepthPlausibility, DepthsAHundredOrAThousandTimesOffAreNamed) {
  for (const float factor : {0.001f, 0.01f, 100.f, 1000.f}) {
    const std::string complaint = complaintAbout(ScaledRecording(factor));
    EXPECT_EQ(complaint.rfind("scaled: ", 0), 0u) << factor << ": " << complaint;
    EXPECT_NE(complaint.find("depth_scale"), std::string::npos) << factor << ": " << complaint;
    EXPECT_EQ(complaint.find('\n'), std::string::npos);
  }
}

TEST(DepthPlausibility, DepthsTenTimesTooSmallContradictTheMotion) {
  const std::string complaint = complaintAbout(ScaledRecording(0.1f));
  EXPECT_NE(complaint.find("10 times"), std::string::npos) << complaint;
}

TEST(DepthPlausibility, DepthsTenTimesTooLargeContradictTheMotion) {
  const std::string complaint = complaintAbout(ScaledRecording(10));
  EXPECT_NE(complaint.find("0.1 times"), std::string::npos) << complaint;
  const double scale = simulatedDrive().sessions.at("forward")->read(0).camera.depth_scale;
  EXPECT_NE(complaint.find(fmt::format("is it depth_scale {:g}?", 0.1 * scale)), std::string::npos)
      << complaint;
}

TEST(DepthPlausibility, MapsAreNotMadeOfWrongDepths) {
  const ScaledRecording wrong(0.001f);
  EXPECT_THROW(buildMap({&wrong}, {}), Error);
}

TEST(DepthPlausibility, RightDepthsPass) { EXPECT_EQ(complaintAbout(ScaledRecording(1)), ""); }

TEST(DepthPlausibility, ASmallRoomSeenByACameraThatMovesAsMuchPasses) {
  // The whole world ten times smaller: depths are small and poses agree with them.
  struct Model : ScaledRecording {
    Model() : ScaledRecording(0.1f) {}
    Eigen::Isometry3d pose(std::size_t i) const override {
      return shrunk(ScaledRecording::pose(i));
    }
    Frame read(std::size_t i) const override {
      Frame frame = ScaledRecording::read(i);
      frame.T_odom_sensor = shrunk(frame.T_odom_sensor);
      return frame;
    }
    static Eigen::Isometry3d shrunk(Eigen::Isometry3d T) {
      T.translation() *= 0.1;
      return T;
    }
  } model;
  Options options;
  options.lift.min_range_m = 0.03;
  EXPECT_NO_THROW(preprocessRecording(model, options));
}

TEST(DepthPlausibility, ACameraThatStandsStillTellsNothing) {
  EXPECT_NO_THROW(preprocessRecording(ScaledRecording(0.1f, true), {}));
}

/// A drive measured along the rays or along the optical axis, with a camera that declares either.
class OfKind : public ForwardingSource {
 public:
  OfKind(const std::string& session, bool measured_range, bool declared_range, double narrower = 1)
      : ForwardingSource(*simulatedDrive().sessions.at(session)),
        measured_range_(measured_range),
        declared_range_(declared_range),
        narrower_(narrower) {}
  std::size_t size() const override { return 20; }
  Frame read(std::size_t i) const override {
    Frame frame = ForwardingSource::read(i);
    Camera& camera = frame.camera;
    for (int v = 0; v < frame.depth.height; ++v) {
      for (int u = 0; u < frame.depth.width; ++u) {
        const double x = (u - camera.cx) / camera.fx, y = (v - camera.cy) / camera.fy;
        float& z = frame.depth.at(u, v);
        if (measured_range_) z *= static_cast<float>(std::sqrt(x * x + y * y + 1));
        const bool outside = std::max(std::abs(x), std::abs(y)) > 1 / narrower_;
        if (narrower_ > 1 && outside) z = 0;
      }
    }
    camera.depth_is_range = declared_range_;
    return frame;
  }
  const std::string& name() const override { return name_; }

 private:
  bool measured_range_, declared_range_;
  double narrower_;
  std::string name_ = "kind";
};

TEST(DepthPlausibility, DepthAlongTheRayDeclaredPlanarIsNamedAndTheOtherWayRound) {
  for (const char* session : {"forward", "rear"}) {
    for (const bool measured_range : {false, true}) {
      EXPECT_EQ(complaintAbout(OfKind(session, measured_range, measured_range)), "") << session;
      const std::string complaint =
          complaintAbout(OfKind(session, measured_range, !measured_range));
      EXPECT_EQ(complaint.rfind("kind: ", 0), 0u) << session << complaint;
      const std::string missing = measured_range ? "`depth: range`" : "`depth: planar`";
      EXPECT_NE(complaint.find(missing), std::string::npos) << complaint;
      EXPECT_EQ(complaint.find('\n'), std::string::npos);
    }
  }
}

TEST(DepthPlausibility, WithoutAViewWideEnoughTheKindOfDepthIsNotDoubted) {
  EXPECT_EQ(complaintAbout(OfKind("forward", true, false, 20)), "");
}

/// A desk: objects some decimetres apart, and the cloud of a room.
TEST(Units, MillimetresAndCentimetresAreDoubtedAndMetresAreNot) {
  Random random(1);
  Place desk, room;
  for (int i = 0; i < 40; ++i) {
    Vertex vertex;
    vertex.position = {random.uniform(0, 1.6), random.uniform(0, 1.3), random.uniform(0, 0.7)};
    desk.graph.vertices.push_back(vertex);
  }
  for (int i = 0; i < 5000; ++i)
    room.cloud.points.push_back(Point(static_cast<float>(random.uniform(0, 4)),
                                      static_cast<float>(random.uniform(0, 3.5)),
                                      static_cast<float>(random.uniform(0, 2.5))));
  for (Place* place : {&desk, &room}) {
    EXPECT_EQ(checkMetres(*place), std::nullopt);
    Place centimetres = *place;
    scaleLengths(100, centimetres);
    const auto problem = checkMetres(centimetres);
    ASSERT_TRUE(problem.has_value());
    EXPECT_NE(problem->find("centimetres"), std::string::npos) << *problem;
    EXPECT_EQ(problem->find('\n'), std::string::npos);
  }
  const map::SemanticMap& town = simulatedDrive().map;
  EXPECT_EQ(checkMetres(town), std::nullopt);
}

/// Check fix for: a map of a cloud whose y is up finds nothing and says nothing.
TEST(Upright, AnAxisThatMayBeUpIsNamedAndTheOthersAreNot) {
  Random random(1);
  Place town;
  for (int i = 0; i < 5000; ++i)
    town.cloud.points.push_back(Point(static_cast<float>(random.uniform(0, 140)),
                                      static_cast<float>(random.uniform(0, 90)),
                                      static_cast<float>(i % 2 ? 0 : random.uniform(0, 12))));
  EXPECT_EQ(checkUpright(town), std::nullopt);
  const auto turned = [&](const Eigen::Matrix3d& from_upright) {
    Place place = town;
    for (Point& p : place.cloud.points)
      p.getVector3fMap() = from_upright.cast<float>() * p.getVector3fMap();
    return place;
  };
  for (const int axis : {0, 1}) {
    for (const int sign : {1, -1}) {
      const Eigen::Matrix3d upright = turnUpright(axis, sign);
      EXPECT_EQ(Eigen::Vector3d(upright * (sign * Eigen::Vector3d::Unit(axis))),
                Eigen::Vector3d::UnitZ());
      const auto problem = checkUpright(turned(upright.transpose()));
      ASSERT_TRUE(problem.has_value());
      const std::string up = fmt::format("is {}{} up", sign < 0 ? "-" : "", "xy"[axis]);
      EXPECT_NE(problem->find(up), std::string::npos) << *problem;
    }
  }
  Place tower;  // 40 m high, 20 m wide
  for (int i = 0; i < 5000; ++i)
    tower.cloud.points.push_back(Point(static_cast<float>(random.uniform(0, 20)),
                                       static_cast<float>(random.uniform(0, 20)),
                                       static_cast<float>(random.uniform(0, 40))));
  EXPECT_EQ(checkUpright(tower), std::nullopt);
  EXPECT_EQ(checkUpright(Place()), std::nullopt);
}

}  // namespace
}  // namespace xview
