// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "xview/base/labels.h"

namespace xview::io {

struct InputOptions;

/// classes.yaml: {name, classes: [{id, name, color, role, kind, static}]} or the bare list; only id
/// and name must be there. Missing roles are guessed from the names (ClassInfo::guessed); `static:
/// false` makes an object dynamic. A set without a name gets that of the file. Throws Error with
/// path:line.
LabelSet readLabelSet(const std::string& path, const ClassNames& names = ClassNames::shipped());

/// The label sets that come with the program (config/labels/*.yaml, compiled in): "synthia",
/// "semantic_kitti", ….
std::vector<std::string> shippedLabelSets();
LabelSet shippedLabelSet(
    const std::string& name);  ///< throws UsageError that names the nearest known one

/// The classes of what lies in `folder`: options.labels (a shipped name or a file),
/// else what its files say of themselves (`own`), else classes.yaml in the folder; nothing if there
/// is none of them. Throws Error, UsageError.
std::optional<LabelSet> namedLabels(const InputOptions& options, const std::string& folder,
                                    const std::optional<LabelSet>& own = std::nullopt);

/// The table of class names that comes with the program, with the lines of a file asked first.
/// Throws Error.
ClassNames readClassNames(const std::string& path);

}  // namespace xview::io
