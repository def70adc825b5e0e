// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element_table.h"

namespace xview {

/// Reads the header of a PCD file up to its DATA line: one element "point". Entries may come in any
/// order; VERSION, COUNT, VIEWPOINT, and either POINTS or WIDTH and HEIGHT may be absent. VIEWPOINT
/// is not applied to the points, as in PCL.
FileLayout readPcdHeader(InputFile& file);

}  // namespace xview
