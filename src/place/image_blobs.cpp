// SPDX-License-Identifier: BSD-3-Clause
#include "place/blobs.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/median.h"
#include "place/clean_labels.h"
#include "xview/base/error.h"

namespace xview {
namespace {

// Blobs whose contours come this near are neighbours, as share of the width of the image.
constexpr double kEdgeDistance = 1.0 / 64;

constexpr std::int32_t kNoBlob = -1;

/// What is needed of a region to make a blob of it. Sums are relative to the first point, so that
/// they stay small.
struct RegionPixels {
  double sum_u = 0, sum_v = 0;
  std::vector<float> depths;                      ///< valid ones
  Eigen::Vector3d first, min, max;                ///< p_odom of the valid ones
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  ///< of p - first
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& p, float depth) {
    if (depths.empty()) first = min = max = p;
    depths.push_back(depth);
    const Eigen::Vector3d d = p - first;
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
    sum += d;
    squares.noalias() += d * d.transpose();
  }
};

bool isWithin(float z, double max_range_m) { return z > 0 && z <= max_range_m; }

void addRun(const Frame& frame, const LabelRun& run, double max_range_m, RegionPixels& region) {
  const Camera& camera = frame.camera;
  const Eigen::Matrix3d R = frame.T_odom_sensor.linear();
  const Eigen::Vector3d t = frame.T_odom_sensor.translation();
  const double y = (run.row - camera.cy) / camera.fy;
  const Eigen::Vector3d row = R.col(1) * y + R.col(2);
  const int count = run.end - run.begin;
  region.sum_u += 0.5 * count * (run.begin + run.end - 1);
  region.sum_v += static_cast<double>(count) * run.row;
  for (int u = run.begin; u < run.end; ++u) {
    const float depth = frame.depth.at(u, run.row);
    if (!isWithin(depth, max_range_m)) continue;
    const double x = (u - camera.cx) / camera.fx;
    const double z = camera.depth_is_range ? depth / std::sqrt(x * x + y * y + 1) : depth;
    region.add((row + R.col(0) * x) * z + t, depth);
  }
}

std::vector<RegionPixels> collectPixels(const Frame& frame, const LabelRegions& found,
                                        const std::vector<bool>& is_wanted, double max_range_m) {
  std::vector<RegionPixels> pixels(found.regions.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (is_wanted[i]) pixels[i].depths.reserve(static_cast<std::size_t>(found.regions[i].pixels));
  }
  for (const LabelRun& run : found.runs) {
    if (is_wanted[run.region]) addRun(frame, run, max_range_m, pixels[run.region]);
  }
  return pixels;
}

Blob makeBlob(const Frame& frame, const LabelRegion& region, RegionPixels& pixels) {
  Blob blob;
  blob.label = region.label;
  blob.instance = region.instance;
  blob.points = static_cast<std::uint32_t>(pixels.depths.size());
  blob.first_frame = blob.last_frame = frame.number;
  const double u = pixels.sum_u / region.pixels, v = pixels.sum_v / region.pixels;
  blob.position =
      frame.T_odom_sensor * frame.camera.unproject(u, v, medianOf(std::move(pixels.depths)));
  blob.min = pixels.min;
  blob.max = pixels.max;
  const Eigen::Vector3d mean = pixels.sum / blob.points;
  blob.covariance = pixels.squares / blob.points - mean * mean.transpose();
  return blob;
}

/// Pixels at which a blob meets something else (or the border of the image).
bool isContour(const Image<std::int32_t>& blob_of_pixel, int u, int v) {
  const std::int32_t blob = blob_of_pixel.at(u, v);
  if (u == 0 || v == 0 || u + 1 == blob_of_pixel.width || v + 1 == blob_of_pixel.height)
    return true;
  return blob_of_pixel.at(u - 1, v) != blob || blob_of_pixel.at(u + 1, v) != blob ||
         blob_of_pixel.at(u, v - 1) != blob || blob_of_pixel.at(u, v + 1) != blob;
}

/// Blobs with contour pixels at most `radius_px` apart. Each contour pixel looks at the lower half
/// of the disc around it, as the upper half sees the pair from the other side.
BlobEdges contourEdges(const Image<std::int32_t>& blob_of_pixel, double radius_px) {
  const int width = blob_of_pixel.width, height = blob_of_pixel.height;
  BlobEdges edges;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::int32_t a = blob_of_pixel.at(u, v);
      if (a == kNoBlob || !isContour(blob_of_pixel, u, v)) continue;
      for (int y = v; y < height && y - v <= radius_px; ++y) {
        const int reach = static_cast<int>(std::sqrt(radius_px * radius_px - (y - v) * (y - v)));
        for (int x = std::max(u - reach, 0); x <= std::min(u + reach, width - 1); ++x) {
          const std::int32_t b = blob_of_pixel.at(x, y);
          if (b == kNoBlob || b == a) continue;
          const BlobEdges::value_type edge(std::min(a, b), std::max(a, b));
          if (edges.empty() || edges.back() != edge) edges.push_back(edge);
        }
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

void checkFrame(const Frame& frame) {
  const auto is_other_size = [&](const LabelImage& image) {
    return image.width != frame.depth.width || image.height != frame.depth.height;
  };
  if (is_other_size(frame.label) || (!frame.instance.empty() && is_other_size(frame.instance))) {
    throw Error("frame " + std::to_string(frame.number),
                "expected depth, label and instance images of one size");
  }
}

/// The instances of classes that move; other pixels have none.
LabelImage instancesOfDynamic(const Frame& frame, const LabelSet& set) {
  LabelImage instances = frame.instance;
  for (std::size_t i = 0; i < instances.pixels.size(); ++i) {
    const std::uint16_t id = frame.label.pixels[i];
    if (set.role(id) != Role::dynamic && set.kind(id) != Kind::vehicle) instances.pixels[i] = 0;
  }
  return instances;
}

}  // namespace

ImageBlobs extractImageBlobs(const Frame& frame, const LabelSet& set, double max_range_m,
                             const BlobOptions& options) {
  checkFrame(frame);
  ImageBlobs result;
  if (frame.label.empty()) return result;
  const LabelRegions found = options.instances == "all"
                                 ? findLabelRegions(frame.label, frame.instance)
                             : options.instances == "dynamic"
                                 ? findLabelRegions(frame.label, instancesOfDynamic(frame, set))
                                 : findLabelRegions(frame.label);
  const double min_pixels =
      options.min_share * static_cast<double>(frame.label.width) * frame.label.height;
  std::vector<bool> is_wanted;
  for (const LabelRegion& region : found.regions) {
    is_wanted.push_back(set.role(region.label) != Role::ignored && region.pixels >= min_pixels);
  }

  std::vector<RegionPixels> pixels = collectPixels(frame, found, is_wanted, max_range_m);
  std::vector<std::int32_t> blob_of_region(found.regions.size(), kNoBlob);
  for (std::size_t i = 0; i < found.regions.size(); ++i) {
    if (pixels[i].depths.empty()) continue;
    blob_of_region[i] = static_cast<std::int32_t>(result.blobs.size());
    result.blobs.push_back(makeBlob(frame, found.regions[i], pixels[i]));
  }

  result.blob_of_pixel = Image<std::int32_t>(frame.label.width, frame.label.height, kNoBlob);
  for (const LabelRun& run : found.runs) {
    std::int32_t* const row = &result.blob_of_pixel.at(0, run.row);
    std::fill(row + run.begin, row + run.end, blob_of_region[run.region]);
  }
  result.edges = contourEdges(result.blob_of_pixel, kEdgeDistance * frame.label.width);
  return result;
}

}  // namespace xview
