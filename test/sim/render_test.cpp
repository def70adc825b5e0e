// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/route.h"
#include "sim/town.h"

namespace xview {
namespace {

constexpr Tag kFirst{7, 1}, kSecond{9, 2};

std::shared_ptr<const RayScene> boxScene(const Eigen::Vector3d& at, double size, Tag tag) {
  TriangleMesh mesh;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = at;
  addBox(mesh, T, Eigen::Vector3d::Constant(size), tag);
  return std::make_shared<const RayScene>(std::move(mesh));
}

Eigen::Isometry3d lookingEast(const Eigen::Vector3d& at) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = at;
  return opticalPose(T);
}

Eigen::Vector3d unprojected(const Frame& frame, const Eigen::Isometry3d& T_world_camera, int x,
                            int y) {
  const Camera& c = frame.camera;
  const double z = frame.depth.at(x, y);
  return T_world_camera * Eigen::Vector3d((x - c.cx) / c.fx * z, (y - c.cy) / c.fy * z, z);
}

/// Nearest hit by trying every triangle (Möller and Trumbore 1997).
double bruteForce(const TriangleMesh& mesh, const Eigen::Vector3d& o, const Eigen::Vector3d& d,
                  Tag* tag) {
  double nearest = 1e9;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t.corner[0]].cast<double>();
    const Eigen::Vector3d e1 = mesh.vertices[t.corner[1]].cast<double>() - a;
    const Eigen::Vector3d e2 = mesh.vertices[t.corner[2]].cast<double>() - a;
    const Eigen::Vector3d p = d.cross(e2);
    const double det = e1.dot(p);
    if (det == 0) continue;
    const double u = (o - a).dot(p) / det;
    const Eigen::Vector3d q = (o - a).cross(e1);
    const double v = d.dot(q) / det, distance = e2.dot(q) / det;
    if (u < 0 || v < 0 || u + v > 1 || distance <= 0 || distance >= nearest) continue;
    nearest = distance;
    *tag = t.tag;
  }
  return nearest < 1e9 ? nearest : 0;
}

TEST(Renderer, DepthIsPlanarAndExact) {
  const Renderer renderer({boxScene({15, 0, -5}, 10, kFirst)});
  const Camera camera = pinholeCamera(41, 31, 1.0);
  const Frame frame = renderer.renderCamera(camera, lookingEast({0, 0, 0}));
  for (int y = 0; y < 31; ++y) {
    for (int x = 0; x < 41; ++x) {
      const bool hit = std::abs(x - camera.cx) / camera.fx * 10 < 4.99 &&
                       std::abs(y - camera.cy) / camera.fy * 10 < 4.99;
      if (!hit) continue;
      EXPECT_FLOAT_EQ(frame.depth.at(x, y), 10);
      EXPECT_EQ(frame.label.at(x, y), kFirst.label);
      EXPECT_EQ(frame.instance.at(x, y), kFirst.instance);
    }
  }
}

TEST(Renderer, NothingMeansSkyWithoutDepth) {
  const Renderer empty({std::make_shared<const RayScene>(TriangleMesh())});
  const Frame frame = empty.renderCamera(pinholeCamera(9, 7, 1), lookingEast({0, 0, 0}));
  for (const float z : frame.depth.pixels) EXPECT_EQ(z, 0);
  for (const auto label : frame.label.pixels) EXPECT_EQ(label, town_class::kSky);
  EXPECT_TRUE(empty.renderLidar(LidarModel(), Eigen::Isometry3d::Identity()).cloud.empty());
}

TEST(Renderer, NearestOfSeveralScenesWinsInAnyOrder) {
  const auto near = boxScene({10, 0, -1}, 2, kFirst), far = boxScene({20, 0, -4}, 8, kSecond);
  const Camera camera = pinholeCamera(32, 32, 1.2);
  const Frame a = Renderer({near, far}).renderCamera(camera, lookingEast({0, 0, 0}));
  const Frame b = Renderer({far, near}).renderCamera(camera, lookingEast({0, 0, 0}));
  EXPECT_EQ(a.depth.pixels, b.depth.pixels);
  EXPECT_EQ(a.label.pixels, b.label.pixels);
  EXPECT_EQ(a.label.at(16, 16), kFirst.label);
  EXPECT_EQ(a.label.at(8, 16), town_class::kSky);
  EXPECT_EQ(a.label.at(12, 16), kSecond.label);
}

TEST(Renderer, AgreesWithBruteForceOnRandomTriangles) {
  Random random(3);
  TriangleMesh mesh;
  for (int i = 0; i < 60; ++i) {
    Eigen::Vector3d corner[3];
    const Eigen::Vector3d center{random.uniform(4, 30), random.uniform(-15, 15),
                                 random.uniform(-15, 15)};
    for (auto& c : corner) {
      c = center + Eigen::Vector3d{random.normal(), random.normal(), random.normal()} * 3;
    }
    addTriangle(mesh, corner[0], corner[1], corner[2], {static_cast<std::uint16_t>(i + 1), 0});
  }
  const Camera camera = pinholeCamera(61, 47, 1.5);
  const Eigen::Isometry3d T = lookingEast({0.3, -0.2, 0.1});
  const Frame frame = Renderer({std::make_shared<const RayScene>(mesh)}).renderCamera(camera, T);
  int differing = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Tag tag{town_class::kSky, 0};
      const Eigen::Vector3d d =
          T.linear() * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const double z = bruteForce(mesh, T.translation(), d, &tag);
      differing += std::abs(z - frame.depth.at(x, y)) > 1e-3 || tag.label != frame.label.at(x, y);
    }
  }
  EXPECT_LE(differing, 2);  // single precision at the very edge of a triangle
}

