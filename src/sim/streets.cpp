// SPDX-License-Identifier: BSD-3-Clause
#include "sim/streets.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace xview {
namespace {

constexpr double kCentreLineStep = 2;  // between points of a centre line [m]
constexpr double kBin = 8;             // [m]
constexpr double kReach = 24;          // > widest street + StreetField::kFar [m]
constexpr double kFillet = 3;          // range of the smooth minimum at corners [m]
constexpr double kTurningRoad = 8;     // radius of the disc at the end of a cul-de-sac [m]

/// Cubic Hermite curve with its tangents turned off the chord by the two angles.
Polyline bentLine(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double turn_a,
                  double turn_b) {
  const Eigen::Vector2d chord = b - a;
  const Eigen::Vector2d tangent_a = Eigen::Rotation2Dd(turn_a) * chord;
  const Eigen::Vector2d tangent_b = Eigen::Rotation2Dd(turn_b) * chord;
  const int steps = std::max(2, static_cast<int>(std::ceil(chord.norm() / kCentreLineStep)));
  Polyline line;
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps, t2 = t * t, t3 = t2 * t;
    line.push_back((2 * t3 - 3 * t2 + 1) * a + (t3 - 2 * t2 + t) * tangent_a +
                   (3 * t2 - 2 * t3) * b + (t3 - t2) * tangent_b);
  }
  return line;
}

/// Swings to both sides, about once in 90 m, and not at its ends.
void wind(Polyline& line, double amplitude_m, double phase) {
  const double length = ArcLength(line).length();
  const Polyline straight = line;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(line.size() - 1);
    const Eigen::Vector2d along = straight[i + 1] - straight[i - 1];
    const double swing =
        std::sin(2 * M_PI * share * std::max(1.0, std::round(length / 90)) + phase);
    line[i] += amplitude_m * swing * std::sin(M_PI * share) *
               Eigen::Vector2d(-along.y(), along.x()).normalized();
  }
}

/// Builds a jittered grid of junctions, joins neighbours, slants some blocks, removes some streets.
class NetworkBuilder {
 public:
  explicit NetworkBuilder(const TownOptions& options)
      : options_(options), random_(options.seed, 1) {}

  StreetNetwork build() {
    placeJunctions();
    for (int y = 0; y <= options_.blocks_y; ++y) {
      for (int x = 0; x <= options_.blocks_x; ++x) joinToNeighbours(x, y);
    }
    removeSomeStreets();
    addCulDeSacs();
    listStreetsOfJunctions();
    return std::move(network_);
  }

 private:
  int junctionAt(int x, int y) const { return y * (options_.blocks_x + 1) + x; }

  void placeJunctions() {
    const double spacing = options_.street_spacing_m;
    const double jitter = 0.2 * spacing * options_.irregularity;
    for (int y = 0; y <= options_.blocks_y; ++y) {
      for (int x = 0; x <= options_.blocks_x; ++x) {
        const double dx = random_.uniform(-jitter, jitter), dy = random_.uniform(-jitter, jitter);
        network_.junctions.push_back({{x * spacing + dx, y * spacing + dy}, {}});
      }
    }
  }

  void joinToNeighbours(int x, int y) {
    const bool east = x < options_.blocks_x, north = y < options_.blocks_y;
    if (east) join(junctionAt(x, y), junctionAt(x + 1, y));
    if (north) join(junctionAt(x, y), junctionAt(x, y + 1));
    if (east && north && random_.uniform() < 0.15 * options_.irregularity) {
      join(junctionAt(x, y), junctionAt(x + 1, y + 1));
    }
  }

  void join(int from, int to) {
    const double bend = 0.55 * options_.irregularity;
    Street street;
    street.from = from;
    street.to = to;
    street.half_width_m = random_.uniform(3.0, 4.0);
    street.sidewalk_m = random_.uniform(1.4, 2.6);
    const double turn_a = random_.uniform(-bend, bend), turn_b = random_.uniform(-bend, bend);
    street.centreline = bentLine(network_.junctions[from].position, network_.junctions[to].position,
                                 turn_a, turn_b);
    if (options_.winding_m > 0)
      wind(street.centreline, options_.winding_m * random_.uniform(0.6, 1.4),
           random_.uniform(0, 2 * M_PI));
    if (options_.alike > 0 && random_.uniform() < options_.alike) {
      street.half_width_m = 3.5;
      street.sidewalk_m = 2;
    }
    network_.streets.push_back(std::move(street));
  }

