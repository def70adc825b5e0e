// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <Eigen/Geometry>

#include "world.h"

namespace other_worlds {

// The worlds of styles.h by name.
const std::map<std::string, World (*)(Random&)>& styles();

// The upper three rows of a pose as one line.
void writePose(std::ofstream& out, const Eigen::Isometry3d& pose);
// Names of the classes of a recording, whose labels are one more than those of the world.
void writeClasses(const World& world, const std::filesystem::path& folder);

// What an odometry says of a step that ends at a pose: too long by `scale`, and turned by `yaw`
// about the vertical.
Eigen::Isometry3d drifted(Eigen::Isometry3d step, const Eigen::Isometry3d& pose, double scale,
                          double yaw);

}  // namespace other_worlds