class TownViews : public ::testing::Test {
 protected:
  TownViews() {
    TownOptions options;
    options.blocks_x = options.blocks_y = 2;
    const Town town = makeTown(options);
    const Polyline lane = shifted(planDrive(town.network, 60, 1), -1.4);
    poses_ = bodyPoses(lane, 2, Mount(), town.relief, 1);
    mesh_ = town.mesh;
    renderer_ = std::make_unique<Renderer>(
        std::vector<std::shared_ptr<const RayScene>>{std::make_shared<const RayScene>(town.mesh)});
  }
  std::vector<Eigen::Isometry3d> poses_;
  TriangleMesh mesh_;
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(TownViews, DoNotDependOnTheNumberOfThreads) {
  const Camera camera = pinholeCamera(160, 120, 1.5);
  const Frame one = renderer_->renderCamera(camera, opticalPose(poses_[5]), 1);
  const Frame two = renderer_->renderCamera(camera, opticalPose(poses_[5]), 2);
  EXPECT_EQ(one.depth.pixels, two.depth.pixels);
  EXPECT_EQ(one.label.pixels, two.label.pixels);
  EXPECT_EQ(one.instance.pixels, two.instance.pixels);
  const LidarModel lidar;
  const Frame scan = renderer_->renderLidar(lidar, poses_[5], 1);
  const Frame again = renderer_->renderLidar(lidar, poses_[5], 2);
  ASSERT_EQ(scan.cloud.size(), again.cloud.size());
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    ASSERT_EQ(scan.cloud.position(i), again.cloud.position(i));
    ASSERT_EQ(scan.cloud.points[i].label, again.cloud.points[i].label);
  }
}

TEST_F(TownViews, OfTheSamePointAgree) {
  const Camera camera = pinholeCamera(160, 120, 1.5);
  const Eigen::Isometry3d T_a = opticalPose(poses_[5]), T_b = opticalPose(poses_[8]);
  const Frame a = renderer_->renderCamera(camera, T_a), b = renderer_->renderCamera(camera, T_b);
  int seen = 0, hidden = 0, label_differs = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (a.depth.at(x, y) <= 0 || a.depth.at(x, y) > 40) continue;
      const Eigen::Vector3d p = T_b.inverse() * unprojected(a, T_a, x, y);
      if (p.z() < 1) continue;
      const int u = static_cast<int>(std::lround(p.x() / p.z() * camera.fx + camera.cx));
      const int v = static_cast<int>(std::lround(p.y() / p.z() * camera.fy + camera.cy));
      if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
      const double z = b.depth.at(u, v);
      ++seen;
      if (z < 0.93 * p.z() || z > 1.07 * p.z())
        ++hidden;
      else
        label_differs += a.label.at(x, y) != b.label.at(u, v);
    }
  }
  EXPECT_GT(seen, 2000);
  EXPECT_LT(hidden, 0.2 * seen);          // occlusions and edges
  EXPECT_LT(label_differs, 0.05 * seen);  // edges
}

TEST_F(TownViews, LidarPointsLieOnSurfacesOfTheirClass) {
  LidarModel lidar;
  lidar.rings = 8;
  lidar.azimuths = 24;
  const Frame scan = renderer_->renderLidar(lidar, poses_[10]);
  ASSERT_GT(scan.cloud.size(), 60u);
  const Eigen::Vector3d o = poses_[10].translation();
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Eigen::Vector3d p = scan.cloud.position(i);
    EXPECT_LE(p.norm(), lidar.max_range_m + 1e-3);
    Tag tag;
    const double range = bruteForce(mesh_, o, poses_[10].linear() * p.normalized(), &tag);
    EXPECT_NEAR(range, p.norm(), 0.01);
    EXPECT_EQ(tag.label, scan.cloud.points[i].label);
    EXPECT_EQ(tag.instance, scan.cloud.points[i].instance);
  }
}

TEST_F(TownViews, LidarAndCameraAgree) {
  const Camera camera = pinholeCamera(320, 240, 1.5);
  const Frame image = renderer_->renderCamera(camera, opticalPose(poses_[3]));
  const Frame scan = renderer_->renderLidar(LidarModel(), poses_[3]);
  int seen = 0, same = 0;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Eigen::Vector3d p = scan.cloud.position(i);  // x ahead, y left, z up
    if (p.x() < 1) continue;
    const int u = static_cast<int>(std::lround(-p.y() / p.x() * camera.fx + camera.cx));
    const int v = static_cast<int>(std::lround(-p.z() / p.x() * camera.fy + camera.cy));
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    ++seen;
    same += image.label.at(u, v) == scan.cloud.points[i].label;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(same, 0.93 * seen);
}

}  // namespace
}  // namespace xview