  void removeSomeStreets() {
    std::vector<Street> kept = network_.streets;
    for (std::size_t i = 0; i < kept.size();) {
      const bool wanted = random_.uniform() >= 0.3 * options_.irregularity;
      if (wanted || !servesWithout(kept, i)) {
        ++i;
      } else {
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
    network_.streets = std::move(kept);
  }

  /// True if the network stays connected, and two streets at each junction, when one is left out.
  bool servesWithout(const std::vector<Street>& streets, std::size_t left_out) const {
    std::vector<int> degree(network_.junctions.size(), 0), reached(network_.junctions.size(), 0);
    for (std::size_t i = 0; i < streets.size(); ++i) {
      if (i == left_out) continue;
      ++degree[streets[i].from];
      ++degree[streets[i].to];
    }
    if (*std::min_element(degree.begin(), degree.end()) < 2) return false;
    reached[0] = 1;
    for (bool grew = true; grew;) {
      grew = false;
      for (std::size_t i = 0; i < streets.size(); ++i) {
        if (i == left_out || reached[streets[i].from] == reached[streets[i].to]) continue;
        reached[streets[i].from] = reached[streets[i].to] = 1;
        grew = true;
      }
    }
    return std::count(reached.begin(), reached.end(), 1) ==
           static_cast<std::ptrdiff_t>(reached.size());
  }

  void addCulDeSacs() {
    const std::size_t through = network_.streets.size();
    for (std::size_t i = 0; i < through; ++i) {
      if (random_.uniform() < 0.2 * options_.irregularity) addCulDeSac(i);
    }
  }

  void addCulDeSac(std::size_t parent) {
    const ArcLength line(network_.streets[parent].centreline);
    const PolylinePoint start = line.at(line.length() * random_.uniform(0.35, 0.65));
    const double side = random_.uniform() < 0.5 ? -1 : 1;
    const double length = random_.uniform(0.35, 0.5) * options_.street_spacing_m;
    Street street;
    street.half_width_m = random_.uniform(2.5, 3.0);
    street.sidewalk_m = random_.uniform(1.2, 2.0);
    street.centreline = bentLine(start.position, start.position + side * length * start.left(), 0,
                                 random_.uniform(-0.5, 0.5));
    if (isAwayFromStreets(street.centreline.back())) network_.streets.push_back(std::move(street));
  }

  bool isAwayFromStreets(const Eigen::Vector2d& p) const {
    constexpr double kRoom = kTurningRoad + 9;  // a sidewalk and another street
    for (const Street& street : network_.streets) {
      for (const Eigen::Vector2d& q : street.centreline) {
        if ((p - q).norm() < kRoom) return false;
      }
    }
    return true;
  }

  void listStreetsOfJunctions() {
    for (std::size_t i = 0; i < network_.streets.size(); ++i) {
      const Street& street = network_.streets[i];
      if (!street.isThrough()) continue;
      network_.junctions[street.from].streets.push_back(static_cast<int>(i));
      network_.junctions[street.to].streets.push_back(static_cast<int>(i));
    }
  }

  const TownOptions& options_;
  Random random_;
  StreetNetwork network_;
};

double distanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double squared = ab.squaredNorm();
  const double t = squared > 0 ? std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (a + t * ab - p).norm();
}

/// Minimum with a fillet (polynomial smooth minimum), which fades out away from the streets.
double filletedMinimum(double a, double b) {
  const double nearer = std::min(a, b);
  const double range = kFillet * std::clamp(2 - nearer / kFillet, 0.0, 1.0);
  if (std::abs(a - b) >= range) return nearer;
  const double h = 1 - std::abs(a - b) / range;
  return nearer - h * h * range / 4;
}

}  // namespace

StreetNetwork makeStreets(const TownOptions& options) { return NetworkBuilder(options).build(); }

ArcLength::ArcLength(const Polyline& line) : line_(line), along_(line.size(), 0) {
  for (std::size_t i = 1; i < line_.size(); ++i) {
    along_[i] = along_[i - 1] + (line_[i] - line_[i - 1]).norm();
  }
}

