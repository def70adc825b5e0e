// SPDX-License-Identifier: BSD-3-Clause
// What PCL offers for two clouds that nobody has aligned: FPFH, then SampleConsensusPrerejective or
// SAC-IA, then ICP.
//
//   fpfh_bench MAP.pcd QUERY.pcd...
//
// One line of JSON per query and method: what it says, how much of the query lies on the map, and
// its pose.
#include <fmt/core.h>
#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/registration/ia_ransac.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include <iostream>
#include <string>

#include "pcl_points.h"
#include "xview/io/recording.h"

namespace {

using xview::cpuSeconds, xview::Points;
using Features = pcl::PointCloud<pcl::FPFHSignature33>;

/// Of the usual tutorials, in sides of a voxel: radii of normals and features, and how far a point
/// may lie from its partner.
constexpr float kVoxel_m = 0.5F;
constexpr double kNormalRadius = 2, kFeatureRadius = 5, kPartner = 2.5;
constexpr int kPrerejectiveIterations = 50000, kSacIaIterations = 500, kIcpIterations = 60;
constexpr double kLiesOnMap_m = 0.3;

Points::Ptr thinned(const std::string& path) {
  return xview::thinned(xview::io::openRecording(path)->read(0).cloud, kVoxel_m);
}

Features::Ptr featuresOf(const Points::Ptr& points) {
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> normal;
  normal.setInputCloud(points);
  normal.setRadiusSearch(kNormalRadius * kVoxel_m);
  normal.setViewPoint(0, 0, 1e6f);  // nobody knows from where a fused cloud was seen
  normal.compute(*normals);
  Features::Ptr features(new Features);
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> fpfh;
  fpfh.setInputCloud(points);
  fpfh.setInputNormals(normals);
  fpfh.setRadiusSearch(kFeatureRadius * kVoxel_m);
  fpfh.compute(*features);
  for (pcl::FPFHSignature33& f : *features) {
    for (float& bin : f.histogram) {
      if (!std::isfinite(bin)) bin = 0;
    }
  }
  return features;
}

struct Place {
  Points::Ptr points;
  Features::Ptr features;
};

double shareOnMap(const Points& query, const pcl::search::KdTree<pcl::PointXYZ>& map) {
  std::size_t on = 0;
  pcl::Indices index(1);
  std::vector<float> squared(1);
  for (const pcl::PointXYZ& p : query) {
    if (map.nearestKSearch(p, 1, index, squared) > 0 && squared[0] < kLiesOnMap_m * kLiesOnMap_m)
      ++on;
  }
  return static_cast<double>(on) / static_cast<double>(query.size());
}

/// The method's pose, improved by ICP.
template <class Method>
void report(const char* name, Method& align, const Place& query, const Place& map,
            double features_s) {
  const double start_s = cpuSeconds();
  align.setInputSource(query.points);
  align.setSourceFeatures(query.features);
  align.setInputTarget(map.points);
  align.setTargetFeatures(map.features);
  align.setMaxCorrespondenceDistance(kPartner * kVoxel_m);
  Points aligned;
  align.align(aligned);
  const bool converged = align.hasConverged();
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setInputSource(query.points);
  icp.setInputTarget(map.points);
  icp.setMaxCorrespondenceDistance(kPartner * kVoxel_m);
  icp.setMaximumIterations(kIcpIterations);
  icp.align(aligned, align.getFinalTransformation());
  const double all_s = features_s + cpuSeconds() - start_s;
  pcl::search::KdTree<pcl::PointXYZ> tree;
  tree.setInputCloud(map.points);
  const Eigen::Matrix4f T = icp.getFinalTransformation();
  std::string numbers;
  for (int i = 0; i < 16; ++i) numbers += fmt::format("{}{}", i > 0 ? ", " : "", T(i / 4, i % 4));
  fmt::print(
      "{{\"method\": \"{}\", \"converged\": {}, \"on_map\": {:.3f}, \"cpu_s\": {:.2f}, "
      "\"points\": [{}, {}], \"T_map_query\": [{}]}}\n",
      name, converged, shareOnMap(aligned, tree), all_s, query.points->size(), map.points->size(),
      numbers);
}

void seek(const std::string& path, const Place& map) {
  const double start_s = cpuSeconds();
  const Points::Ptr points = thinned(path);
  const Place query{points, featuresOf(points)};
  const double features_s = cpuSeconds() - start_s;

  pcl::SampleConsensusPrerejective<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> prerejective;
  prerejective.setMaximumIterations(kPrerejectiveIterations);
  prerejective.setNumberOfSamples(3);
  prerejective.setCorrespondenceRandomness(5);
  prerejective.setSimilarityThreshold(0.9f);
  prerejective.setInlierFraction(0.25f);
  report("prerejective", prerejective, query, map, features_s);

  pcl::SampleConsensusInitialAlignment<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> sac_ia;
  sac_ia.setMaximumIterations(kSacIaIterations);
  sac_ia.setMinSampleDistance(static_cast<float>(5 * kVoxel_m));
  report("sac_ia", sac_ia, query, map, features_s);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::cerr << "fpfh_bench MAP.pcd QUERY.pcd...\n";
    return 2;
  }
  const Points::Ptr points = thinned(argv[1]);
  const Place map{points, featuresOf(points)};
  for (int i = 2; i < argc; ++i) seek(argv[i], map);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
