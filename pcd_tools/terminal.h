// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>

namespace xview::tools {

/// Columns of the terminal that a stream is written to; nothing if it goes to a file or a pipe, or
/// is null.
std::optional<std::size_t> terminalWidth(std::FILE* stream);

/// Width for text that people read: that of the terminal within reason, 80 columns elsewhere.
std::size_t textWidth(std::FILE* stream);

enum class Ink { plain, dim, bold, green, amber, red };

/// The text in a colour, if the stream is a terminal and neither NO_COLOR nor TERM=dumb forbids it.
std::string inked(const std::string& text, Ink ink, std::FILE* stream);

/// Characters of a UTF-8 text; combining and wide ones count as one.
std::size_t columnsOf(const std::string& text);

/// The text in exactly this number of columns: filled with blanks behind it, or before it.
std::string padded(const std::string& text, std::size_t columns);
std::string rightAligned(const std::string& text, std::size_t columns);

/// The text in at most this number of columns; "…" stands for what is missing at the end, or at the
/// beginning, where paths differ least.
std::string withoutEnd(const std::string& text, std::size_t columns);
std::string withoutBeginning(const std::string& text, std::size_t columns);

/// The text broken at blanks into lines of at most `width` columns; before all but the first stand
/// `indent` more blanks. Line breaks in the text stay. No line break at the end.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent = 0);

}  // namespace xview::tools
