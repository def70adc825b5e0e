// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensor_noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"
#include "furniture.h"
#include "sim/town.h"

namespace xview {
namespace {

/// Smooth random numbers in [0, 1) over space: hashed lattice values, interpolated. Around 0.5,
/// standard deviation 0.2.
class ValueNoise {
 public:
  explicit ValueNoise(std::uint64_t seed) : seed_(seed) {}

  double at(double x, double y, double z) const {
    const double fx = std::floor(x), fy = std::floor(y), fz = std::floor(z);
    const double u = ease(x - fx), v = ease(y - fy), w = ease(z - fz);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const auto iz = static_cast<std::int64_t>(fz);
    const double low = plane(ix, iy, iz, u, v);
    return w == 0 ? low : low + w * (plane(ix, iy, iz + 1, u, v) - low);
  }

  /// Uniform, and the same in the whole unit cell around p.
  double ofCell(const Eigen::Vector3d& p) const {
    return lattice(static_cast<std::int64_t>(std::floor(p.x())),
                   static_cast<std::int64_t>(std::floor(p.y())),
                   static_cast<std::int64_t>(std::floor(p.z())));
  }

 private:
  static double ease(double t) { return t * t * (3 - 2 * t); }

  double plane(std::int64_t x, std::int64_t y, std::int64_t z, double u, double v) const {
    const double a = lattice(x, y, z), b = lattice(x + 1, y, z);
    const double c = lattice(x, y + 1, z), d = lattice(x + 1, y + 1, z);
    return (a + u * (b - a)) * (1 - v) + (c + u * (d - c)) * v;
  }

  double lattice(std::int64_t x, std::int64_t y, std::int64_t z) const {
    std::uint64_t h = seed_ + static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ull +
                      static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4Full +
                      static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ull;
    h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
    h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
    return static_cast<double>((h ^ (h >> 32)) >> 11) * (1.0 / 9007199254740992.0);
  }

