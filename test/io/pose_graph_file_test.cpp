// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/pose_files.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "support/test_data.h"
#include "xview/types/localization.h"
#include "xview/types/random.h"

namespace xview::io {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// What a solver would see in the file.
struct ReadBack {
  struct Edge {
    std::size_t from, to;
    Eigen::Isometry3d T;
    Matrix6d information;
  };
  std::map<std::size_t, Eigen::Isometry3d> vertices;
  std::vector<std::size_t> fixed;
  std::vector<Edge> edges;
};

Eigen::Isometry3d readPose(std::istream& in) {
  double x, y, z, qx, qy, qz, qw;
  in >> x >> y >> z >> qx >> qy >> qz >> qw;
  EXPECT_NEAR(qx * qx + qy * qy + qz * qz + qw * qw, 1, 1e-9);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

ReadBack readGraph(const std::string& path) {
  ReadBack graph;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string tag, rest;
    std::size_t id = 0;
    in >> tag >> id;
    if (tag == "VERTEX_SE3:QUAT") {
      EXPECT_TRUE(graph.vertices.emplace(id, readPose(in)).second) << "twice: " << id;
    } else if (tag == "FIX") {
      graph.fixed.push_back(id);
    } else if (tag == "EDGE_SE3:QUAT") {
      ReadBack::Edge edge{id, 0, {}, {}};
      in >> edge.to;
      edge.T = readPose(in);
      for (int r = 0; r < 6; ++r) {
        for (int c = r; c < 6; ++c) {
          in >> edge.information(r, c);
          edge.information(c, r) = edge.information(r, c);
        }
      }
      graph.edges.push_back(edge);
    } else {
      ADD_FAILURE() << line;
    }
    EXPECT_FALSE(in.fail()) << line;
    EXPECT_FALSE(in >> rest) << line;
  }
  return graph;
}

Eigen::Isometry3d pose(double x, double y, double z, double angle, const Eigen::Vector3d& axis) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

PoseGraph smallGraph() {
  PoseGraph graph;
  graph.poses = {Eigen::Isometry3d::Identity(), pose(5, -3, 1, 2.0, {0.1, 0.2, 1}),
                 pose(6, -2, 1.1, -3.0, {0, 0.1, 1})};
  graph.fixed = {0};
  Matrix6d root = Matrix6d::Zero();
  root.diagonal() << 0.3, 0.1, 0.2, 0.01, 0.02, 0.03;
  root(1, 0) = 0.05;
  root(5, 1) = 0.01;
  const Matrix6d covariance = root * root.transpose();
  graph.edges = {{0, 1, graph.poses[1], covariance},
                 {1, 2, graph.poses[1].inverse() * graph.poses[2], covariance}};
  return graph;
}

TEST(PoseGraphFile, IndependentReaderFindsTheSameGraph) {
  const test::TemporaryFolder folder;
  const PoseGraph graph = smallGraph();
  writePoseGraph(folder / "a.g2o", graph);
  const ReadBack back = readGraph(folder / "a.g2o");
  ASSERT_EQ(back.vertices.size(), 3u);
  for (const auto& [id, T] : back.vertices) EXPECT_TRUE(T.isApprox(graph.poses[id], 1e-9)) << id;
  EXPECT_EQ(back.fixed, std::vector<std::size_t>{0});
  ASSERT_EQ(back.edges.size(), 2u);
  EXPECT_EQ(back.edges[1].from, 1u);
  EXPECT_EQ(back.edges[1].to, 2u);
  EXPECT_TRUE(back.edges[1].T.isApprox(graph.edges[1].T_from_to, 1e-9));
}

/// g2o's own error of an edge.
Vector6d errorOf(const Eigen::Isometry3d& measured, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d delta = measured.inverse() * truth;
  Eigen::Quaterniond q(delta.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  Vector6d error;
  error << delta.translation(), q.vec();
  return error;
}

TEST(PoseGraphFile, ChiSquareOfASmallErrorIsThatOfTheCovariance) {
  const test::TemporaryFolder folder;
  const PoseGraph graph = smallGraph();
  writePoseGraph(folder / "a.g2o", graph);
  const ReadBack back = readGraph(folder / "a.g2o");
  Random random(7);
  for (const ReadBack::Edge& edge : back.edges) {
    for (int i = 0; i < 20; ++i) {
      Vector6d d;
      for (int k = 0; k < 6; ++k) d[k] = random.uniform(-1e-3, 1e-3);
      Eigen::Isometry3d truth =
          edge.T;  // t + d, exp(w) R: the increment that the covariance speaks of
      truth.translation() += d.head<3>();
      const Eigen::Vector3d w = d.tail<3>();
      truth.linear() =
          Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix() * truth.linear();
      const Vector6d e = errorOf(edge.T, truth);
      const double expected = d.dot(graph.edges[0].covariance.inverse() * d);
      EXPECT_NEAR(e.dot(edge.information * e), expected, 0.01 * expected);
    }
  }
}

TEST(PoseGraphFile, CovarianceOfZeroStillGivesAFinitePositiveInformation) {
  const test::TemporaryFolder folder;
  PoseGraph graph = smallGraph();
  graph.edges[0].covariance.setZero();
  writePoseGraph(folder / "a.g2o", graph);
  const Matrix6d information = readGraph(folder / "a.g2o").edges[0].information;
  EXPECT_TRUE(information.allFinite());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(information).eigenvalues().minCoeff(), 0);
}

TEST(PoseGraphFile, EdgeToNowhereThrowsAndLeavesNothing) {
  const test::TemporaryFolder folder;
  PoseGraph graph = smallGraph();
  graph.edges[0].to = 3;
  EXPECT_THROW(writePoseGraph(folder / "a.g2o", graph), std::out_of_range);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace xview::io
