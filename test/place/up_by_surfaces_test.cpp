// SPDX-License-Identifier: BSD-3-Clause
// Cameras whose frame is that of their first image: which way is up there, and what follows.
#include "place/up_by_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "base/pose.h"
#include "base/random.h"
#include "place/gravity.h"
#include "place/raw_recording.h"
#include "place/shapes.h"
#include "place/shapes_any_way_up.h"
#include "support/test_data.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/mapper.h"

namespace xview {
namespace {

constexpr double kPerDegree = M_PI / 180;

/// Depth images of a room of 6 x 5 x 2.5 m, z up, with a table and a chest; images err by a share
/// of their depths. All poses are given in another frame.
class Room final : public FrameSource {
 public:
  /// Of images at these poses, T_room_sensor.
  Room(std::vector<Eigen::Isometry3d> poses, const Eigen::Isometry3d& T_given_room)
      : poses_(std::move(poses)), T_given_room_(T_given_room) {}

  std::size_t size() const override { return poses_.size(); }
  Eigen::Isometry3d pose(std::size_t i) const override { return T_given_room_ * poses_[i]; }
  double stamp(std::size_t i) const override { return static_cast<double>(i); }
  std::int64_t number(std::size_t i) const override { return static_cast<std::int64_t>(i); }
  Sensor sensor() const override { return Sensor::camera; }
  const LabelSet& labels() const override { return labels_; }
  const std::string& name() const override { return name_; }

  Frame read(std::size_t index) const override {
    Frame frame;
    frame.number = number(index);
    frame.stamp_s = stamp(index);
    frame.T_odom_sensor = pose(index);
    frame.camera.width = 160;
    frame.camera.height = 120;
    frame.camera.fx = frame.camera.fy = 146;
    frame.camera.cx = 80;
    frame.camera.cy = 60;
    frame.depth = DepthImage(160, 120);
    Random random(index + 1);
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const Eigen::Vector3d ray = poses_[index].linear() * frame.camera.unproject(u, v, 1);
        frame.depth.pixels[static_cast<std::size_t>(v) * 160 + u] = static_cast<float>(
            depthAlong(poses_[index].translation(), ray) * (1 + 0.002 * random.normal()));
      }
    }
    return frame;
  }

 private:
  struct Box {
    Eigen::Vector3d low, high;
  };

  /// Times the ray: to the walls from within, or to furniture from without.
  static double depthAlong(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    const auto [enters_room, leaves_room] = crossings({{0, 0, 0}, {6, 5, 2.5}}, from, ray);
    double depth = leaves_room;
    for (const Box& box : {Box{{2, 2, 0.7}, {3.5, 2.9, 0.75}}, Box{{4.8, 0, 0}, {6, 0.6, 1.1}}}) {
      const auto [enters, leaves] = crossings(box, from, ray);
      if (enters > 0 && enters < leaves) depth = std::min(depth, enters);
    }
    return depth;
  }
  static std::pair<double, double> crossings(const Box& box, const Eigen::Vector3d& from,
                                             const Eigen::Vector3d& ray) {
    double enters = -INFINITY, leaves = INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.low[axis] - from[axis]) / ray[axis],
                   b = (box.high[axis] - from[axis]) / ray[axis];
      enters = std::max(enters, std::min(a, b));
      leaves = std::min(leaves, std::max(a, b));
    }
    return {enters, leaves};
  }

  std::vector<Eigen::Isometry3d> poses_;
  Eigen::Isometry3d T_given_room_;
  LabelSet labels_;
  std::string name_ = "room";
};

/// A camera in the room: heading, angle below the horizon and turn about its optical axis [deg].
Eigen::Isometry3d lookingAt(double x, double y, double heading, double down, double roll = 0) {
  Eigen::Isometry3d T = poseFromYaw({x, y, 1.3}, heading * kPerDegree);
  Eigen::Matrix3d R_level_camera;  // x forward, y left, z up; x right, y down, z forward
  R_level_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T.linear() = T.linear() * Eigen::AngleAxisd(down * kPerDegree, Eigen::Vector3d::UnitY()) *
               R_level_camera * Eigen::AngleAxisd(roll * kPerDegree, Eigen::Vector3d::UnitZ());
  return T;
}

std::vector<Eigen::Isometry3d> turningHead(double down, double roll = 0) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 8; ++i)
    poses.push_back(lookingAt(1 + 0.1 * i, 1.2, 10 + 8 * i, down + 2 * i, roll));
  return poses;
}

Eigen::Isometry3d inFirstImage(const std::vector<Eigen::Isometry3d>& poses) {
  return poses[0].inverse();
}

double degreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) / kPerDegree;
}

