// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/blobs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "graph/disjoint_sets.h"
#include "xview/types/median.h"

namespace xview::graph {
namespace {

// Sectors in which the elevations are looked at.
constexpr int kSectors = 360;
constexpr int kEverySector = 8;  ///< is enough
constexpr float kNear_m = 4;     ///< beams do not leave from one point: nearer ones mislead
constexpr float kSameBeam_rad = 0.0014f;  ///< beams nearer than this need no care
constexpr float kFarthestBeam_rad = 0.1f;
constexpr std::size_t kFewestSteps = 100;

constexpr double kReach = 2.2;          ///< beams; between two of them one may be lost
constexpr double kThinThing_m2 = 0.25;  ///< a post of 0.15 m, seen over 1.6 m
constexpr int kFewestPoints = 4;

/// Whether a direction may be in one of the sectors that are looked at. An arc tangent is asked for
/// then only: a table over y / (|x| + |y|), which grows with the angle on either side, knows most
/// of the others.
class SectorsLookedAt {
 public:
  SectorsLookedAt() {
    constexpr double kSector_rad = 2 * M_PI / kSectors, kMargin_rad = 1e-3;
    for (int sector = 0; sector <= kSectors; sector += kEverySector) {
      const double begin = sector * kSector_rad - M_PI - kMargin_rad;
      const double end = (sector + 1) * kSector_rad - M_PI + kMargin_rad;
      for (double angle = begin; angle < end; angle += kMargin_rad) mark(angle);
      mark(end);
    }
  }

  bool mayHold(float x, float y) const {
    const float sum = std::abs(x) + std::abs(y);
    if (!(sum > 0) || !(sum < kFarthest_m)) return true;
    return may_be_[x < 0][binOf(y / sum)];
  }

 private:
  static constexpr int kBins = 1024;
  static constexpr float kFarthest_m = 1e9F;

  static int binOf(float p) { return static_cast<int>((p + 1) * (0.5F * (kBins - 1))); }
  void mark(double angle) {
    const double x = std::cos(angle), y = std::sin(angle);
    may_be_[x < 0][binOf(static_cast<float>(y / (std::abs(x) + std::abs(y))))] = true;
  }

  std::array<std::array<bool, kBins>, 2> may_be_{};  ///< ahead and behind
};

/// Elevations of the far points in some sectors, sorted in each.
std::vector<std::vector<float>> elevationsInSectors(const LabelledCloud& cloud) {
  std::vector<std::vector<float>> sectors(kSectors / kEverySector);
  const Eigen::Vector3f origin = cloud.origin.cast<float>();
  constexpr float kPerRadian = kSectors / (2 * static_cast<float>(M_PI));
  static const SectorsLookedAt looked_at;
  for (const Point& point : cloud.points) {
    const Eigen::Vector3f p = origin + point.getVector3fMap();
    if (!looked_at.mayHold(p.x(), p.y())) continue;
    const float range = std::hypot(p.x(), p.y());
    if (!(range > kNear_m) || !std::isfinite(p.z())) continue;
    const auto sector =
        static_cast<int>((std::atan2(p.y(), p.x()) + static_cast<float>(M_PI)) * kPerRadian);
    if (sector % kEverySector != 0 || sector >= kSectors) continue;
    sectors[static_cast<std::size_t>(sector / kEverySector)].push_back(std::atan2(p.z(), range));
  }
  for (auto& sector : sectors) std::sort(sector.begin(), sector.end());
  return sectors;
}

/// Differences between successive elevations that are no scatter of one beam, sorted.
std::vector<float> stepsBetweenBeams(const std::vector<std::vector<float>>& sectors) {
  std::vector<float> steps;
  for (const auto& sector : sectors) {
    for (std::size_t i = 1; i < sector.size(); ++i) {
      const float step = sector[i] - sector[i - 1];
      if (step > kSameBeam_rad && step < kFarthestBeam_rad) steps.push_back(step);
    }
  }
  std::sort(steps.begin(), steps.end());
  return steps;
}

/// Measurements of one beam in a sector, on average over beams that measured there at all.
double pointsPerBeam(const std::vector<std::vector<float>>& sectors, float elevation_step) {
  std::size_t points = 0, beams = 0;
  for (const auto& sector : sectors) {
    points += sector.size();
    for (std::size_t i = 0; i < sector.size(); ++i)
      beams += i == 0 || sector[i] - sector[i - 1] > 0.5f * elevation_step;
  }
  return beams > 0 ? static_cast<double>(points) / static_cast<double>(beams) : 0;
}

/// A point of the range image.
struct Pixel {
  std::int32_t row = 0, column = 0;
  float azimuth = 0, elevation = 0, range = 0;
  std::uint32_t index = 0;
  bool operator<(const Pixel& o) const {
    return std::tie(row, column, index) < std::tie(o.row, o.column, o.index);
  }
};

/// The far points as a range image, ordered by row and column. The first columns follow the last
/// ones once more, so that the image closes around the sensor.
class RangeImage {
 public:
  RangeImage(const std::vector<Eigen::Vector3f>& points, const BeamSpacing& beams, float from_m)
      : beams_(beams) {
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3f& p = points[i];
      const float range = p.norm();
      if (!(range > from_m) || !std::isfinite(range)) continue;
      Pixel pixel;
      pixel.azimuth = std::atan2(p.y(), p.x()) + static_cast<float>(M_PI);
      pixel.elevation = std::asin(std::clamp(p.z() / range, -1.f, 1.f));
      pixel.range = range;
      pixel.row = static_cast<std::int32_t>(std::floor(pixel.elevation / beams.elevation_rad));
      pixel.column = columnOf(pixel.azimuth);
      pixel.index = i;
      pixels_.push_back(pixel);
      if (pixel.column > kPixels) continue;
      pixel.azimuth += 2 * static_cast<float>(M_PI);
      pixel.column = columnOf(pixel.azimuth);
      pixels_.push_back(pixel);
    }
    std::sort(pixels_.begin(), pixels_.end());
  }

