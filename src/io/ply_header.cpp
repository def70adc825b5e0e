// SPDX-License-Identifier: BSD-3-Clause
#include "ply_header.h"

#include <map>

#include "header_text.h"

namespace xview {
namespace {

using Words = std::vector<std::string_view>;

ScalarType scalarType(std::string_view name, const InputFile& file) {
  // The names of the format, those with sizes that most programs accept, and bool, which some write
  // for a byte.
  static const std::map<std::string_view, ScalarType> kTypes = {
      {"char", ScalarType::i8},    {"uchar", ScalarType::u8},    {"short", ScalarType::i16},
      {"ushort", ScalarType::u16}, {"int", ScalarType::i32},     {"uint", ScalarType::u32},
      {"float", ScalarType::f32},  {"double", ScalarType::f64},  {"int8", ScalarType::i8},
      {"uint8", ScalarType::u8},   {"int16", ScalarType::i16},   {"uint16", ScalarType::u16},
      {"int32", ScalarType::i32},  {"uint32", ScalarType::u32},  {"int64", ScalarType::i64},
      {"uint64", ScalarType::u64}, {"float32", ScalarType::f32}, {"float64", ScalarType::f64},
      {"bool", ScalarType::u8}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) file.failAtLine("unknown type " + quoted(name));
  return found->second;
}

void readFormat(const Words& words, FileLayout& layout, const InputFile& file) {
  if (!layout.format.empty()) file.failAtLine("a second format line");
  const std::string_view kind = words.size() == 3 ? words[1] : std::string_view();
  if (kind == "ascii") {
    layout.encoding = Encoding::ascii;
  } else if (kind == "binary_little_endian") {
    layout.encoding = Encoding::little_endian;
  } else if (kind == "binary_big_endian") {
    layout.encoding = Encoding::big_endian;
  } else {
    file.failAtLine("expected 'format ascii|binary_little_endian|binary_big_endian 1.0'");
  }
  if (words[2] != "1.0") file.failAtLine("expected format version 1.0, found " + quoted(words[2]));
  layout.format = "PLY " + std::string(kind);
}

void readElement(const Words& words, FileLayout& layout, const InputFile& file) {
  if (words.size() != 3) file.failAtLine("expected 'element NAME COUNT'");
  Element element;
  element.name = words[1];
  element.rows = parseCount(words[2], "the count of an element", file, file.lineNumber());
  if (layout.findElement(element.name)) file.failAtLine("a second element " + quoted(element.name));
  layout.elements.push_back(std::move(element));
}

void readProperty(const Words& words, FileLayout& layout, const InputFile& file) {
  if (layout.elements.empty()) file.failAtLine("a property before the first element");
  Column column;
  if (words.size() == 5 && words[1] == "list") {
    column.list_size = scalarType(words[2], file);
    if (!isInteger(*column.list_size)) file.failAtLine("the length of a list must be an integer");
    column.type = scalarType(words[3], file);
  } else if (words.size() == 3) {
    column.type = scalarType(words[1], file);
  } else {
    file.failAtLine("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  }
  column.name = words.back();
  layout.elements.back().columns.push_back(std::move(column));
}

/// Rows without bytes could be announced in any number.
void requireProperties(const FileLayout& layout, const InputFile& file) {
  for (const Element& element : layout.elements) {
    if (element.columns.empty() && element.rows > 0) {
      file.failAtLine("the element " + quoted(element.name) + " has no properties");
    }
  }
}

}  // namespace

FileLayout readPlyHeader(InputFile& file) {
  const Words magic = splitWords(readHeaderLine(file));
  if (magic.size() != 1 || magic[0] != "ply") file.failAtLine("is no PLY file: expected 'ply'");
  FileLayout layout;
  for (;;) {
    const Words words = splitWords(readHeaderLine(file));
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      layout.comments.push_back(joinFrom(words, 1));
      continue;
    }
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      readFormat(words, layout, file);
    } else if (words[0] == "element") {
      readElement(words, layout, file);
    } else if (words[0] == "property") {
      readProperty(words, layout, file);
    } else {
      file.failAtLine("expected a line of a PLY header, found " + quoted(words[0]));
    }
  }
  if (layout.format.empty()) file.failAtLine("the header has no format line");
  requireProperties(layout, file);
  return layout;
}

}  // namespace xview
