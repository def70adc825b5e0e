// SPDX-License-Identifier: BSD-3-Clause
// Worlds of another make than those of `xview simulate`, with which they share no code: boxes,
// cylinders and ellipsoids on a height field, cast into depth and label images and scans. Their
// classes have names of their own and no roles. `bench/verdict_table.py` localizes in them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/imgcodecs.hpp>

#include "recording.h"
#include "sensor.h"

namespace other_worlds {
namespace {

using Eigen::Isometry3d;

struct Session {
  std::string name;
  bool scanner;
  double yaw_deg, down_deg;  // of the view against the way
  double above_m, aside_m;   // above ground, 0 = at the world's height of eyes; to the left
  bool backwards, mapping;
};

void record(const World& world, const Session& session, const std::filesystem::path& folder,
            Random random) {
  namespace fs = std::filesystem;
  const Sensor sensor = session.scanner ? Sensor{true, 640, 32, 0} : Sensor{false, 320, 220, 170};
  for (const char* part :
       {session.scanner ? "velodyne" : "depth", session.scanner ? "labels" : "label"})
    fs::create_directories(folder / part);
  if (session.scanner) {
    std::ofstream(folder / "calib.txt") << "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";
  } else {
    std::ofstream(folder / "camera.yaml")
        << "width: 320\nheight: 220\nfx: 170\nfy: 170\ncx: 159.5\ncy: 109.5\ndepth_scale: 0.001\n";
  }
  std::ofstream poses(folder / "poses.txt"), truth(folder / "groundtruth.txt");
  writeClasses(world, folder);

  std::vector<Vector2d> route = world.route;
  if (session.backwards) std::reverse(route.begin(), route.end());
  const double reach = std::max(world.range_m, session.above_m * 3);
  Isometry3d odometry = Isometry3d::Identity(), before = Isometry3d::Identity();
  const double scale = 1 + (session.mapping ? 0 : 0.01 * random.normal()),
               turn = session.mapping ? 0 : 0.0004 * random.normal();
  double walked = 0, next = 0;
  int frame = 0;
  for (size_t leg = 0; leg + 1 < route.size(); ++leg) {
    const Vector2d way = route[leg + 1] - route[leg], ahead = way.normalized();
    for (; next <= walked + way.norm(); next += world.step_m, ++frame) {
      const Vector2d at =
          route[leg] + (next - walked) * ahead + session.aside_m * Vector2d(-ahead.y(), ahead.x());
      const double heading = std::atan2(ahead.y(), ahead.x()) + session.yaw_deg * kPi / 180,
                   down = session.down_deg * kPi / 180;
      const Vector3d z(std::cos(heading) * std::cos(down), std::sin(heading) * std::cos(down),
                       -std::sin(down));
      const Vector3d x(std::sin(heading), -std::cos(heading), 0);
      Isometry3d pose = Isometry3d::Identity();
      if (session.scanner) {
        pose.linear() << z, -x, z.cross(-x);
      } else {
        pose.linear() << x, z.cross(x), z;
      }
      pose.linear() =
          pose.linear() *
          Eigen::AngleAxisd(0.01 * random.normal(), Vector3d::UnitZ()).toRotationMatrix();
      pose.translation() << at,
          world.height(at.x(), at.y()) + (session.above_m > 0 ? session.above_m : world.eye_m);

      View view = cast(world, sensor, pose, reach);
      mislabel(view, sensor, int(world.classes.size()), session.mapping ? 0.08 : 0.12, random);
      if (frame) {
        odometry = odometry * drifted(before.inverse() * pose, pose, scale, turn * world.step_m);
      } else {
        odometry = pose;
        if (!session.mapping)
          odometry = Isometry3d(Eigen::Translation3d(500, 300, 0) *
                                Eigen::AngleAxisd(1.1, Vector3d::UnitZ())) *
                     pose;
      }
      before = pose;
      writePose(poses, session.mapping ? pose : odometry);
      writePose(truth, pose);

      char name[32];
      if (session.scanner) {
        std::snprintf(name, sizeof name, "%06d.bin", frame);
        std::ofstream points(folder / "velodyne" / name, std::ios::binary);
        std::snprintf(name, sizeof name, "%06d.label", frame);
        std::ofstream labels(folder / "labels" / name, std::ios::binary);
        for (size_t i = 0; i < view.range.size(); ++i) {
          if (view.range[i] > reach) continue;
          const Vector3d hit = (view.range[i] + 0.02 * random.normal()) *
                               sensor.ray(int(i) % sensor.width, int(i) / sensor.width);
          const Eigen::Vector4f point(float(hit.x()), float(hit.y()), float(hit.z()), 0);
          const auto label = uint32_t(view.label[i] + 1);
          points.write(reinterpret_cast<const char*>(point.data()), sizeof point);
          labels.write(reinterpret_cast<const char*>(&label), sizeof label);
        }
        continue;
      }
      cv::Mat depth(sensor.height, sensor.width, CV_16U, cv::Scalar(0)),
          label(sensor.height, sensor.width, CV_8U, cv::Scalar(0));
      for (size_t i = 0; i < view.range.size(); ++i) {
        if (view.range[i] > reach) continue;
        const int u = int(i) % sensor.width, v = int(i) / sensor.width;
        double z_m = view.range[i] * sensor.ray(u, v).z();
        z_m += world.noise * z_m * z_m * random.normal();
        depth.at<uint16_t>(v, u) = uint16_t(std::clamp(z_m * 1000, 0.0, 65535.0));
        label.at<uint8_t>(v, u) = uint8_t(view.label[i] + 1);
      }
      std::snprintf(name, sizeof name, "%06d.png", frame);
      const std::vector<int> fast{cv::IMWRITE_PNG_COMPRESSION, 1};
      cv::imwrite((folder / "depth" / name).string(), depth, fast);
      cv::imwrite((folder / "label" / name).string(), label, fast);
    }
    walked += way.norm();
  }
}

}  // namespace
}  // namespace other_worlds

int main(int argc, char** argv) {
  using namespace other_worlds;
  if (argc < 4 || !styles().count(argv[1])) {
    std::fprintf(stderr,
                 "usage: other_worlds forest|oldtown|motorway|village_slope|carpark|warehouse|home "
                 "SEED OUT_DIR [SESSION...]\n");
    return 2;
  }
  Random random{std::mt19937_64(std::stoull(argv[2]))};
  const World world = styles().at(argv[1])(random);
  const bool indoors = world.roofed, small = world.step_m < 0.5;
  std::vector<Session> sessions{{"forward", false, 0, 6, 0, 0, false, true},
                                {"rear", false, 180, 6, 0, small ? 0.1 : 0.3, false, false},
                                {"oblique", false, 55, 6, 0, small ? -0.1 : -0.3, false, false}};
  if (!indoors) sessions.push_back({"aerial", false, 20, 60, 25, 2, false, false});
  if (!small) {
    sessions.push_back({"lidar", true, 0, 0, 0, 0, false, true});
    sessions.push_back({"lidar_reverse", true, 0, 0, 0, 0.4, true, false});
  }
  const std::vector<std::string> wanted(argv + 4, argv + argc);  // none = all of them
  for (const Session& session : sessions) {
    Random of_session{std::mt19937_64(random.bits())};
    if (wanted.empty() || std::count(wanted.begin(), wanted.end(), session.name) > 0)
      record(world, session, std::filesystem::path(argv[3]) / session.name, of_session);
  }
}