  /// Calls join(index, index) for the pairs that are next to one another.
  template <class Join>
  void forNeighbours(float depth_m, Join&& join) const {
    std::array<std::size_t, kPixels + 1> cursor{};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const Pixel& a = pixels_[i];
      for (int up = 0; up <= kPixels; ++up) {
        std::size_t& first = cursor[static_cast<std::size_t>(up)];
        const std::int32_t row = a.row + up, from = a.column - kPixels;
        while (first < pixels_.size() &&
               std::tie(pixels_[first].row, pixels_[first].column) < std::tie(row, from))
          ++first;
        for (std::size_t j = std::max(first, up == 0 ? i + 1 : 0); j < pixels_.size(); ++j) {
          const Pixel& b = pixels_[j];
          if (b.row != row || b.column > a.column + kPixels) break;
          if (areNext(a, b, depth_m)) join(a.index, b.index);
        }
      }
    }
  }

 private:
  std::int32_t columnOf(float azimuth) const {
    return static_cast<std::int32_t>(azimuth / beams_.azimuth_rad);
  }

  static constexpr int kPixels = 3;  ///< more than kReach, because pixels have borders

  bool areNext(const Pixel& a, const Pixel& b, float depth_m) const {
    return std::abs(a.elevation - b.elevation) <= kReach * beams_.elevation_rad &&
           std::abs(a.azimuth - b.azimuth) <= kReach * beams_.azimuth_rad &&
           std::abs(a.range - b.range) <= depth_m;
  }

  BeamSpacing beams_;
  std::vector<Pixel> pixels_;
};

/// What one beam measured.
struct Ring {
  std::vector<double> elevations;  ///< of its far points
  std::array<std::uint32_t, kSectors> points{};
  double elevation = 0, spread = 0;  ///< median, and median distance from it

  void finish() {
    elevation = medianOf(elevations);
    for (double& e : elevations) e = std::abs(e - elevation);
    spread = medianOf(elevations);
  }
};

/// The rings with enough far points, by elevation.
std::vector<Ring> ringsOf(const LabelledCloud& cloud,
                          const std::vector<std::uint16_t>& ring_of_point) {
  constexpr std::size_t kFewestPointsOfRing = 20;
  std::map<std::uint16_t, Ring> rings;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.position(i);
    const double range = std::hypot(p.x(), p.y());
    if (!(range > kNear_m) || !p.allFinite()) continue;
    Ring& ring = rings[ring_of_point[i]];
    ring.elevations.push_back(std::atan2(p.z(), range));
    const auto sector =
        static_cast<std::size_t>((std::atan2(p.y(), p.x()) + M_PI) * kSectors / (2 * M_PI));
    ++ring.points[std::min<std::size_t>(sector, kSectors - 1)];
  }
  std::vector<Ring> sorted;
  for (auto& [number, ring] : rings) {
    if (ring.elevations.size() < kFewestPointsOfRing) continue;
    ring.finish();
    sorted.push_back(std::move(ring));
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const Ring& a, const Ring& b) { return a.elevation < b.elevation; });
  return sorted;
}

