// SPDX-License-Identifier: BSD-3-Clause
#include "terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace xview::tools {
namespace {

bool hasColors(std::FILE* stream) {
  const char* no_color = std::getenv("NO_COLOR");  // https://no-color.org
  const char* term = std::getenv("TERM");
  return stream && isatty(fileno(stream)) == 1 && !(no_color && *no_color) &&
         !(term && std::strcmp(term, "dumb") == 0);
}

bool continuesCharacter(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

/// Position behind this number of characters.
std::size_t bytesOf(const std::string& text, std::size_t characters) {
  std::size_t byte = 0;
  for (; byte < text.size(); ++byte) {
    if (!continuesCharacter(text[byte]) && characters-- == 0) break;
  }
  return byte;
}

/// A line that fits keeps its blanks, which may be columns.
std::string wrappedLine(const std::string& text, std::size_t width, std::size_t indent) {
  if (columnsOf(text) <= width) return text;
  std::istringstream words(text);
  // Blanks before the text belong to its shape.
  std::string result(std::min(text.find_first_not_of(' '), text.size()), ' ');
  std::size_t column = result.size();
  bool is_first = true;
  for (std::string word; words >> word; is_first = false) {
    const std::size_t length = columnsOf(word);
    if (!is_first && column + 1 + length > width) {
      result += "\n" + std::string(indent, ' ');
      column = 0;
    } else if (!is_first) {
      result += ' ';
      ++column;
    }
    result += word;
    column += length;
  }
  return result;
}

}  // namespace

std::optional<std::size_t> terminalWidth(std::FILE* stream) {
  if (!stream || isatty(fileno(stream)) != 1) return std::nullopt;
  winsize size{};
  const bool is_known = ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? std::max<std::size_t>(size.ws_col, 40) : 80;
}

std::size_t textWidth(std::FILE* stream) {
  return std::min<std::size_t>(terminalWidth(stream).value_or(80), 120);  // longer lines read badly
}

std::string inked(const std::string& text, Ink ink, std::FILE* stream) {
  constexpr const char* kCodes[] = {"", "\x1b[2m", "\x1b[1m", "\x1b[32m", "\x1b[33m", "\x1b[31m"};
  if (ink == Ink::plain || text.empty() || !hasColors(stream)) return text;
  return kCodes[static_cast<int>(ink)] + text + "\x1b[0m";
}

std::size_t columnsOf(const std::string& text) {
  std::size_t columns = 0;
  bool is_code = false;  // of a colour, which takes no room
  for (const char c : text) {
    is_code = is_code || c == '\x1b';
    columns += !is_code && !continuesCharacter(c);
    is_code = is_code && c != 'm';
  }
  return columns;
}

std::string padded(const std::string& text, std::size_t columns) {
  return text + std::string(columns - std::min(columns, columnsOf(text)), ' ');
}

std::string rightAligned(const std::string& text, std::size_t columns) {
  return std::string(columns - std::min(columns, columnsOf(text)), ' ') + text;
}

std::string withoutEnd(const std::string& text, std::size_t columns) {
  if (columnsOf(text) <= columns) return text;
  return columns == 0 ? std::string() : text.substr(0, bytesOf(text, columns - 1)) + "…";
}

std::string withoutBeginning(const std::string& text, std::size_t columns) {
  const std::size_t characters = columnsOf(text);
  if (characters <= columns) return text;
  return columns == 0 ? std::string() : "…" + text.substr(bytesOf(text, characters - columns + 1));
}

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::istringstream lines(text);
  std::string result;
  bool is_first = true;
  for (std::string line; std::getline(lines, line); is_first = false)
    result += (is_first ? "" : "\n" + std::string(indent, ' ')) + wrappedLine(line, width, indent);
  return result;
}

}  // namespace xview::tools
