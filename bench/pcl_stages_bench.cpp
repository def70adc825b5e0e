// SPDX-License-Identifier: BSD-3-Clause
// Own code beside what PCL has for the same step, on the same points, on one thread: Euclidean
// clusters, and the registration of a window to a map from a start that is off.
//
//   pcl_stages_bench RECORDING...
//
// Even frames of a recording are its map, odd ones are in windows of 12 that start 0.6 m and 3
// degrees off. Prints a Markdown table: CPU time of what the map needs once, of each window, and
// the median error of the windows.
#include <fmt/core.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ndt.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pcl_points.h"
#include "place/blobs.h"
#include "place/lift.h"
#include "pose/distribution_map.h"
#include "pose/refine.h"
#include "xview/io/recording.h"
#include "xview/mapper.h"

namespace {

using namespace xview;

constexpr float kTolerance_m = 0.5F, kLeaf_m = 0.25F;
constexpr int kFewest = 10;
constexpr std::size_t kWindow = 12;
constexpr double kConverged = 1e-6;
constexpr int kIterations = 50;
const Eigen::Isometry3d kStart =
    Eigen::Translation3d(0.5, -0.3, 0.1) * Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ());

template <class Work>
double secondsOf(const Work& work) {
  const double begin = cpuSeconds();
  work();
  return cpuSeconds() - begin;
}

/// Frames whose points are in one odometry frame.
struct Part {
  LabelledCloud cloud;
  std::vector<Eigen::Isometry3d> poses;

  void add(const PreprocessedFrame& frame) {
    const Eigen::Vector3f shift = (frame.cloud.origin - cloud.origin).cast<float>();
    for (Point point : frame.cloud.points) {
      point.getVector3fMap() += shift;
      point.view = static_cast<std::uint32_t>(poses.size());
      cloud.points.push_back(point);
    }
    poses.push_back(frame.T_odom_sensor);
  }
};

struct Recording {
  std::string name;
  LabelSet labels;
  Part map;
  std::vector<Part> windows;
};

Recording read(const std::string& path) {
  const auto source = io::openRecording(path);
  Recording result{path, source->labels(), {}, {}};
  Options options;
  options.threads = 1;
  for (std::size_t i = 0; i < source->size(); ++i) {
    const PreprocessedFrame frame = preprocessFrame(source->read(i), result.labels, options);
    if (i == 0) result.map.cloud.origin = frame.cloud.origin;
    if (i % 2 == 0) {
      result.map.add(frame);
      continue;
    }
    if (i % (2 * kWindow) == 1) {
      result.windows.emplace_back();
      result.windows.back().cloud.origin = result.map.cloud.origin;
    }
    result.windows.back().add(frame);
  }
  return result;
}

void row(const std::string& step, const std::string& method, double once_s, double each_s,
         const std::string& result) {
  fmt::print("| {} | {} | {:.2f} | {:.3f} | {} |\n", step, method, once_s, each_s, result);
}

void compareClusters(const Recording& recording) {
  std::map<std::uint32_t, std::vector<Eigen::Vector3f>> of_class;
  for (const Point& p : thinByVoxel(recording.map.cloud, kLeaf_m).points)
    of_class[p.label].emplace_back(p.getVector3fMap());
  std::size_t points = 0, own = 0, of_pcl = 0;
  double own_s = 0, pcl_s = 0;
  for (const auto& [label, positions] : of_class) {
    points += positions.size();
    own_s += secondsOf([&] {
      const std::vector<int> clusters = euclideanClusters(positions, kTolerance_m, kFewest);
      own += static_cast<std::size_t>(1 + *std::max_element(clusters.begin(), clusters.end()));
    });
    Points::Ptr cloud(new Points);
    for (const Eigen::Vector3f& p : positions) cloud->push_back({p.x(), p.y(), p.z()});
    pcl_s += secondsOf([&] {
      pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
      tree->setInputCloud(cloud);
      pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
      extraction.setClusterTolerance(kTolerance_m);
      extraction.setMinClusterSize(kFewest);
      extraction.setSearchMethod(tree);
      extraction.setInputCloud(cloud);
      std::vector<pcl::PointIndices> clusters;
      extraction.extract(clusters);
      of_pcl += clusters.size();
    });
  }
  const std::string step = fmt::format("{}: clusters of {} points", recording.name, points);
  row(step, "`euclideanClusters`", 0, own_s, fmt::format("{} clusters", own));
  row(step, "`pcl::EuclideanClusterExtraction`", 0, pcl_s, fmt::format("{} clusters", of_pcl));
}

