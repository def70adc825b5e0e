// SPDX-License-Identifier: BSD-3-Clause
// Worlds of other_worlds as sensors of many makes measure them: beams, reach, noise and mounting
// are values of one table. A recording is a folder of scans with labels and poses, whichever sensor
// it is of, but from the air it is clouds. The frame of a sensor has x forward, y left and z up
// before it is mounted.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "recording.h"
#include "sensor.h"

namespace other_worlds {

namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Rays = Eigen::Matrix<float, Eigen::Dynamic, 3>;

constexpr double kDegree = kPi / 180;

enum class Pattern {
  rings,   // columns of beams, all around or in a sector
  random,  // directions of a sector that never repeat
  image    // pixels of a plane
};

struct Scanner {
  const char* name;
  Pattern pattern;
  int columns, rows;                     // of a random pattern their product counts
  double wide_deg, low_deg, high_deg;    // the sector
  double reach_m, noise_m, noise_per_m;  // noise of z m: noise_m + noise_per_m z^2
  double pitch_deg, roll_deg, above_m;  // mounting; above ground, 0 = at the world's height of eyes
  bool flies;
};

constexpr Scanner kScanners[] = {
    {"hdl64", Pattern::rings, 900, 64, 360, -24.8, 2, 100, 0.02, 0, 0, 0, 0, false},
    {"os1_128", Pattern::rings, 512, 128, 360, -22.5, 22.5, 90, 0.02, 0, 0, 0, 0, false},
    {"vlp16", Pattern::rings, 900, 16, 360, -15, 15, 80, 0.03, 0, 0, 0, 0, false},
    {"xt32", Pattern::rings, 1000, 32, 360, -16, 15, 100, 0.01, 0, 0, 0, 0, false},
    {"qt64", Pattern::rings, 450, 64, 360, -52, 52, 25, 0.03, 0, 0, 0, 0, false},
    {"avia", Pattern::random, 240, 100, 70, -38, 38, 120, 0.02, 0, 0, 0, 0, false},
    {"mid360", Pattern::random, 200, 100, 360, -7, 52, 50, 0.02, 0, 30, 0, 0, false},
    {"mid360_hanging", Pattern::random, 200, 100, 360, -7, 52, 50, 0.02, 0, 10, 180, 2.4, false},
    {"fmcw", Pattern::rings, 480, 64, 120, -15, 15, 120, 0.03, 0, 0, 0, 0, false},
    {"rgbd", Pattern::image, 160, 120, 80, -30, 30, 8, 0.002, 0.0015, 6, 0, 0, false},
    {"stereo", Pattern::image, 240, 120, 90, -27, 27, 35, 0.01, 0.002, 6, 0, 0, false},
    {"phone", Pattern::image, 48, 36, 60, -23, 23, 5, 0.01, 0.001, 10, 0, 0, false},
    {"airborne", Pattern::image, 360, 16, 50, -2, 2, 150, 0.05, 0, 90, 0, 90, true},
    {"photogrammetry", Pattern::image, 140, 110, 60, -24, 24, 150, 0.08, 0, 90, 0, 70, true},
};

Rays raysOf(const Scanner& scanner, Random& random) {
  const int count = scanner.columns * scanner.rows;
  Rays rays(count, 3);
  const double half = scanner.wide_deg / 2 * kDegree, low = scanner.low_deg * kDegree,
               high = scanner.high_deg * kDegree;
  for (int i = 0; i < count; ++i) {
    const int column = i % scanner.columns, row = i / scanner.columns;
    const double u = (column + 0.5) / scanner.columns, v = (row + 0.5) / scanner.rows;
    if (scanner.pattern == Pattern::image) {
      rays.row(i) = Eigen::Vector3f(1, float(std::tan(half) * (1 - 2 * u)),
                                    float(std::tan(high) + v * (std::tan(low) - std::tan(high))))
                        .normalized();
      continue;
    }
    const bool is_random = scanner.pattern == Pattern::random;
    const double azimuth = half * (1 - 2 * (is_random ? random.uniform(0, 1) : u)),
                 up = low + (high - low) * (is_random ? random.uniform(0, 1) : v);
    rays.row(i) << float(std::cos(azimuth) * std::cos(up)), float(std::sin(azimuth) * std::cos(up)),
        float(std::sin(up));
  }
  return rays;
}

struct Hits {
  std::vector<double> range;  // infinity where nothing is
  std::vector<int> label;
};

Hits castRays(const World& world, const Rays& rays, const Isometry3d& pose, double reach) {
  const auto count = size_t(rays.rows());
  Hits hits{std::vector<double>(count, std::numeric_limits<double>::infinity()),
            std::vector<int>(count, -1)};
  const Vector3d from = pose.translation();
  const Rays along = rays * pose.linear().cast<float>().transpose();
  const auto rayOf = [&](size_t i) -> Vector3d {
    return along.row(long(i)).transpose().cast<double>();
  };
  for (size_t i = 0; i < count; ++i) {
    const Vector3d ray = rayOf(i);
    const double t = distanceToGround(world, from, ray, reach);
    if (t < 0 || t > reach) continue;
    hits.range[i] = t;
    hits.label[i] = world.ground(from.x() + t * ray.x(), from.y() + t * ray.y());
  }
  Eigen::VectorXf cosines(rays.rows());
  for (const Thing& thing : world.things) {
    const Vector3d way = thing.center - from;
    const double radius = thing.half.norm(), away = way.norm();
    if (away > reach + radius) continue;
    const double least = away > radius ? std::sqrt(1 - radius * radius / (away * away)) : -2;
    cosines.noalias() = along * (way / std::max(away, 1e-9)).cast<float>();
    const Thing::Turn turned(thing);
    for (size_t i = 0; i < count; ++i) {
      if (cosines[long(i)] < least - 1e-4) continue;
      const double t = thing.hit(from, rayOf(i), turned);
      if (t < hits.range[i]) hits.range[i] = t, hits.label[i] = thing.label;
    }
  }
  return hits;
}

/// Where the sensor is and where it heads: along the way, or to and fro over the place.
std::vector<std::pair<Vector2d, double>> track(const World& world, const Scanner& scanner,
                                               bool mapping) {
  std::vector<Vector2d> corners = world.route;
  if (scanner.flies) {
    Eigen::AlignedBox2d box;
    for (const Vector2d& corner : world.route) box.extend(corner);
    const double spacing = mapping ? 25 : 40;
    corners.clear();
    for (double y = box.min().y() - 10; y < box.max().y() + spacing; y += spacing) {
      const bool back = corners.size() % 4 == 2;
      corners.emplace_back(back ? box.max().x() + 20 : box.min().x() - 20, y);
      corners.emplace_back(back ? box.min().x() - 20 : box.max().x() + 20, y);
    }
  }
  if (!mapping) std::reverse(corners.begin(), corners.end());
  const double usual = scanner.flies ? 6 : world.step_m;
  const double step = std::min(usual, scanner.reach_m / 15),
               aside = mapping || world.roofed ? 0 : 0.6;
  std::vector<std::pair<Vector2d, double>> places;
  double next = 0, walked = 0;
  for (size_t leg = 0; leg + 1 < corners.size(); ++leg) {
    const Vector2d way = corners[leg + 1] - corners[leg], ahead = way.normalized();
    for (; next <= walked + way.norm(); next += step)
      places.emplace_back(
          corners[leg] + (next - walked) * ahead + aside * Vector2d(-ahead.y(), ahead.x()),
          std::atan2(ahead.y(), ahead.x()));
    walked += way.norm();
  }
  return places;
}

/// One in ten patches of what a sensor sees is of another class, as a network says it.
class Mislabelled {
 public:
  explicit Mislabelled(int classes) : classes_(classes) {}
  int labelOf(const Eigen::Vector3f& ray, int label, Random& random) {
    constexpr float kPatch_deg = 4;
    const auto bin = [](float radians) {
      return int(std::floor(radians / float(kDegree) / kPatch_deg));
    };
    const auto [patch, is_new] =
        label_of_.try_emplace({bin(std::atan2(ray.y(), ray.x())), bin(std::asin(ray.z()))}, -1);
    if (is_new && random.chance(0.1)) patch->second = random.below(classes_);
    return patch->second < 0 ? label : patch->second;
  }

