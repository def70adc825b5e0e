// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "element_table.h"
#include "xview/io/cloud_files.h"

namespace xview {

/// Columns of a point element that hold the label and the instance.
struct IdColumns {
  std::optional<std::size_t> label;
  std::optional<std::size_t> instance;
  std::optional<std::size_t> ring;  ///< the beam of a scanner
};

/// The columns that were asked for, else the first of the well-known names. Throws Error if one
/// that was asked for is absent or is not one number per point. A field "ring" that holds anything
/// but one integer per point is somebody else's.
IdColumns findIdColumns(const Element& points, const CloudFields& fields, const InputFile& file);

/// Columns x, y and z, in lower or upper case. Throws Error if one is missing.
std::vector<std::size_t> positionColumns(const Element& points, const InputFile& file);

/// The column of that exact name if it holds one number per row; throws Error if it does not.
std::optional<std::size_t> findScalarColumn(const Element& element, const std::string& name,
                                            const InputFile& file);

}  // namespace xview