  std::uint64_t seed_;
};

/// What a network takes a class for, and how easily.
struct Confusion {
  std::uint16_t label;
  double weight;
};

struct ClassErrors {
  double difficulty = 0;  ///< added to the error field
  std::vector<Confusion> confusions;
};

using ErrorTable = std::array<ClassErrors, office_class::kPerson + 1>;

/// Modelled on confusion matrices of street-scene networks: ground classes with one another,
/// facades with fences and trees, thin things with what lies behind.
void addStreetErrors(ErrorTable& t) {
  using namespace town_class;
  t[kSky] = {-0.2, {{kVegetation, 2}, {kBuilding, 1}}};
  t[kBuilding] = {0, {{kVegetation, 4}, {kFence, 3}, {kSky, 1}, {kTerrain, 0.5}}};
  t[kRoad] = {-0.015, {{kSidewalk, 6}, {kTerrain, 0.6}, {kLaneMarking, 0.2}}};
  t[kSidewalk] = {0.03, {{kRoad, 5}, {kTerrain, 3}}};
  t[kFence] = {0.1, {{kBuilding, 4}, {kVegetation, 3}, {kTerrain, 1}}};
  t[kVegetation] = {0.03, {{kTerrain, 3}, {kBuilding, 2.5}, {kFence, 1}, {kSky, 0.4}}};
  t[kPole] = {0.06, {{kBuilding, 2}, {kVegetation, 2}, {kSky, 1}, {kFence, 1}}};
  t[kCar] = {-0.03, {{kFence, 2}, {kBuilding, 2}, {kRoad, 1}, {kVegetation, 1}}};
  t[kTrafficSign] = {0, {{kBuilding, 3}, {kVegetation, 2}, {kPole, 2}}};
  t[kPedestrian] = {0, {{kVegetation, 2}, {kPole, 1}, {kBuilding, 1}, {kSidewalk, 1}}};
  t[kBicycle] = {0.12, {{kPedestrian, 3}, {kCar, 1}, {kFence, 1}, {kTerrain, 1}}};
  t[kLaneMarking] = {0.08, {{kRoad, 8}, {kSidewalk, 1}}};
  t[kTrafficLight] = {0, {{kPole, 2}, {kVegetation, 2}, {kBuilding, 1}}};
  t[kHedge] = {0.03, {{kVegetation, 6}, {kTerrain, 2}, {kFence, 2}}};
  t[kTerrain] = {0.02, {{kVegetation, 6}, {kSidewalk, 2}, {kRoad, 0.5}}};
}

/// And of networks for indoor scenes: furniture with other furniture, flat things with the wall
/// that they hang on.
void addRoomErrors(ErrorTable& t) {
  using namespace office_class;
  t[kWallClass] = {0, {{kCabinet, 2}, {kDoor, 2}, {kWindow, 1}, {kPillar, 1}, {kWhiteboard, 1}}};
  t[kFloor] = {-0.03, {{kTable, 1}, {kBox, 1}, {kCabinet, 1}}};
  t[kCeiling] = {-0.02, {{kWallClass, 3}, {kLamp, 1}}};
  t[kDoor] = {0.04, {{kWallClass, 3}, {kCabinet, 2}, {kWindow, 1}}};
  t[kWindow] = {0.03, {{kWallClass, 2}, {kWhiteboard, 2}, {kPicture, 1}, {kDoor, 1}}};
  t[kCabinet] = {0.05, {{kBookshelf, 2}, {kWallClass, 2}, {kWritingDesk, 1}, {kDoor, 1}}};
  t[kBookshelf] = {0.05, {{kCabinet, 4}, {kWallClass, 1}}};
  t[kWritingDesk] = {0.06, {{kTable, 4}, {kCabinet, 2}, {kFloor, 1}}};
  t[kTable] = {0.06, {{kWritingDesk, 4}, {kCabinet, 1}, {kFloor, 1}}};
  t[kChair] = {0, {{kSofa, 2}, {kWritingDesk, 1}, {kBox, 1}}};
  t[kSofa] = {0.02, {{kChair, 3}, {kCabinet, 1}}};
  t[kWhiteboard] = {0.05, {{kWallClass, 3}, {kPicture, 2}, {kWindow, 2}}};
  t[kPicture] = {0.06, {{kWallClass, 4}, {kWhiteboard, 2}}};
  t[kMonitor] = {0.03, {{kPicture, 1}, {kWritingDesk, 2}, {kBox, 1}}};
  t[kLamp] = {0.04, {{kCeiling, 4}}};
  t[kRadiator] = {0.07, {{kWallClass, 3}, {kCabinet, 1}}};
  t[kPlant] = {0.02, {{kWallClass, 1}, {kChair, 1}}};
  t[kTrashBin] = {0.05, {{kBox, 2}, {kCabinet, 1}, {kFloor, 1}}};
  t[kExtinguisher] = {0.06, {{kWallClass, 2}, {kTrashBin, 1}}};
  t[kPillar] = {0.07, {{kWallClass, 5}, {kCabinet, 1}}};
  t[kCurtain] = {0.06, {{kWindow, 2}, {kWallClass, 2}}};
  t[kBox] = {0.08, {{kCabinet, 1}, {kBag, 2}, {kTrashBin, 1}}};
  t[kBag] = {0.08, {{kBox, 3}, {kChair, 1}}};
  t[kPerson] = {0, {{kChair, 1}, {kWallClass, 1}}};
}

/// Indexed by class.
const ErrorTable& classErrors() {
  static const ErrorTable table = [] {
    ErrorTable t;
    addStreetErrors(t);
    addRoomErrors(t);
    return t;
  }();
  return table;
}

bool hasErrors(std::uint32_t label) {
  return label < classErrors().size() && !classErrors()[label].confusions.empty();
}

double difficultyOf(std::uint32_t label) { return classErrors()[label].difficulty; }

/// The wrong label that `choice` in [0, 1) selects; only for classes with errors.
std::uint16_t confusedLabel(std::uint32_t label, double choice) {
  const std::vector<Confusion>& confusions = classErrors()[label].confusions;
  double left = 0;
  for (const Confusion& c : confusions) left += c.weight;
  left *= choice;
  for (const Confusion& c : confusions) {
    left -= c.weight;
    if (left < 0) return c.label;
  }
  return confusions.back().label;
}

std::uint64_t frameSeed(std::uint64_t seed, const Frame& frame, std::uint64_t purpose) {
  return Random(seed ^ purpose, static_cast<std::uint64_t>(frame.number)).next();
}

/// Where errors are likely, and of which kind: both vary slowly over the image and over the world.
class ErrorField {
 public:
  ErrorField(std::uint64_t recording_seed, std::uint64_t frame_seed, double persistence,
             double patch_m)
      : world_(recording_seed ^ 0x57),
        image_(frame_seed ^ 0x49),
        persistence_(persistence),
        patch_m_(patch_m) {}

