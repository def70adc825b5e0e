// SPDX-License-Identifier: BSD-3-Clause
#include "recording.h"

#include <cstdio>

#include "styles.h"

namespace other_worlds {

const std::map<std::string, World (*)(Random&)>& styles() {
  static const std::map<std::string, World (*)(Random&)> all{
      {"forest", forest},     {"oldtown", oldTown},
      {"motorway", motorway}, {"village_slope", village},
      {"carpark", carPark},   {"warehouse", warehouse},
      {"home", home}};
  return all;
}

void writePose(std::ofstream& out, const Eigen::Isometry3d& pose) {
  for (int i = 0; i < 12; ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "%.9g%c", pose.matrix()(i / 4, i % 4),
                  i < 11 ? ' ' : '\n');
    out << number;
  }
}

void writeClasses(const World& world, const std::filesystem::path& folder) {
  std::ofstream classes(folder / "classes.yaml");
  classes << "- {id: 0, name: \"unlabelled\"}\n";
  for (size_t i = 0; i < world.classes.size(); ++i)
    classes << "- {id: " << i + 1 << ", name: \"" << world.classes[i] << "\"}\n";
}

Eigen::Isometry3d drifted(Eigen::Isometry3d step, const Eigen::Isometry3d& pose, double scale,
                          double yaw) {
  step.translation() *= scale;
  step.linear() =
      step.linear() *
      Eigen::AngleAxisd(yaw, pose.linear().transpose() * Vector3d::UnitZ()).toRotationMatrix();
  return step;
}

}  // namespace other_worlds
