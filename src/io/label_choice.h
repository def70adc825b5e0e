// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "listed_recording.h"

namespace xview {

/// The classes of a recording of which only the ids are known: options.unnamed if it knows nearly
/// all of them, else SemanticKITTI's if they can be no others, else a generic set.
LabelSet labelsOfIds(const LabelCounts& counts, const InputOptions& options);

/// SemanticKITTI labels exist in three id spaces that no file names: raw ids, the 19 training
/// classes counted from 1, and from 0. Ids that only one of them has decide; else
/// options.unnamed if it is of another data set, else the ground, facades and vegetation that make
/// up most of any scan. Ids of none of them are taken as by labelsOfIds().
/// LabelSet::name() tells which.
LabelSet semanticKittiLabels(const LabelCounts& counts, const InputOptions& options);

}  // namespace xview