  /// World position in metres, image position in units of 1/320 of the image's width.
  double strength(const Eigen::Vector3d& p, double x, double y) const {
    constexpr double kCoarse = 26, kFine = 7;
    const Eigen::Vector3d q = p / patch_m_;
    const double in_world = world_.at(q.x(), q.y(), q.z());
    const double in_image =
        0.65 * image_.at(x / kCoarse, y / kCoarse, 0) + 0.35 * image_.at(x / kFine, y / kFine, 7);
    return persistence_ * in_world + (1 - persistence_) * in_image;
  }

  /// In [0, 1), uniform and the same all over an irregular patch.
  double kind(const Eigen::Vector3d& p, double x, double y) const {
    constexpr double kImageScale = 40;
    const double in_world = patch(world_, p / (patch_m_ * 4 / 3));
    const bool sticks = 7 * in_world - std::floor(7 * in_world) < persistence_;
    return sticks ? in_world : patch(image_, Eigen::Vector3d(x, y, 0) / kImageScale);
  }

 private:
  /// Cells of a lattice with crooked walls.
  static double patch(const ValueNoise& noise, const Eigen::Vector3d& p) {
    const double bend = 2 * noise.at(2 * p.x(), 2 * p.y(), 2 * p.z() + 100);
    return noise.ofCell(p + Eigen::Vector3d(bend, 1.5 - bend, bend));
  }

