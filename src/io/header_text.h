// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "input_file.h"

namespace xview {

/// The words of a line, separated by blanks and tabs.
std::vector<std::string_view> splitWords(std::string_view line);

/// The words from the one at `first` on, with one blank between two.
std::string joinFrom(const std::vector<std::string_view>& words, std::size_t first);

/// The next line of a header; an error if there is none, or if the header is longer than 1 MiB.
std::string_view readHeaderLine(InputFile& file);

/// A whole number >= 0 in a line of the header; anything else is an error that names the line and
/// `what`.
std::uint64_t parseCount(std::string_view word, const char* what, const InputFile& file,
                         std::uint64_t line);

}  // namespace xview
