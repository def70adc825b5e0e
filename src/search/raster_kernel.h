// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The inner loop of the raster search on raw arrays. No Eigen and no PCL headers here: the
// functions are compiled for several instruction sets.

#include <cstddef>
#include <cstdint>

namespace xview::search {

constexpr int kBlock = 64;  ///< columns of a block; also the side of a tile

/// A cell of the block whose sum reached the threshold.
struct BlockHit {
  std::uint16_t row, column;
  std::uint32_t sum;
};

/// Sums of one byte per sample for every cell of a block of up to 64 rows of 64 cells.
struct BlockScan {
  const std::uint8_t* const*
      samples;  ///< what each sample adds to row 0, column 0; further cells follow by stride
  const std::uint32_t*
      groups;  ///< group g is samples [groups[g], groups[g + 1]); no sum of a group exceeds 255
  std::size_t group_count;
  std::ptrdiff_t stride;    ///< bytes between rows
  int rows;                 ///< 1 to 64
  std::uint32_t threshold;  ///< cells with a sum of at least this are reported; at least 1
};

/// Writes the hits in row-major order (room for rows * 64 of them) and returns their number.
using ScanFunction = std::size_t (*)(const BlockScan& scan, BlockHit* hits);

struct ScanVariant {
  const char* name;
  ScanFunction function;
};

/// Variants that this processor can run, the fastest first; the last is compiled for every
/// processor. All give the same hits.
struct ScanVariants {
  ScanVariant variant[3];
  int count;
};
const ScanVariants& scanVariants();

}  // namespace xview::search