  ValueNoise world_, image_;
  double persistence_, patch_m_;
};

/// Labels looked up a few pixels away, by a smooth random displacement: boundaries wobble, thin
/// things break.
LabelImage wobbled(const LabelImage& label, double amplitude_px, std::uint64_t seed) {
  const ValueNoise dx(seed ^ 0x78), dy(seed ^ 0x79);
  const double scale = 9.0 * label.width / 320;
  LabelImage result = label;
  for (int y = 0; y < label.height; ++y) {
    for (int x = 0; x < label.width; ++x) {
      const double sx = 2 * amplitude_px * (dx.at(x / scale, y / scale, 0) - 0.5);
      const double sy = 2 * amplitude_px * (dy.at(x / scale, y / scale, 0) - 0.5);
      const int from_x = std::clamp(x + static_cast<int>(std::lround(sx)), 0, label.width - 1);
      const int from_y = std::clamp(y + static_cast<int>(std::lround(sy)), 0, label.height - 1);
      result.at(x, y) = label.at(from_x, from_y);
    }
  }
  return result;
}

std::size_t differences(const LabelImage& a, const LabelImage& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) count += a.pixels[i] != b.pixels[i];
  return count;
}

/// Wobbled as much as the number of wrong pixels allows: boundaries make at most 40 % of the
/// errors.
LabelImage wobbledWithin(const LabelImage& label, std::size_t wrong_pixels, std::uint64_t seed) {
  for (double amplitude = 3.0 * label.width / 320; amplitude > 0.5; amplitude *= 0.7) {
    LabelImage result = wobbled(label, amplitude, seed);
    if (differences(label, result) <= 0.4 * static_cast<double>(wrong_pixels)) return result;
  }
  return label;
}

struct Candidate {
  float strength;
  std::uint32_t index;  ///< of a pixel or point
  bool operator<(const Candidate& other) const {
    return strength != other.strength ? strength > other.strength : index < other.index;
  }
};

Eigen::Vector3d pointOf(const Frame& frame, int x, int y) {
  return frame.T_odom_sensor * frame.camera.unproject(x, y, frame.depth.at(x, y));
}

double wantedAccuracy(const LabelNoise& noise, std::uint64_t seed) {
  if (noise.accuracy >= 1) return 1;
  return std::clamp(noise.accuracy + noise.variation * Random(seed).normal(), 0.0, 1.0);
}

/// The `count` most error-prone candidates, in no particular order.
void keepMostErrorProne(std::vector<Candidate>& candidates, std::size_t count) {
  if (count >= candidates.size()) return;
  std::nth_element(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                   candidates.end());
  candidates.resize(count);
}

/// Largest value in a square around the pixel.
float largestAround(const DepthImage& image, int x, int y, int radius) {
  float largest = image.at(x, y);
  for (int v = std::max(0, y - radius); v <= std::min(image.height - 1, y + radius); ++v) {
    for (int u = std::max(0, x - radius); u <= std::min(image.width - 1, x + radius); ++u) {
      largest = std::max(largest, image.at(u, v));
    }
  }
  return largest;
}

/// This share of a small motion.
Eigen::Isometry3d partOf(const Eigen::Isometry3d& motion, double share) {
  const Eigen::AngleAxisd turn(motion.linear());
  Eigen::Isometry3d part(Eigen::AngleAxisd(share * turn.angle(), turn.axis()));
  part.translation() = share * motion.translation();
  return part;
}

/// fx * baseline / depth [pixels]; 0 where there is no depth.
DepthImage disparityOf(const DepthImage& depth, double focal_baseline) {
  DepthImage disparity = depth;
  for (float& value : disparity.pixels) {
    value = value > 0 ? static_cast<float>(focal_baseline / value) : 0.0f;
  }
  return disparity;
}

}  // namespace

Frame withLabelNoise(Frame frame, const LabelNoise& noise, std::uint64_t seed) {
  const LabelImage truth = frame.label;
  const std::uint64_t frame_seed = frameSeed(seed, frame, 0x4C42);
  const double share = 1 - wantedAccuracy(noise, frame_seed);
  const auto wrong = static_cast<std::size_t>(share * static_cast<double>(truth.pixels.size()));
  if (wrong == 0) return frame;
  frame.label = wobbledWithin(truth, wrong, frame_seed);

  const ErrorField field(seed, frame_seed, noise.persistence, noise.patch_m);
  const double unit = 320.0 / truth.width;
  std::vector<Candidate> candidates;
  std::size_t already_wrong = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      const std::uint16_t label = truth.at(x, y);
      const auto index = static_cast<std::uint32_t>(y * truth.width + x);
      if (frame.label.pixels[index] != label) {
        ++already_wrong;
      } else if (hasErrors(label)) {
        const double strength = field.strength(pointOf(frame, x, y), x * unit, y * unit);
        candidates.push_back({static_cast<float>(strength + difficultyOf(label)), index});
      }
    }
  }
  keepMostErrorProne(candidates, wrong - std::min(wrong, already_wrong));
  for (const Candidate& candidate : candidates) {
    const int x = static_cast<int>(candidate.index) % truth.width;
    const int y = static_cast<int>(candidate.index) / truth.width;
    frame.label.at(x, y) =
        confusedLabel(truth.at(x, y), field.kind(pointOf(frame, x, y), x * unit, y * unit));
  }
  for (std::size_t i = 0; i < frame.instance.pixels.size(); ++i) {
    if (frame.label.pixels[i] != truth.pixels[i]) frame.instance.pixels[i] = 0;
  }
  return frame;
}

