// SPDX-License-Identifier: BSD-3-Clause
#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include "baselines/baseline.h"

namespace xview {
namespace {

using Points = pcl::PointCloud<pcl::PointXYZ>;
using Features = pcl::PointCloud<pcl::FPFHSignature33>;

constexpr double kNormalRadius = 15, kFeatureRadius = 30;  // [m]
constexpr double kMatch = 3;                               // [m]
constexpr int kIterations = 50000;

Points::Ptr pointsOf(const SemanticGraph& graph) {
  Points::Ptr points(new Points);
  for (const Vertex& v : graph.vertices) {
    const Eigen::Vector3f p = v.position.cast<float>();
    points->push_back({p.x(), p.y(), p.z()});
  }
  return points;
}

Features::Ptr featuresOf(const Points::Ptr& points) {
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> normal;
  normal.setInputCloud(points);
  normal.setRadiusSearch(kNormalRadius);
  normal.setViewPoint(0, 0, 1e6f);
  normal.compute(*normals);
  Features::Ptr features(new Features);
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> fpfh;
  fpfh.setInputCloud(points);
  fpfh.setInputNormals(normals);
  fpfh.setRadiusSearch(kFeatureRadius);
  fpfh.compute(*features);
  for (pcl::FPFHSignature33& f : *features) {
    for (float& bin : f.histogram) {
      if (!std::isfinite(bin)) bin = 0;
    }
  }
  return features;
}

class FpfhPrerejective final : public Baseline {
 public:
  explicit FpfhPrerejective(const SemanticGraph& map)
      : points_(pointsOf(map)), features_(featuresOf(points_)) {}

  std::optional<Eigen::Isometry3d> localize(const SemanticGraph& query) const override {
    const Points::Ptr source = pointsOf(query);
    pcl::SampleConsensusPrerejective<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> align;
    align.setInputSource(source);
    align.setSourceFeatures(featuresOf(source));
    align.setInputTarget(points_);
    align.setTargetFeatures(features_);
    align.setMaximumIterations(kIterations);
    align.setNumberOfSamples(3);
    align.setCorrespondenceRandomness(15);
    align.setSimilarityThreshold(0.8f);
    align.setMaxCorrespondenceDistance(kMatch);
    align.setInlierFraction(0.25f);
    Points aligned;
    align.align(aligned);
    if (!align.hasConverged()) return std::nullopt;
    return Eigen::Isometry3d(align.getFinalTransformation().cast<double>());
  }

 private:
  Points::Ptr points_;
  Features::Ptr features_;
};

}  // namespace

std::unique_ptr<Baseline> makeFpfhPrerejective(const SemanticGraph& map) {
  return std::make_unique<FpfhPrerejective>(map);
}

}  // namespace xview
