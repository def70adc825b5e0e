// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/pose_graph_file.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "xview/io/atomic_file.h"

namespace xview {
namespace {

/// g2o's error of an edge is (translation, quaternion vector part) of T_measured^-1 * T_from_to: in
/// the axes of `to`.
Matrix6d informationOf(const PoseGraph::Edge& edge) {
  Matrix6d to_error = Matrix6d::Zero();
  to_error.topLeftCorner<3, 3>() = edge.T_from_to.linear().transpose();
  to_error.bottomRightCorner<3, 3>() = 0.5 * edge.T_from_to.linear().transpose();
  Matrix6d covariance = edge.covariance;
  covariance.diagonal().head<3>().array() += 1e-6;  // 1 mm
  covariance.diagonal().tail<3>().array() += 1e-8;  // 1e-4 rad
  const Matrix6d of_error = to_error * covariance * to_error.transpose();
  const Matrix6d information = of_error.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (information + information.transpose());
}

std::string numbersOf(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q(T.linear());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d t = T.translation();
  char text[240];
  std::snprintf(text, sizeof text, " %.12g %.12g %.12g %.12g %.12g %.12g %.12g", t.x(), t.y(),
                t.z(), q.x(), q.y(), q.z(), q.w());
  return text;
}

std::string lineOf(const PoseGraph::Edge& edge) {
  std::string line = "EDGE_SE3:QUAT " + std::to_string(edge.from) + " " + std::to_string(edge.to) +
                     numbersOf(edge.T_from_to);
  const Matrix6d information = informationOf(edge);
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      char number[32];
      std::snprintf(number, sizeof number, " %.9g", information(row, column));
      line += number;
    }
  }
  return line + "\n";
}

}  // namespace

void writePoseGraph(const std::string& path, const PoseGraph& graph) {
  AtomicFile file(path);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    file.write("VERTEX_SE3:QUAT " + std::to_string(i) + numbersOf(graph.poses[i]) + "\n");
  }
  for (const std::size_t i : graph.fixed) file.write("FIX " + std::to_string(i) + "\n");
  for (const PoseGraph::Edge& edge : graph.edges) {
    if (std::max(edge.from, edge.to) >= graph.poses.size())
      throw std::out_of_range("edge between poses that do not exist");
    file.write(lineOf(edge));
  }
  file.commit();
}

}  // namespace xview
