// SPDX-License-Identifier: BSD-3-Clause
#include "label/shape_voxels.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace xview::label {

Spread spreadOf(const PointSums& sums) {
  const Eigen::Vector3d mean = sums.sum / sums.count;
  const Eigen::Matrix<double, 6, 1> s = sums.squares / sums.count;
  Eigen::Matrix3d covariance;
  covariance << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  covariance -= mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;
  axes.computeDirect(covariance.cast<float>());
  const Eigen::Vector3f l = axes.eigenvalues().cwiseMax(0);
  const float largest = l[2] + 1e-9F;
  return {(l[2] - l[1]) / largest, (l[1] - l[0]) / largest, std::abs(axes.eigenvectors()(2, 0)),
          std::abs(axes.eigenvectors()(2, 2))};
}

std::size_t ShapeVoxels::add(const Eigen::Vector3d& p) {
  const double scale = 1 / finest_m_;
  const LatticeKey key = LatticeKey::of(floorToInt(p.x() * scale), floorToInt(p.y() * scale),
                                        floorToInt(p.z() * scale));
  const std::size_t voxel = levels_[0].numberOf(key, [&] {
    Neighbourhood made;
    made.key = key;
    return made;
  });
  levels_[0][voxel].sums.add(p);
  return voxel;
}

void ShapeVoxels::finish() {
  for (int level = 1; level < kLevels; ++level) {
    auto &fine = levels_[level - 1], &coarse = levels_[level];
    for (std::size_t i = 0; i < fine.size(); ++i) {
      const LatticeKey key = fine[i].key.parent();
      const std::size_t parent = coarse.numberOf(key, [&] {
        Neighbourhood made;
        made.key = key;
        return made;
      });
      fine[i].parent = static_cast<std::int32_t>(parent);
      coarse[parent].sums.add(fine[i].sums);
    }
  }
}

ShapeVoxels::Neighbourhood& ShapeVoxels::around(std::size_t voxel, int level) {
  std::size_t number = voxel;
  for (int l = 0; l < level; ++l) number = static_cast<std::size_t>(levels_[l][number].parent);
  const auto& table = levels_[level];
  Neighbourhood& here = levels_[level][number];
  if (here.is_summed) return here;
  here.is_summed = true;
  for (int i = 0; i < 27; ++i) {
    const std::int32_t j = table.find(here.key.at(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    if (j >= 0) here.around.add(table[static_cast<std::size_t>(j)].sums);
  }
  return here;
}

}  // namespace xview::label