/// Measurements of one beam in a sector, in the middle over beams and sectors that measured at all.
double pointsPerRing(const std::vector<Ring>& rings) {
  std::vector<double> counts;
  for (const Ring& ring : rings) {
    for (const std::uint32_t points : ring.points) {
      if (points > 0) counts.push_back(points);
    }
  }
  return medianOf(counts);
}

/// From the rings of the cloud; nothing if their numbers do not tell its beams apart.
BeamSpacing spacingOfRings(const LabelledCloud& cloud,
                           const std::vector<std::uint16_t>& ring_of_point) {
  constexpr std::size_t kFewestRings = 4;
  if (ring_of_point.size() != cloud.size()) return {};
  std::vector<Ring> rings = ringsOf(cloud, ring_of_point);
  if (rings.size() < kFewestRings) return {};
  std::vector<double> steps, spreads;
  for (std::size_t i = 1; i < rings.size(); ++i)
    steps.push_back(rings[i].elevation - rings[i - 1].elevation);
  for (const Ring& ring : rings) spreads.push_back(ring.spread);
  const double step = medianOf(steps);
  if (!(step > 0) || step > kFarthestBeam_rad || medianOf(spreads) > 0.5 * step) return {};
  return {2 * M_PI / kSectors / pointsPerRing(rings), step};
}

}  // namespace

BeamSpacing measureBeamSpacing(const LabelledCloud& cloud,
                               const std::vector<std::uint16_t>& rings) {
  const BeamSpacing of_rings = spacingOfRings(cloud, rings);
  if (of_rings.isKnown()) return of_rings;
  const auto sectors = elevationsInSectors(cloud);
  const std::vector<float> steps = stepsBetweenBeams(sectors);
  if (steps.size() < kFewestSteps) return {};
  const float typical = steps[steps.size() / 2];
  const auto alike = std::upper_bound(steps.begin(), steps.end(), 1.5f * typical) -
                     std::lower_bound(steps.begin(), steps.end(), 0.65f * typical);
  if (3 * static_cast<std::size_t>(alike) < 2 * steps.size()) return {};
  const double per_beam = pointsPerBeam(sectors, typical);
  return {2 * M_PI / kSectors / per_beam, typical};
}

void joinAlongBeams(const std::vector<Eigen::Vector3f>& points, const BeamSpacing& beams,
                    float depth_m, std::vector<int>& cluster_of_point) {
  if (!beams.isKnown() || points.empty()) return;
  const double widest = kReach * std::max(beams.azimuth_rad, beams.elevation_rad);
  const RangeImage image(points, beams, static_cast<float>(depth_m / widest));
  DisjointSets joined(static_cast<std::size_t>(
      1 + *std::max_element(cluster_of_point.begin(), cluster_of_point.end())));
  image.forNeighbours(depth_m, [&](std::uint32_t a, std::uint32_t b) {
    if (cluster_of_point[a] >= 0 && cluster_of_point[b] >= 0)
      joined.unite(static_cast<std::uint32_t>(cluster_of_point[a]),
                   static_cast<std::uint32_t>(cluster_of_point[b]));
  });
  for (int& cluster : cluster_of_point) {
    if (cluster >= 0) cluster = static_cast<int>(joined.find(static_cast<std::uint32_t>(cluster)));
  }
}

int pointsOfThinThing(double range_m, const BeamSpacing& beams, int most) {
  if (!beams.isKnown()) return most;
  const double square_m2 = range_m * range_m * beams.azimuth_rad * beams.elevation_rad;
  const double points = std::floor(kThinThing_m2 / std::max(square_m2, 1e-9));
  return static_cast<int>(std::clamp<double>(points, std::min(kFewestPoints, most), most));
}

}  // namespace xview::graph
