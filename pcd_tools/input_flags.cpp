// SPDX-License-Identifier: BSD-3-Clause
// The flags of inputs belong to the program: who calls it as a library has none.
#include "inputs.h"
#include "windows.h"

namespace xview::tools {

void InputFlags::declare(Flags& flags) {
  flags.add("--frames A:B[:STEP]", frames_, "only these frames, half-open, by position");
  flags.rare().add(
      "--input-kind KIND", kind_,
      "what the input is, if its path fits two kinds: sequence, semantic_kitti, cloud, "
      "cloud_folder, graph, map, synthia, airsim, tum_rgbd, virtual_kitti, carla, bag");
  flags.add("--labels SET", labels_, "label set: a shipped one by name, or a classes.yaml");
  flags.rare().add("--class-names", class_names_,
                   "file of names that mean the same class, asked before the ones that the program "
                   "knows (config/class_names.txt)");
  flags.rare().add("--label-field NAME", label_field_, "field of a cloud that holds the class");
  flags.rare().add("--instance-field NAME", instance_field_,
                   "field of a cloud that holds the instance");
  flags.rare().add("--mount POSE", mount_,
                   "x,y,z,roll,pitch,yaw of the camera of an AirSim recording on its vehicle, x "
                   "forward, z down [m, deg]");
  flags.rare().add("--topic NAME", topic_, "topic of a bag with its clouds or depth images");
  flags.rare().add("--odometry NAME", odometry_,
                   "topic of a bag with its odometry, poses or transforms");
}

void InputFlags::declareWithMap(Flags& flags) {
  declare(flags);
  flags.add("--map-labels SET", map_labels_,
            "label set of a MAP that is not an .xvm; --labels is then that of the others only");
}

void VerdictFlags::declare(Flags& flags) {
  flags.add("--risk", risk_,
            "accept a pose that is wrong with at most this chance; 0 = 1 - min_confidence");
  const Flags rare = flags.rare();
  rare.add("--timeout SECONDS", limits_.time_s,
           "a query that takes longer is rejected, with \"budget_exhausted\" in its JSON; 0 = no "
           "bound");
  rare.add("--max-memory MB", limits_.memory_mb,
           "so is one that needs more memory, beyond what the program has when it begins, the map "
           "included; 0 = no bound");
}

void VerdictFlags::applyTo(Job& job) const {
  requireValid(job.limits = limits_);
  if (risk_ != 0) acceptAtRisk("--risk", risk_, job.options.verdict);
}

}  // namespace xview::tools