/// Check fix for: raw depth images in the frame of their first image were labelled as if they
/// looked at the sky.
TEST(CameraUp, InTheFrameOfTheFirstImageIsThatOfSurfacesNearTheTopOfImages) {
  for (const double down : {-10.0, 5.0, 20.0, 35.0}) {
    for (const double roll : {-20.0, 0.0, 10.0}) {
      const auto poses = turningHead(down, roll);
      const Eigen::Isometry3d T = inFirstImage(poses);
      const Eigen::Vector3d up = upOfCamera(Room(poses, T));
      ASSERT_NEAR(up.norm(), 1, 1e-9) << down << " deg down, rolled by " << roll;
      EXPECT_LT(degreesBetween(up, T.linear().col(2)), 1.5) << down << " down, rolled by " << roll;
    }
  }
}

TEST(CameraUp, OfFramesThatAreUprightIsLeftToThem) {
  const Eigen::Isometry3d same = Eigen::Isometry3d::Identity();
  EXPECT_EQ(upOfCamera(Room(turningHead(20), same)).norm(), 0);
  EXPECT_EQ(upOfCamera(Room(turningHead(20, 30), same)).norm(), 0) << "rolled";
  EXPECT_EQ(upOfCamera(Room(turningHead(10, 90), same)).norm(), 0) << "on its side";
  EXPECT_EQ(upOfCamera(Room(turningHead(10, 180), same)).norm(), 0) << "upside down";
  EXPECT_EQ(upOfCamera(Room({lookingAt(2, 2, 30, 90)}, same)).norm(), 0) << "straight down";
}

TEST(CameraUp, OfTooLittleIsNotTold) {
  const auto poses = turningHead(20);
  class Blind final : public ForwardingSource {
   public:
    explicit Blind(const FrameSource& source) : ForwardingSource(source) {}
    Frame read(std::size_t i) const override {
      Frame frame = ForwardingSource::read(i);
      std::fill(frame.depth.pixels.begin(), frame.depth.pixels.end(), 0.F);
      return frame;
    }
  };
  const Room room(poses, inFirstImage(poses));
  EXPECT_EQ(upOfCamera(Blind(room)).norm(), 0);
}

std::vector<double> sharesOf(const FrameSource& source) {
  std::vector<double> shares(kShapeCount, 0);
  double count = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    for (const std::uint16_t label : source.read(i).label.pixels) shares[label] += 1, count += 1;
  }
  for (double& share : shares) share /= count;
  return shares;
}

TEST(CameraUp, GivesRawImagesTheClassesOfUprightOnes) {
  const auto poses = turningHead(15);
  const auto labelled = [&](const Eigen::Isometry3d& T, const std::string& gravity) {
    Options options;
    options.gravity = gravity;
    return sharesOf(*withShapeLabels(std::make_unique<Room>(poses, T), labelsOfShapes(), options));
  };
  const auto upright = labelled(Eigen::Isometry3d::Identity(), "auto"),
             first = labelled(inFirstImage(poses), "auto"),
             as_given = labelled(inFirstImage(poses), "aligned");
  const auto of = [](Shape shape) { return static_cast<std::size_t>(shape); };
  EXPECT_GT(upright[of(Shape::ground)], 0.15);
  EXPECT_GT(upright[of(Shape::wall)], 0.2);
  double off = 0, off_as_given = 0;
  for (std::size_t i = 0; i < upright.size(); ++i) {
    off += std::abs(first[i] - upright[i]);
    off_as_given += std::abs(as_given[i] - upright[i]);
  }
  EXPECT_LT(off, 0.15);
  EXPECT_GT(off_as_given, 0.3) << "gravity = aligned says that z is up";
}

/// Check fix for: all furniture of a room was a low thing, which is left out as vehicles are.
TEST(CameraUp, NothingInARoomIsAVehicle) {
  const auto poses = turningHead(15);
  const auto low_things = [&](const std::string& size) {
    Options options;
    options.size = size;
    return sharesOf(*withShapeLabels(std::make_unique<Room>(poses, Eigen::Isometry3d::Identity()),
                                     labelsOfShapes(),
                                     options))[static_cast<std::size_t>(Shape::low_thing)];
  };
  EXPECT_EQ(low_things("auto"), 0);
  EXPECT_EQ(low_things("room"), 0);
}

/// What all images show, in one cloud without view-points.
LabelledCloud cloudOf(const FrameSource& images, int step_px = 1) {
  LabelledCloud cloud;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Frame frame = images.read(i);
    for (int v = 0; v < frame.depth.height; v += step_px) {
      for (int u = 0; u < frame.depth.width; u += step_px) {
        if (!isDepth(frame.depth.at(u, v))) continue;
        const Eigen::Vector3f p =
            (frame.T_odom_sensor * frame.camera.unproject(u, v, frame.depth.at(u, v)))
                .cast<float>();
        cloud.points.emplace_back(p.x(), p.y(), p.z(), 0);
      }
    }
  }
  return cloud;
}

