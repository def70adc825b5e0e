// SPDX-License-Identifier: BSD-3-Clause
#include "pfm_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "header_text.h"
#include "input_file.h"
#include "number_words.h"
#include "xview/types/error.h"

namespace xview {
namespace {

struct PfmHeader {
  int width = 0;
  int height = 0;
  bool little_endian = true;
};

/// Three lines: "Pf", "width height", "scale".
PfmHeader readHeader(InputFile& file) {
  std::string_view line;
  if (!file.readLine(line) || line != "Pf") {
    file.fail(line == "PF" ? "expected one channel (Pf), found a colour PFM (PF)"
                           : "not a PFM file: expected Pf, found " + quoted(line));
  }
  PfmHeader header;
  std::vector<std::string_view> words;
  if (file.readLine(line)) words = splitWords(line);
  const auto side = [&](std::size_t i) {
    const auto value = i < words.size() ? asInteger(words[i]) : std::nullopt;
    if (!value || *value < 1 || *value > 32768 || words.size() != 2) {
      file.failAtLine("expected width and height, 1 to 32768 each, found " + quoted(line));
    }
    return static_cast<int>(*value);
  };
  header.width = side(0);
  header.height = side(1);
  if (!file.readLine(line)) file.fail("ends before the scale");
  const auto scale = asNumber(line);
  if (!scale || !std::isfinite(*scale) || *scale == 0) {
    file.failAtLine("expected a scale that is not 0, found " + quoted(line));
  }
  header.little_endian = *scale < 0;
  return header;
}

}  // namespace

Image<float> readPfm(const std::string& path) {
  InputFile file(path);
  const PfmHeader header = readHeader(file);
  const std::uint64_t row_bytes = std::uint64_t{4} * header.width;
  if (file.remaining() != row_bytes * header.height) {
    file.fail("expected " + std::to_string(row_bytes * header.height) + " bytes for " +
              std::to_string(header.width) + " x " + std::to_string(header.height) +
              " pixels, found " + std::to_string(file.remaining()));
  }
  Image<float> image(header.width, header.height);
  std::vector<unsigned char> row(row_bytes);
  for (int y = header.height - 1; y >= 0; --y) {
    file.readBytes(row.data(), row.size());
    if (!header.little_endian) {
      for (std::size_t i = 0; i < row.size(); i += 4) std::reverse(&row[i], &row[i] + 4);
    }
    std::memcpy(&image.at(0, y), row.data(), row.size());
  }
  return image;
}

}  // namespace xview
