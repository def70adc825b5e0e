// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "listed_recording.h"

namespace xview {

/// The label set that the user or the data name: options.labels (a shipped name or a YAML file),
/// else classes.yaml in the folder; nothing if neither is there.
std::optional<LabelSet> namedLabels(const InputOptions& options, const std::string& folder);

/// A generic set of the ids that occur.
LabelSet genericLabels(const LabelCounts& counts);

/// SemanticKITTI labels exist in three id spaces that no file names: raw ids, the 19 training
/// classes counted from 1, and from 0. Ids that only one of them has decide; else the ground,
/// facades and vegetation that make up most of any scan. Ids of none of them give a generic set.
/// LabelSet::name() tells which.
LabelSet semanticKittiLabels(const LabelCounts& counts);

}  // namespace xview
