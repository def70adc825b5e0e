// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element_table.h"

namespace xview {

/// Reads the header of a PLY file up to end_header: all its elements in order. Comments and
/// obj_info are skipped.
FileLayout readPlyHeader(InputFile& file);

}  // namespace xview