 private:
  int classes_;
  std::map<std::pair<int, int>, int> label_of_;  ///< -1: as it is
};

/// A point of a cloud, and what it is of.
struct Labelled {
  Vector3d p;
  std::uint32_t label;
};

void writePly(const std::filesystem::path& path, const std::vector<Labelled>& points,
              const Isometry3d& T_cloud_world) {
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty uint label\n"
         "end_header\n";
  for (const Labelled& point : points) {
    const Eigen::Vector3f p = (T_cloud_world * point.p).cast<float>();
    out.write(reinterpret_cast<const char*>(p.data()), 12);
    out.write(reinterpret_cast<const char*>(&point.label), 4);
  }
}

/// What was seen from the air is one cloud, and queries are discs of it around places of the way,
/// each in a frame of its own.
void writeClouds(const World& world, bool mapping, const std::vector<Labelled>& points,
                 const std::filesystem::path& folder, Random& random) {
  constexpr double kRadius_m = 30;
  constexpr size_t kDiscs = 8;
  if (mapping) return writePly(folder / "cloud.ply", points, Isometry3d::Identity());
  std::ofstream truth(folder / "groundtruth.txt");
  for (size_t k = 0; k < kDiscs; ++k) {
    const Vector2d at = world.route[(2 * k + 1) * (world.route.size() - 1) / (2 * kDiscs)];
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() << at, world.height(at.x(), at.y());
    pose.linear() = AngleAxisd(random.uniform(-kPi, kPi), Vector3d::UnitZ()).toRotationMatrix();
    std::vector<Labelled> disc;
    for (const Labelled& point : points) {
      if ((point.p.head<2>() - at).norm() < kRadius_m) disc.push_back(point);
    }
    char name[32];
    std::snprintf(name, sizeof name, "disc_%zu.ply", k);
    writePly(folder / name, disc, pose.inverse());
    writePose(truth, pose);
  }
}

void record(const World& world, const Scanner& scanner, bool mapping,
            const std::filesystem::path& folder, Random random) {
  namespace fs = std::filesystem;
  for (const char* part : {"velodyne", "labels"}) fs::create_directories(folder / part);
  std::ofstream(folder / "calib.txt") << "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";
  std::ofstream poses(folder / "poses.txt"), truth(folder / "groundtruth.txt");
  writeClasses(world, folder);
  const Eigen::Quaterniond mount = AngleAxisd(scanner.pitch_deg * kDegree, Vector3d::UnitY()) *
                                   AngleAxisd(scanner.roll_deg * kDegree, Vector3d::UnitX());
  const double scale = 1 + (mapping ? 0 : 0.005 * random.normal()),
               turn = mapping ? 0 : 0.0004 * random.normal();
  Isometry3d odometry = Isometry3d::Identity(), before = Isometry3d::Identity();
  std::vector<Labelled> from_the_air;
  int frame = 0;
  for (const auto& [at, heading] : track(world, scanner, mapping)) {
    Isometry3d pose = Isometry3d::Identity();
    const double above = scanner.above_m > 0 && !(world.roofed && scanner.above_m > 2.2)
                             ? scanner.above_m
                             : world.eye_m;
    pose.translation() << at, world.height(at.x(), at.y()) + above;
    pose.linear() = (AngleAxisd(heading, Vector3d::UnitZ()) * mount *
                     AngleAxisd(0.01 * random.normal(), Vector3d::UnitY()))
                        .toRotationMatrix();
    // The odometry of a query begins with the identity, however its sensor is mounted.
    if (frame) odometry = odometry * drifted(before.inverse() * pose, pose, scale, turn);
    before = pose;
    writePose(poses, mapping ? pose : odometry);
    writePose(truth, pose);

    const Rays rays = raysOf(scanner, random);
    Mislabelled mislabelled(int(world.classes.size()));
    const Hits hits = castRays(world, rays, pose, scanner.reach_m);
    char name[32];
    std::snprintf(name, sizeof name, "%06d.bin", frame);
    std::ofstream points(folder / "velodyne" / name, std::ios::binary);
    std::snprintf(name, sizeof name, "%06d.label", frame++);
    std::ofstream labels(folder / "labels" / name, std::ios::binary);
    for (size_t i = 0; i < hits.range.size(); ++i) {
      if (hits.range[i] > scanner.reach_m) continue;
      const double sigma = scanner.noise_m + scanner.noise_per_m * hits.range[i] * hits.range[i];
      const double range = hits.range[i] + sigma * random.normal();
      Eigen::Vector4f point = Eigen::Vector4f::Zero();
      point.head<3>() = float(range) * rays.row(long(i)).transpose();
      const int label = mislabelled.labelOf(rays.row(long(i)), hits.label[i], random);
      const auto written = uint32_t(label + 1);
      if (scanner.flies) {
        from_the_air.push_back({pose * point.head<3>().cast<double>(), written});
        continue;
      }
      points.write(reinterpret_cast<const char*>(point.data()), sizeof point);
      labels.write(reinterpret_cast<const char*>(&written), sizeof written);
    }
  }
  if (!scanner.flies) return;
  truth.close();
  for (const char* part : {"velodyne", "labels"}) fs::remove_all(folder / part);
  for (const char* file : {"poses.txt", "calib.txt"}) fs::remove(folder / file);
  writeClouds(world, mapping, from_the_air, folder, random);
}

}  // namespace
}  // namespace other_worlds

int main(int argc, char** argv) {
  using namespace other_worlds;
  const auto scanner =
      std::find_if(std::begin(kScanners), std::end(kScanners),
                   [&](const Scanner& s) { return argc > 4 && std::string(argv[4]) == s.name; });
  if (argc != 5 || !styles().count(argv[1]) || scanner == std::end(kScanners)) {
    std::fprintf(stderr, "usage: scanners STYLE SEED OUT_DIR SENSOR\nsensors:");
    for (const Scanner& known : kScanners) std::fprintf(stderr, " %s", known.name);
    std::fprintf(stderr, "\n");
    return 2;
  }
  Random random{std::mt19937_64(std::stoull(argv[2]))};
  const World world = styles().at(argv[1])(random);
  for (const bool mapping : {true, false})
    record(world, *scanner, mapping, std::filesystem::path(argv[3]) / (mapping ? "map" : "query"),
           Random{std::mt19937_64(random.bits())});
}
