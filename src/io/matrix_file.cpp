// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/matrix_file.h"

#include <cstdio>

#include "xview/io/atomic_file.h"

namespace xview {

void writeMatrix(const std::string& path, const Eigen::Isometry3d& T_target_source, double scale) {
  AtomicFile file(path);
  Eigen::Matrix4d m = T_target_source.matrix();
  m.topLeftCorner<3, 3>() *= scale;
  for (int row = 0; row < 4; ++row) {
    char line[120];
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g %.17g\n", m(row, 0), m(row, 1), m(row, 2),
                  m(row, 3));
    file.write(line);
  }
  file.commit();
}

}  // namespace xview