Frame withDepthNoise(Frame frame, const DepthNoise& noise, std::uint64_t seed) {
  constexpr float kEdge = 1;  // a step of more is an edge, less may be a slanted surface [pixels]
  const double focal_baseline = frame.camera.fx * noise.baseline_m;
  const double smallest = focal_baseline / noise.max_range_m;
  const DepthImage truth = disparityOf(frame.depth, focal_baseline);
  const std::uint64_t frame_seed = frameSeed(seed, frame, 0x4450);
  const ValueNoise bleeding(frame_seed ^ 0x42), patches(frame_seed ^ 0x50);
  for (int y = 0; y < truth.height; ++y) {
    Random random(frame_seed, static_cast<std::uint64_t>(y));
    for (int x = 0; x < truth.width; ++x) {
      const double lost = random.uniform(), error = random.normal();
      float disparity = truth.at(x, y);
      frame.depth.at(x, y) = 0;
      if (disparity <= 0) continue;
      const double grow = 2 * noise.bleeding_px * bleeding.at(x / 5.0, y / 5.0, 0);
      const float near = largestAround(truth, x, y, static_cast<int>(grow));
      const bool at_edge = near > disparity + kEdge;
      if (at_edge) disparity = near;
      if (lost < noise.invalid_share * (at_edge ? 4 : 0.8)) continue;
      // Block matching: neighbouring pixels share a part of the error.
      const double shared = 5 * (patches.at(x / 6.0, y / 6.0, 0) - 0.5);
      const double measured = disparity + noise.disparity_sigma_px * (0.9 * error + 0.45 * shared);
      if (measured < smallest) continue;
      frame.depth.at(x, y) = static_cast<float>(focal_baseline / measured);
    }
  }
  return frame;
}

Frame withLidarNoise(Frame frame, const LidarNoise& noise, std::uint64_t seed) {
  const LabelledCloud truth = frame.cloud;
  const std::uint64_t frame_seed = frameSeed(seed, frame, 0x4C49);
  const ErrorField field(seed, frame_seed, 1, LabelNoise().patch_m);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::uint32_t label = truth.points[i].label;
    if (!hasErrors(label)) continue;
    const double strength = field.strength(frame.T_odom_sensor * truth.position(i), 0, 0);
    candidates.push_back(
        {static_cast<float>(strength + difficultyOf(label)), static_cast<std::uint32_t>(i)});
  }
  const double wrong = (1 - noise.label_accuracy) * static_cast<double>(truth.size());
  keepMostErrorProne(candidates, static_cast<std::size_t>(wrong));
  std::vector<std::uint32_t> label(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) label[i] = truth.points[i].label;
  for (const Candidate& c : candidates) {
    label[c.index] = confusedLabel(label[c.index],
                                   field.kind(frame.T_odom_sensor * truth.position(c.index), 0, 0));
  }

  frame.cloud.points.clear();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    Random random(frame_seed, i);
    const double range = truth.points[i].getVector3fMap().norm(),
                 error = noise.range_sigma_m * random.normal();
    if (random.uniform() < noise.dropout_share || range + error <= 0.1) continue;
    Point point = truth.points[i];
    point.getVector3fMap() *= static_cast<float>((range + error) / range);
    if (point.label != label[i]) point.instance = 0;
    point.label = label[i];
    frame.cloud.points.push_back(point);
  }
  return frame;
}

Frame withOwnMotion(Frame frame, const Eigen::Isometry3d& step, double share) {
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    auto point = frame.cloud.points[i].getVector3fMap();
    const double turns = std::atan2(point.y(), point.x()) / (2 * M_PI);
    const Eigen::Vector3d p = partOf(step, share * turns).inverse() * point.cast<double>();
    point = p.cast<float>();
  }
  return frame;
}

}  // namespace xview
