// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_header.h"

#include <algorithm>
#include <map>

#include "header_text.h"

namespace xview {
namespace {

/// An entry of the header and the line where it stands.
struct Entry {
  std::vector<std::string> values;
  std::uint64_t line = 0;
};
using Entries = std::map<std::string, Entry>;

bool isKnown(std::string_view key) {
  static constexpr std::string_view kKnown[] = {"VERSION", "FIELDS", "COLUMNS", "SIZE",
                                                "TYPE",    "COUNT",  "WIDTH",   "VIEWPOINT",
                                                "HEIGHT",  "POINTS", "DATA"};
  return std::find(std::begin(kKnown), std::end(kKnown), key) != std::end(kKnown);
}

Entries readEntries(InputFile& file, std::vector<std::string>& comments) {
  Entries entries;
  while (entries.count("DATA") == 0) {
    const std::vector<std::string_view> words = splitWords(readHeaderLine(file));
    if (words.empty()) continue;
    if (words[0].front() == '#') {
      comments.push_back(joinFrom(words, 1));
      continue;
    }
    if (!isKnown(words[0])) {
      file.failAtLine("expected an entry of a PCD header, found " + quoted(words[0]));
    }
    const std::string key(words[0] == "COLUMNS" ? "FIELDS" : words[0]);
    Entry entry{{words.begin() + 1, words.end()}, file.lineNumber()};
    if (!entries.emplace(key, std::move(entry)).second)
      file.failAtLine("a second " + key + " entry");
  }
  return entries;
}

const Entry& requiredEntry(const Entries& entries, const std::string& key, const InputFile& file) {
  const auto found = entries.find(key);
  if (found == entries.end()) file.fail("the header has no " + key + " entry");
  if (found->second.values.empty()) file.failAtLine(found->second.line, key + " has no value");
  return found->second;
}

/// An entry with one value per field.
const Entry& entryPerField(const Entries& entries, const std::string& key, const InputFile& file) {
  const Entry& entry = requiredEntry(entries, key, file);
  const std::size_t fields = requiredEntry(entries, "FIELDS", file).values.size();
  if (entry.values.size() != fields) {
    file.failAtLine(entry.line, key + " has " + std::to_string(entry.values.size()) +
                                    " values, expected one for each of the " +
                                    std::to_string(fields) + " FIELDS");
  }
  return entry;
}

std::optional<ScalarType> findScalarType(const std::string& type_and_size) {
  static const std::map<std::string, ScalarType> kTypes = {
      {"I1", ScalarType::i8},  {"U1", ScalarType::u8},  {"I2", ScalarType::i16},
      {"U2", ScalarType::u16}, {"I4", ScalarType::i32}, {"U4", ScalarType::u32},
      {"I8", ScalarType::i64}, {"U8", ScalarType::u64}, {"F4", ScalarType::f32},
      {"F8", ScalarType::f64}};
  const auto found = kTypes.find(type_and_size);
  return found == kTypes.end() ? std::nullopt : std::optional<ScalarType>(found->second);
}

std::vector<Column> columnsOf(const Entries& entries, const InputFile& file) {
  const Entry& names = requiredEntry(entries, "FIELDS", file);
  const Entry& sizes = entryPerField(entries, "SIZE", file);
  const Entry& types = entryPerField(entries, "TYPE", file);
  const Entry* counts =
      entries.count("COUNT") != 0 ? &entryPerField(entries, "COUNT", file) : nullptr;

  std::vector<Column> columns(names.values.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    Column& column = columns[i];
    column.name = names.values[i];
    const auto type = findScalarType(types.values[i] + sizes.values[i]);
    if (!type) {
      file.failAtLine(sizes.line, "TYPE and SIZE of " + quoted(column.name) +
                                      " must be I or U with 1 2 4 8, or F with 4 8; found " +
                                      quoted(types.values[i] + " " + sizes.values[i]));
    }
    column.type = *type;
    if (counts) column.count = parseCount(counts->values[i], "COUNT", file, counts->line);
    if (column.count == 0)
      file.failAtLine(counts->line, "COUNT of " + quoted(column.name) + " is 0");
  }
  return columns;
}

std::optional<std::uint64_t> findNumber(const Entries& entries, const std::string& key,
                                        const InputFile& file) {
  if (entries.count(key) == 0) return std::nullopt;
  const Entry& entry = requiredEntry(entries, key, file);
  if (entry.values.size() != 1) file.failAtLine(entry.line, key + " must be one number");
  return parseCount(entry.values[0], key.c_str(), file, entry.line);
}

std::uint64_t pointCount(const Entries& entries, const InputFile& file) {
  const auto width = findNumber(entries, "WIDTH", file);
  const std::uint64_t height = findNumber(entries, "HEIGHT", file).value_or(1);
  const auto points = findNumber(entries, "POINTS", file);
  if (!width && !points) file.fail("the header has neither POINTS nor WIDTH");
  if (!width) return *points;
  std::uint64_t product = 0;
  const bool overflow = __builtin_mul_overflow(*width, height, &product);
  if (overflow || product != points.value_or(product)) {
    file.fail("the header contradicts itself: WIDTH " + std::to_string(*width) + " x HEIGHT " +
              std::to_string(height) + ", POINTS " +
              (points ? std::to_string(*points) : "missing"));
  }
  return product;
}

Encoding encodingOf(const Entry& data, const InputFile& file) {
  const std::string& kind = data.values.front();
  if (kind == "ascii") return Encoding::ascii;
  if (kind == "binary") return Encoding::little_endian;
  if (kind == "binary_compressed") return Encoding::compressed;
  file.failAtLine(data.line,
                  "DATA must be ascii, binary or binary_compressed, found " + quoted(kind));
}

}  // namespace

FileLayout readPcdHeader(InputFile& file) {
  FileLayout layout;
  const Entries entries = readEntries(file, layout.comments);
  const Entry& data = requiredEntry(entries, "DATA", file);
  layout.encoding = encodingOf(data, file);
  layout.format = "PCD " + data.values.front();
  Element points;
  points.name = "point";
  points.columns = columnsOf(entries, file);
  points.rows = pointCount(entries, file);
  layout.elements.push_back(std::move(points));
  return layout;
}

}  // namespace xview
