// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "row_reader.h"

namespace xview {

/// The body of a binary_compressed PCD file: two sizes and one LZF block, in which the values of
/// each field stand together.
void readCompressedRows(InputFile& file, const Element& element,
                        const std::vector<std::size_t>& columns, const RowVisitor& visit);

}  // namespace xview
