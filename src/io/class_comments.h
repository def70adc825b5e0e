// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input_file.h"
#include "xview/types/labels.h"

namespace xview {

// Clouds and graphs name their classes themselves, in comments of their header that other programs
// skip: `xview class ID ROLE KIND RED GREEN BLUE NAME`, after one line `xview label_set NAME`.

/// The lines, each after `mark` ("# " in PCD, "comment " in PLY) and ended; none for a generic set,
/// whose names say nothing.
std::string classComments(const LabelSet& labels, const std::string& mark);

/// The classes that the comments of a header name; none if it names none. Throws Error if one of
/// them is not as written by classComments.
std::optional<LabelSet> readClassComments(const std::vector<std::string>& comments,
                                          const InputFile& file);

}  // namespace xview
