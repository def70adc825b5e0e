// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_compressed.h"

#include "lzf.h"

namespace xview {
namespace {

/// Reads and unpacks the block; all sizes are checked before memory is taken for them.
std::vector<unsigned char> readBlock(InputFile& file, const Element& element) {
  std::uint32_t sizes[2] = {};  // packed, unpacked
  if (file.remaining() < sizeof(sizes)) file.fail("ends before the sizes of the compressed block");
  file.readBytes(sizes, sizeof(sizes));
  std::uint64_t expected = 0;
  if (__builtin_mul_overflow(element.rows, rowBytes(element), &expected) || sizes[1] != expected) {
    file.fail("the compressed block unpacks to " + std::to_string(sizes[1]) + " bytes, expected " +
              std::to_string(element.rows) + " points of " + std::to_string(rowBytes(element)) +
              " bytes");
  }
  if (sizes[0] > file.remaining()) {
    file.fail("the compressed block has " + std::to_string(sizes[0]) + " bytes, but only " +
              std::to_string(file.remaining()) + " follow");
  }
  if (sizes[1] / kLargestLzfExpansion > sizes[0]) {
    file.fail(std::to_string(sizes[0]) + " compressed bytes cannot unpack to " +
              std::to_string(sizes[1]));
  }
  std::vector<unsigned char> packed(sizes[0]), unpacked(sizes[1]);
  file.readBytes(packed.data(), packed.size());
  if (!decompressLzf(packed.data(), packed.size(), unpacked.data(), unpacked.size())) {
    file.fail("the compressed block is damaged");
  }
  return unpacked;
}

}  // namespace

void readCompressedRows(InputFile& file, const Element& element,
                        const std::vector<std::size_t>& columns, const RowVisitor& visit) {
  if (element.rows == 0) return;
  const std::vector<unsigned char> block = readBlock(file, element);
  std::vector<const char*> begins;
  const char* next = reinterpret_cast<const char*>(block.data());
  for (const Column& column : element.columns) {
    begins.push_back(next);
    next += element.rows * column.count * sizeOf(column.type);
  }
  std::vector<double> values(columns.size());
  RowPlace place{file, element};
  for (; place.row < element.rows; ++place.row) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const ScalarType type = element.columns[columns[i]].type;
      values[i] = decodeScalar(begins[columns[i]] + place.row * sizeOf(type), type, false);
    }
    visit(values.data(), place);
  }
}

}  // namespace xview