/// `align(window, pose)` moves the pose from its start.
template <class Align>
void compareRegistration(const Recording& recording, const std::string& method, double once_s,
                         const Align& align) {
  std::vector<double> errors_m;
  double seconds = 0;
  for (const Part& window : recording.windows) {
    Eigen::Isometry3d T = kStart;
    // About the last sensor, as a start is given.
    T.translation() +=
        window.poses.back().translation() - kStart.linear() * window.poses.back().translation();
    seconds += secondsOf([&] { align(window, T); });
    const Eigen::Vector3d sensor = window.poses.back().translation();
    errors_m.push_back((T * sensor - sensor).norm());
  }
  std::sort(errors_m.begin(), errors_m.end());
  const std::size_t count = errors_m.size();
  row(fmt::format("{}: {} windows", recording.name, count), method, once_s,
      seconds / static_cast<double>(count),
      fmt::format("{:.3f} m, worst {:.2f} m", errors_m[count / 2], errors_m.back()));
}

template <class Registration>
void comparePcl(const Recording& recording, const std::string& method, Registration& registration) {
  const Points::Ptr map = thinned(recording.map.cloud, kLeaf_m);
  const double once_s = secondsOf([&] { registration.setInputTarget(map); });
  compareRegistration(recording, method, once_s, [&](const Part& window, Eigen::Isometry3d& T) {
    // Clouds are relative to the origin of the map.
    const Eigen::Translation3d origin(recording.map.cloud.origin);
    const Eigen::Isometry3d guess = origin.inverse() * T * origin;
    registration.setInputSource(thinned(window.cloud, kLeaf_m));
    Points aligned;
    registration.align(aligned, guess.matrix().cast<float>());
    T = origin * Eigen::Isometry3d(registration.getFinalTransformation().template cast<double>()) *
        origin.inverse();
  });
}

void compare(const Recording& recording) {
  compareClusters(recording);
  const pose::RefineOptions options;
  std::optional<pose::DistributionMap> distributions;
  const double once_s = secondsOf([&] {
    distributions.emplace(
        pose::MapPoints{recording.map.cloud, recording.labels, recording.map.poses, nullptr, {}},
        options);
    distributions->size();
  });
  compareRegistration(
      recording, "`pose::refine`", once_s, [&](const Part& window, Eigen::Isometry3d& T) {
        T = pose::refine(*distributions, {window.cloud, window.poses}, recording.labels, T, options)
                .T_map_query;
      });
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setResolution(1);
  ndt.setStepSize(0.1);
  ndt.setTransformationEpsilon(kConverged);
  ndt.setMaximumIterations(kIterations);
  comparePcl(recording, "`pcl::NormalDistributionsTransform`", ndt);
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setMaxCorrespondenceDistance(2.5);
  gicp.setTransformationEpsilon(kConverged);
  gicp.setRotationEpsilon(kConverged);
  gicp.setMaximumIterations(kIterations);
  comparePcl(recording, "`pcl::GeneralizedIterativeClosestPoint`", gicp);
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print("| step | code | of the map, once [s] | each [s] | result |\n|---|---|---|---|---|\n");
  for (int i = 1; i < argc; ++i) compare(read(argv[i]));
  return argc > 1 ? 0 : 2;
}
