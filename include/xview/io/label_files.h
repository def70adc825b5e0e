// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/types/labels.h"

namespace xview {

/// classes.yaml: {classes: [{id, name, color, role, static}]} or the bare list. Missing roles are guessed from the names (ClassInfo::guessed);
/// `static: false` makes an object dynamic. Throws Error with path:line.
LabelSet readLabelSet(const std::string& path);

/// The label sets that come with the program (config/labels/*.yaml, compiled in): "synthia", "semantic_kitti", ….
std::vector<std::string> shippedLabelSets();
LabelSet shippedLabelSet(const std::string& name);  ///< throws UsageError that names the nearest known one

}  // namespace xview