/// Check fix for: clouds of rooms in frames of cameras had walls for ground.
TEST(UpOfClouds, OfRoomsInFramesOfCamerasIsToldBySurfaces) {
  for (const double down : {5.0, 20.0, 35.0}) {
    const auto poses = turningHead(down, 5);
    const Eigen::Isometry3d T = inFirstImage(poses);
    pcl::PointCloud<Point> points = cloudOf(Room(poses, T)).points;
    const Eigen::Vector3d up = T.linear().col(2),
                          vertical = verticalOfRoom(points, kRoomScale).axis;
    EXPECT_LT(std::min(degreesBetween(vertical, up), degreesBetween(-vertical, up)), 2) << down;
    const Eigen::Vector3d told =
        labelAnyWayUp(Eigen::Matrix3d::Identity(), Sensor::cloud, kRoomScale, points);
    EXPECT_LT(degreesBetween(told, up), 2) << down;
  }
  pcl::PointCloud<Point> upright =
      cloudOf(Room(turningHead(20, 5), Eigen::Isometry3d::Identity())).points;
  EXPECT_EQ(verticalOfRoom(upright, kRoomScale).axis, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(verticalOfRoom({}, kRoomScale).axis.isZero());
  EXPECT_EQ(labelAnyWayUp(Eigen::Matrix3d::Identity(), Sensor::cloud, kRoomScale, upright).norm(),
            0);
}

/// Check fix for: the wall before a camera was taken for its ground.
TEST(UpOfClouds, OfACameraBeforeAWallIsNearTheTopOfItsImage) {
  for (const double down : {5.0, 25.0, 45.0}) {
    const std::vector<Eigen::Isometry3d> poses = {lookingAt(4.4, 1.2, 10, down)};
    const Eigen::Isometry3d T = inFirstImage(poses);
    pcl::PointCloud<Point> points = cloudOf(Room(poses, T), 1).points;
    const Eigen::Vector3d told =
        labelAnyWayUp(Eigen::Matrix3d::Identity(), Sensor::cloud, kRoomScale, points);
    EXPECT_LT(degreesBetween(told, T.linear().col(2)), 3) << down;
  }
}

/// Check fix for: a room of which few points are floor was laid on its side.
TEST(UpOfClouds, OfARoomWithLittleFloorIsAsGiven) {
  const pcl::PointCloud<Point> all =
      cloudOf(Room(turningHead(20, 5), Eigen::Isometry3d::Identity())).points;
  pcl::PointCloud<Point> points;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].z > 0.1F || i % 20 == 0) points.push_back(all[i]);
  }
  EXPECT_TRUE(
      labelAnyWayUp(Eigen::Matrix3d::Identity(), Sensor::cloud, kRoomScale, points).isZero());
  const auto is_ground = [](const Point& p) {
    return p.label == static_cast<std::uint32_t>(Shape::ground);
  };
  double height = 0;
  for (const Point& p : points) height += is_ground(p) ? p.z : 0;
  EXPECT_LT(height / static_cast<double>(std::count_if(points.begin(), points.end(), is_ground)),
            0.2);
}

struct RealRoom {
  const char* folder;
  double most_m;
  bool accepted;
};

Eigen::Isometry3d truthIn(const std::string& data) {
  Eigen::Isometry3d T_map_query;
  std::ifstream file(data + "/query/truth.txt");
  std::string comment;
  std::getline(file, comment);
  for (int i = 0; i < 16; ++i) file >> T_map_query.matrix()(i / 4, i % 4);
  return T_map_query;
}

class RealRooms : public testing::TestWithParam<RealRoom> {};

/// Depth images of Kinects in frames of cameras, seen from another side.
TEST_P(RealRooms, AreFoundWithoutLabelsAndWithoutKnowingUp) {
  XVIEW_REQUIRE_DATA(data, GetParam().folder);
  const auto map_frames = io::openRecording(data + "/map"),
             frames = io::openRecording(data + "/query");
  const Options options;
  const Localizer localizer(buildMap(*map_frames, options), options);
  const Localization answer = localizer.localize(*frames);
  if (GetParam().accepted) {
    EXPECT_EQ(answer.status, Status::accepted) << answer.reason;
  }
  const Eigen::Vector3d last = frames->pose(frames->size() - 1).translation();
  EXPECT_LT((answer.T_map_query * last - truthIn(data) * last).norm(), GetParam().most_m);
}

/// Of the same as two clouds of points and nothing else, which are in different frames.
TEST_P(RealRooms, AsCloudsHaveOneUp) {
  XVIEW_REQUIRE_DATA(data, GetParam().folder);
  const auto up = [&](const std::string& part) {
    pcl::PointCloud<Point> points = cloudOf(*io::openRecording(data + part), 4).points;
    return labelAnyWayUp(Eigen::Matrix3d::Identity(), Sensor::cloud, kRoomScale, points);
  };
  EXPECT_LT(degreesBetween(truthIn(data).linear() * up("/query"), up("/map")), 4);
}

INSTANTIATE_TEST_SUITE_P(Kinect, RealRooms,
                         testing::Values(RealRoom{"rgbd_7scenes", 0.15, true},
                                         RealRoom{"rgbd_sun3d", 0.2, true}),
                         [](const auto& room) { return std::string(room.param.folder); });

}  // namespace
}  // namespace xview
