// SPDX-License-Identifier: BSD-3-Clause
// Headers of others that most files include, parsed once per build instead of once per file (see
// cmake/PrecompiledHeader.cmake). Every file still names what it uses: builds without it must pass.
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>
