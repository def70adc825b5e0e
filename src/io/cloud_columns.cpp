// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_columns.h"

namespace xview {
namespace {

constexpr const char* kLabelNames[] = {"label",
                                       "class",
                                       "semantic",
                                       "sem_label",
                                       "scalar_Label",
                                       "scalar_label",
                                       "scalar_Classification",
                                       "classification",
                                       "scalar_Class"};
constexpr const char* kInstanceNames[] = {"instance", "object", "ins_label", "scalar_Instance",
                                          "scalar_Object"};

template <std::size_t N>
std::optional<std::size_t> findFirst(const Element& points, const std::string& asked,
                                     const char* const (&well_known)[N], const InputFile& file) {
  if (!asked.empty()) {
    const auto column = findScalarColumn(points, asked, file);
    if (!column)
      file.fail("has no field " + quoted(asked) + "; its fields: " + points.columnNames());
    return column;
  }
  for (const char* name : well_known) {
    const auto column = findScalarColumn(points, name, file);
    if (column) return column;
  }
  return std::nullopt;
}

std::optional<std::size_t> findRing(const Element& points) {
  for (std::size_t i = 0; i < points.columns.size(); ++i) {
    const Column& column = points.columns[i];
    if (column.name == "ring" && isInteger(column.type) && !column.list_size && column.count == 1)
      return i;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::size_t> findScalarColumn(const Element& element, const std::string& name,
                                            const InputFile& file) {
  const auto found = element.findColumn(name, file);
  if (!found) return std::nullopt;
  const Column& column = element.columns[*found];
  if (column.list_size || column.count != 1) {
    file.fail("the field " + quoted(name) + " must be one number per " + element.name);
  }
  return found;
}

IdColumns findIdColumns(const Element& points, const CloudFields& fields, const InputFile& file) {
  IdColumns columns;
  columns.label = findFirst(points, fields.label, kLabelNames, file);
  columns.instance = findFirst(points, fields.instance, kInstanceNames, file);
  columns.ring = findRing(points);
  if (columns.ring == columns.label || columns.ring == columns.instance) columns.ring.reset();
  if (columns.label && columns.label == columns.instance) {
    file.fail("the field " + quoted(fields.label) + " cannot be label and instance at once");
  }
  return columns;
}

std::vector<std::size_t> positionColumns(const Element& points, const InputFile& file) {
  std::vector<std::size_t> columns;
  for (const std::string axis : {"x", "y", "z"}) {
    auto column = findScalarColumn(points, axis, file);
    if (!column)
      column = findScalarColumn(points, axis == "x" ? "X" : axis == "y" ? "Y" : "Z", file);
    if (!column) file.fail("has no field " + axis + "; its fields: " + points.columnNames());
    columns.push_back(*column);
  }
  return columns;
}

}  // namespace xview