PolylinePoint ArcLength::at(double along_m) const {
  const double along = std::clamp(along_m, 0.0, length());
  const auto next = std::upper_bound(along_.begin() + 1, along_.end() - 1, along);
  const auto i = static_cast<std::size_t>(next - along_.begin());
  const Eigen::Vector2d step = line_[i] - line_[i - 1];
  const double size = along_[i] - along_[i - 1];
  if (size <= 0) return {line_[i], Eigen::Vector2d::UnitX()};
  return {line_[i - 1] + step * ((along - along_[i - 1]) / size), step / size};
}

StreetField::StreetField(const StreetNetwork& network) {
  for (const Street& street : network.streets) {
    for (const Eigen::Vector2d& p : street.centreline) bounds_.extend(p);
  }
  const Eigen::Vector2d size = bounds_.sizes();
  bins_x_ = static_cast<int>((size.x() + 2 * kReach) / kBin) + 1;
  bins_y_ = static_cast<int>((size.y() + 2 * kReach) / kBin) + 1;
  bins_.resize(static_cast<std::size_t>(bins_x_) * bins_y_);
  for (std::size_t s = 0; s < network.streets.size(); ++s) {
    const Street& street = network.streets[s];
    const double road = street.half_width_m, sidewalk = road + street.sidewalk_m;
    const Polyline& line = street.centreline;
    for (std::size_t i = 1; i < line.size(); ++i) {
      addSegment({line[i - 1], line[i], road, sidewalk, static_cast<int>(s)});
    }
    if (!street.isThrough()) {
      addSegment({line.back(), line.back(), kTurningRoad, kTurningRoad + street.sidewalk_m,
                  static_cast<int>(s)});
    }
  }
}

void StreetField::addPath(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double half_width_m) {
  addSegment({a, b, -kReach, half_width_m, -1});
}

void StreetField::addSegment(const Segment& segment) {
  const auto number = static_cast<std::uint32_t>(segments_.size());
  segments_.push_back(segment);
  const Eigen::Vector2d origin = bounds_.min() - Eigen::Vector2d::Constant(kReach);
  const Eigen::Vector2d low = segment.a.cwiseMin(segment.b) - origin;
  const Eigen::Vector2d high = segment.a.cwiseMax(segment.b) - origin;
  const auto index = [](double value, int count) {
    return std::clamp(static_cast<int>(std::floor(value / kBin)), 0, count - 1);
  };
  for (int y = index(low.y() - kReach, bins_y_); y <= index(high.y() + kReach, bins_y_); ++y) {
    for (int x = index(low.x() - kReach, bins_x_); x <= index(high.x() + kReach, bins_x_); ++x) {
      bins_[static_cast<std::size_t>(y) * bins_x_ + x].push_back(number);
    }
  }
}

const std::vector<std::uint32_t>* StreetField::bin(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d cell = (p - bounds_.min() + Eigen::Vector2d::Constant(kReach)) / kBin;
  const double x = std::floor(cell.x()), y = std::floor(cell.y());
  if (!(x >= 0 && y >= 0 && x < bins_x_ && y < bins_y_)) return nullptr;
  return &bins_[static_cast<std::size_t>(y) * bins_x_ + static_cast<std::size_t>(x)];
}

double StreetField::distance(const Eigen::Vector2d& p, double Segment::*half_width) const {
  const std::vector<std::uint32_t>* near = bin(p);
  if (!near) return kFar;
  double all = kFar, paths = kFar;
  for (std::size_t i = 0; i < near->size();) {
    const int street = segments_[(*near)[i]].street;
    double one = kFar;
    for (; i < near->size() && segments_[(*near)[i]].street == street; ++i) {
      const Segment& segment = segments_[(*near)[i]];
      one = std::min(one, distanceToSegment(p, segment.a, segment.b) - segment.*half_width);
    }
    if (street < 0) {
      paths = std::min(paths, one);
    } else {
      all = filletedMinimum(all, one);
    }
  }
  return std::min(all, paths);
}

double StreetField::toRoad(const Eigen::Vector2d& p) const { return distance(p, &Segment::road_m); }

double StreetField::toSidewalk(const Eigen::Vector2d& p) const {
  return distance(p, &Segment::sidewalk_m);
}

}  // namespace xview
