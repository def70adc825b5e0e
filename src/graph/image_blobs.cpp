// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/image_blobs.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "label_regions.h"
#include "xview/types/error.h"

namespace xview {
namespace {

// The image size that the options speak of.
constexpr double kReferenceWidth = 640, kReferenceHeight = 480;

constexpr std::int32_t kNoBlob = -1;

/// What is needed of a region to make a blob of it.
struct RegionPixels {
  double sum_u = 0, sum_v = 0;
  std::vector<float> depths;            ///< valid ones
  std::vector<Eigen::Vector3f> points;  ///< p_sensor of the valid ones
};

bool isDepth(float z, double max_range_m) { return z > 0 && z <= max_range_m; }

/// p_sensor of a pixel.
Eigen::Vector3d unproject(const Camera& camera, double u, double v, double depth) {
  const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
  return camera.depth_is_range ? Eigen::Vector3d(ray.normalized() * depth)
                               : Eigen::Vector3d(ray * depth);
}

double median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<RegionPixels> collectPixels(const Frame& frame, const LabelRegions& found,
                                        const std::vector<bool>& is_wanted, double max_range_m) {
  std::vector<RegionPixels> pixels(found.regions.size());
  for (const LabelRun& run : found.runs) {
    if (!is_wanted[run.region]) continue;
    RegionPixels& region = pixels[run.region];
    for (int u = run.begin; u < run.end; ++u) {
      region.sum_u += u;
      region.sum_v += run.row;
      const float z = frame.depth.at(u, run.row);
      if (!isDepth(z, max_range_m)) continue;
      region.depths.push_back(z);
      region.points.push_back(unproject(frame.camera, u, run.row, z).cast<float>());
    }
  }
  return pixels;
}

Blob makeBlob(const Frame& frame, const LabelRegion& region, const RegionPixels& pixels) {
  Blob blob;
  blob.label = region.label;
  blob.instance = region.instance;
  blob.points = static_cast<std::uint32_t>(pixels.points.size());
  blob.first_frame = blob.last_frame = frame.number;
  const double u = pixels.sum_u / region.pixels, v = pixels.sum_v / region.pixels;
  blob.position = frame.T_odom_sensor * unproject(frame.camera, u, v, median(pixels.depths));
  blob.min = Eigen::Vector3d::Constant(std::numeric_limits<double>::max());
  blob.max = -blob.min;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& p_sensor : pixels.points) {
    const Eigen::Vector3d p = frame.T_odom_sensor * p_sensor.cast<double>();
    const Eigen::Vector3d d = p - blob.position;
    blob.min = blob.min.cwiseMin(p);
    blob.max = blob.max.cwiseMax(p);
    sum += d;
    squares += d * d.transpose();
  }
  const Eigen::Vector3d mean = sum / blob.points;
  blob.covariance = squares / blob.points - mean * mean.transpose();
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

struct Offset {
  int du, dv;
};

/// Half of the disc, as the other half sees the pair from the other side.
std::vector<Offset> halfDisc(double radius_px) {
  std::vector<Offset> offsets;
  const int reach = static_cast<int>(radius_px);
  for (int dv = 0; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      if (dv == 0 && du <= 0) continue;
      if (du * du + dv * dv <= radius_px * radius_px) offsets.push_back({du, dv});
    }
  }
  return offsets;
}

/// Blobs with contour pixels at most `radius_px` apart.
BlobEdges contourEdges(const Image<std::int32_t>& blob_of_pixel, double radius_px) {
  const std::vector<Offset> offsets = halfDisc(radius_px);
  std::set<BlobEdges::value_type> edges;
  for (int v = 0; v < blob_of_pixel.height; ++v) {
    for (int u = 0; u < blob_of_pixel.width; ++u) {
      const std::int32_t a = blob_of_pixel.at(u, v);
      if (a == kNoBlob || !isContour(blob_of_pixel, u, v)) continue;
      std::int32_t last = a;
      for (const Offset& offset : offsets) {
        const int other_u = u + offset.du, other_v = v + offset.dv;
        if (other_u < 0 || other_u >= blob_of_pixel.width || other_v >= blob_of_pixel.height)
          continue;
        const std::int32_t b = blob_of_pixel.at(other_u, other_v);
        if (b == kNoBlob || b == a || b == last) continue;
        last = b;
        edges.emplace(static_cast<std::uint32_t>(std::min(a, b)),
                      static_cast<std::uint32_t>(std::max(a, b)));
      }
    }
  }
  return {edges.begin(), edges.end()};
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

}  // namespace

ImageBlobs extractImageBlobs(const Frame& frame, const LabelSet& set,
                             const ImageBlobOptions& options, double max_range_m) {
  checkFrame(frame);
  ImageBlobs result;
  if (frame.label.empty()) return result;
  const LabelRegions found = findLabelRegions(frame.label, frame.instance);
  const double area = static_cast<double>(frame.label.width) * frame.label.height;
  const double min_pixels = options.min_pixels * area / (kReferenceWidth * kReferenceHeight);
  std::vector<bool> is_wanted;
  for (const LabelRegion& region : found.regions) {
    is_wanted.push_back(set.role(region.label) != Role::ignored && region.pixels >= min_pixels);
  }

  const std::vector<RegionPixels> pixels = collectPixels(frame, found, is_wanted, max_range_m);
  std::vector<std::int32_t> blob_of_region(found.regions.size(), kNoBlob);
  for (std::size_t i = 0; i < found.regions.size(); ++i) {
    if (pixels[i].points.empty()) continue;
    blob_of_region[i] = static_cast<std::int32_t>(result.blobs.size());
    result.blobs.push_back(makeBlob(frame, found.regions[i], pixels[i]));
  }

  result.blob_of_pixel = Image<std::int32_t>(frame.label.width, frame.label.height, kNoBlob);
  for (const LabelRun& run : found.runs) {
    std::int32_t* const row = &result.blob_of_pixel.at(0, run.row);
    std::fill(row + run.begin, row + run.end, blob_of_region[run.region]);
  }
  result.edges = contourEdges(result.blob_of_pixel,
                              options.edge_distance_px * frame.label.width / kReferenceWidth);
  return result;
}

}  // namespace xview
