// SPDX-License-Identifier: BSD-3-Clause
// The headers of PCD and PLY files, and the classes in their comments.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>

#include "point_table.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

using Words = std::vector<std::string_view>;

/// The words from the one at `first` on, with one blank between two.
std::string joinFrom(const Words& words, std::size_t first) {
  return fmt::format(
      "{}", fmt::join(words.begin() + static_cast<std::ptrdiff_t>(first), words.end(), " "));
}

constexpr std::uint64_t kLongestHeader = std::uint64_t{8} << 20;  // 65,536 classes and more
constexpr std::uint64_t kLongestLine = std::uint64_t{1} << 20;    // of an InputFile

/// The words of the next line of a header; an error if there is none, or if the header is longer
/// than 8 MiB.
Words readHeaderWords(InputFile& file) {
  if (file.position() > kLongestHeader) file.failAtLine("the header does not end within 8 MiB");
  std::string_view line;
  if (!file.readLine(line)) {
    file.fail(file.size() == 0 ? "the file is empty" : "ends within the header");
  }
  return splitWords(line);
}

/// A whole number >= 0 in a line of the header; anything else is an error that names line and
/// `what`.
std::uint64_t parseCount(std::string_view word, const std::string& what, const InputFile& file,
                         std::uint64_t line) {
  const auto value = numberFrom<std::uint64_t>(word);
  if (!value) file.failAtLine(line, what + " must be a whole number >= 0, found " + inQuotes(word));
  return *value;
}

// ---- PCD

/// An entry of the header and the line where it stands.
struct Entry {
  std::vector<std::string> values;
  std::uint64_t line = 0;
};

/// "0" and "0.000" are.
bool isSameNumber(const std::string& a, const std::string& b) {
  return numberFrom<double>(a) == numberFrom<double>(b);
}

class PcdHeader {
 public:
  explicit PcdHeader(InputFile& file) : file_(file) {
    while (entries_.count("DATA") == 0) {
      const Words words = readHeaderWords(file);
      if (words.empty()) continue;
      if (words[0].front() == '#') {
        layout_.comments.push_back(joinFrom(words, 1));
      } else {
        addEntry(words);
      }
    }
  }

  FileLayout layout() {
    const Entry& data = required("DATA");
    layout_.encoding = encodingOf(data);
    layout_.format = "PCD " + data.values.front();
    layout_.elements.resize(1);
    layout_.elements[0].name = "point";
    layout_.elements[0].columns = columns();
    layout_.elements[0].rows = pointCount();
    const auto viewpoint = entries_.find("VIEWPOINT");
    const std::vector<std::string> none{"0", "0", "0", "1", "0", "0", "0"};
    if (viewpoint != entries_.end() && !viewpoint->second.values.empty() &&
        !std::equal(none.begin(), none.end(), viewpoint->second.values.begin(),
                    viewpoint->second.values.end(), isSameNumber))
      layout_.notes.push_back("its VIEWPOINT is not applied to its points, as in PCL");
    return layout_;
  }

 private:
  void addEntry(const Words& words) {
    static constexpr std::string_view kKnown[] = {"VERSION", "FIELDS", "COLUMNS", "SIZE",
                                                  "TYPE",    "COUNT",  "WIDTH",   "VIEWPOINT",
                                                  "HEIGHT",  "POINTS", "DATA"};
    if (std::find(std::begin(kKnown), std::end(kKnown), words[0]) == std::end(kKnown)) {
      file_.failAtLine("expected an entry of a PCD header, found " + inQuotes(words[0]));
    }
    const std::string key(words[0] == "COLUMNS" ? "FIELDS" : words[0]);
    Entry entry{{words.begin() + 1, words.end()}, file_.lineNumber()};
    if (!entries_.emplace(key, std::move(entry)).second)
      file_.failAtLine("a second " + key + " entry");
  }

  const Entry& required(const std::string& key) const {
    const auto found = entries_.find(key);
    if (found == entries_.end()) file_.fail("the header has no " + key + " entry");
    if (found->second.values.empty()) file_.failAtLine(found->second.line, key + " has no value");
    return found->second;
  }

  /// An entry with one value per field.
  const Entry& perField(const std::string& key) const {
    const Entry& entry = required(key);
    const std::size_t fields = required("FIELDS").values.size();
    if (entry.values.size() != fields) {
      file_.failAtLine(entry.line,
                       fmt::format("{} has {} values, expected one for each of the {} FIELDS", key,
                                   entry.values.size(), fields));
    }
    return entry;
  }

  std::optional<std::uint64_t> number(const std::string& key) const {
    if (entries_.count(key) == 0) return std::nullopt;
    const Entry& entry = required(key);
    if (entry.values.size() != 1) file_.failAtLine(entry.line, key + " must be one number");
    return parseCount(entry.values[0], key, file_, entry.line);
  }

  std::vector<Column> columns() const {
    static const std::map<std::string, ScalarType> kTypes = {
        {"I1", ScalarType::i8},  {"U1", ScalarType::u8},  {"I2", ScalarType::i16},
        {"U2", ScalarType::u16}, {"I4", ScalarType::i32}, {"U4", ScalarType::u32},
        {"I8", ScalarType::i64}, {"U8", ScalarType::u64}, {"F4", ScalarType::f32},
        {"F8", ScalarType::f64}};
    const Entry &names = required("FIELDS"), &sizes = perField("SIZE"), &types = perField("TYPE");
    const Entry* counts = entries_.count("COUNT") != 0 ? &perField("COUNT") : nullptr;
    std::vector<Column> columns(names.values.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      Column& column = columns[i];
      column.name = names.values[i];
      const auto type = kTypes.find(types.values[i] + sizes.values[i]);
      if (type == kTypes.end()) {
        file_.failAtLine(
            sizes.line,
            fmt::format("TYPE and SIZE of {} must be I or U with 1 2 4 8, or F with 4 8; found {}",
                        inQuotes(column.name), inQuotes(types.values[i] + " " + sizes.values[i])));
      }
      column.type = type->second;
      if (counts) column.count = parseCount(counts->values[i], "COUNT", file_, counts->line);
      if (column.count == 0)
        file_.failAtLine(counts->line, "COUNT of " + inQuotes(column.name) + " is 0");
    }
    return columns;
  }

  std::uint64_t pointCount() const {
    const auto width = number("WIDTH");
    const std::uint64_t height = number("HEIGHT").value_or(1);
    const auto points = number("POINTS");
    if (!width && !points) file_.fail("the header has neither POINTS nor WIDTH");
    if (!width) return *points;
    std::uint64_t product = 0;
    const bool overflow = __builtin_mul_overflow(*width, height, &product);
    if (overflow || product != points.value_or(product)) {
      file_.fail("the header contradicts itself: WIDTH {} x HEIGHT {}, POINTS {}", *width, height,
                 points ? std::to_string(*points) : "missing");
    }
    return product;
  }

  Encoding encodingOf(const Entry& data) const {
    const std::string& kind = data.values.front();
    if (kind == "ascii") return Encoding::ascii;
    if (kind == "binary") return Encoding::little_endian;
    if (kind == "binary_compressed") return Encoding::compressed;
    file_.failAtLine(data.line,
                     "DATA must be ascii, binary or binary_compressed, found " + inQuotes(kind));
  }

  InputFile& file_;
  FileLayout layout_;
  std::map<std::string, Entry> entries_;
};

// ---- PLY

ScalarType plyType(std::string_view name, const InputFile& file) {
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
  if (found == kTypes.end()) file.failAtLine("unknown type " + inQuotes(name));
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
  if (words[2] != "1.0")
    file.failAtLine("expected format version 1.0, found " + inQuotes(words[2]));
  layout.format = "PLY " + std::string(kind);
}

void readElement(const Words& words, FileLayout& layout, const InputFile& file) {
  if (words.size() != 3) file.failAtLine("expected 'element NAME COUNT'");
  Element element;
  element.name = words[1];
  element.rows = parseCount(words[2], "the count of an element", file, file.lineNumber());
  if (layout.findElement(element.name))
    file.failAtLine("a second element " + inQuotes(element.name));
  layout.elements.push_back(std::move(element));
}

void readProperty(const Words& words, FileLayout& layout, const InputFile& file) {
  if (layout.elements.empty()) file.failAtLine("a property before the first element");
  Column column;
  if (words.size() == 5 && words[1] == "list") {
    column.list_size = plyType(words[2], file);
    if (!isInteger(*column.list_size)) file.failAtLine("the length of a list must be an integer");
    column.type = plyType(words[3], file);
  } else if (words.size() == 3) {
    column.type = plyType(words[1], file);
  } else {
    file.failAtLine("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  }
  column.name = words.back();
  layout.elements.back().columns.push_back(std::move(column));
}

// ---- sizes

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

std::uint64_t saturatingProduct(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? kMost : product;
}

std::uint64_t saturatingSum(std::uint64_t a, std::uint64_t b) {
  std::uint64_t sum = 0;
  return __builtin_add_overflow(a, b, &sum) ? kMost : sum;
}

std::string bytesText(std::uint64_t bytes) {
  return bytes == kMost ? "more than 2^64 bytes" : std::to_string(bytes) + " bytes";
}

// ---- classes in comments

/// A name may hold blanks, but no line ends.
std::string inOneLine(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return name;
}

/// "xview class ID ROLE KIND RED GREEN BLUE NAME"
std::optional<ClassInfo> parseClass(const Words& words) {
  constexpr std::size_t kNameWord = 8;
  if (words.size() < kNameWord) return std::nullopt;  // a name may be empty
  const auto id = numberFrom<std::int64_t>(words[2]);
  const auto role = enumeratorNamed(words[3], Role::ignored);
  const auto kind = enumeratorNamed(words[4], Kind::none);
  if (!id || *id < 0 || *id > std::numeric_limits<std::uint32_t>::max() || !role || !kind)
    return std::nullopt;
  ClassInfo info;
  info.id = static_cast<std::uint32_t>(*id);
  info.role = *role;
  info.kind = *kind;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto value = numberFrom<std::int64_t>(words[5 + channel]);
    if (!value || *value < 0 || *value > 255) return std::nullopt;
    info.color[channel] = static_cast<std::uint8_t>(*value);
  }
  info.name = joinFrom(words, kNameWord);
  return info;
}

}  // namespace

FileLayout readPcdHeader(InputFile& file) { return PcdHeader(file).layout(); }

FileLayout readPlyHeader(InputFile& file) {
  const Words magic = readHeaderWords(file);
  if (magic.size() != 1 || magic[0] != "ply") file.failAtLine("is no PLY file: expected 'ply'");
  FileLayout layout;
  for (;;) {
    const Words words = readHeaderWords(file);
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "comment") {
      layout.comments.push_back(joinFrom(words, 1));
    } else if (words[0] == "format") {
      readFormat(words, layout, file);
    } else if (words[0] == "element") {
      readElement(words, layout, file);
    } else if (words[0] == "property") {
      readProperty(words, layout, file);
    } else {
      file.failAtLine("expected a line of a PLY header, found " + inQuotes(words[0]));
    }
  }
  if (layout.format.empty()) file.failAtLine("the header has no format line");
  for (const Element& element : layout.elements) {
    if (!element.columns.empty() || element.rows == 0) continue;
    // Rows without bytes could be announced in any number.
    file.failAtLine("the element {} has no properties", inQuotes(element.name));
  }
  return layout;
}

bool Element::hasLists() const {
  return std::any_of(columns.begin(), columns.end(),
                     [](const Column& column) { return column.list_size.has_value(); });
}

std::uint64_t Element::rowBytes() const {
  std::uint64_t bytes = 0;
  for (const Column& column : columns) {
    const std::size_t value_bytes = sizeOf(column.list_size.value_or(column.type));
    const std::uint64_t values = column.list_size ? 1 : column.count;
    bytes = saturatingSum(bytes, saturatingProduct(values, value_bytes));
  }
  return bytes;
}

std::optional<std::size_t> Element::findColumn(const std::string& column,
                                               const InputFile& file) const {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].name != column) continue;
    if (found) file.fail("the field {} appears twice in the header", inQuotes(column));
    found = i;
  }
  if (found && (columns[*found].list_size || columns[*found].count != 1)) {
    file.fail("the field {} must be one number per {}", inQuotes(column), name);
  }
  return found;
}

std::string Element::columnNames() const {
  constexpr std::size_t kLongest = 200;
  std::string names;
  for (const Column& column : columns) {
    const std::string printable = inQuotes(column.name);
    names += (names.empty() ? "" : " ") + printable.substr(1, printable.size() - 2);
    if (names.size() > kLongest) return names + " ...";
  }
  return names;
}

const Element* FileLayout::findElement(const std::string& name) const {
  const auto found = std::find_if(elements.begin(), elements.end(),
                                  [&](const Element& element) { return element.name == name; });
  return found == elements.end() ? nullptr : &*found;
}

void checkSize(const InputFile& file, const FileLayout& layout) {
  if (layout.encoding == Encoding::compressed || layout.encoding == Encoding::packets)
    return;  // these have sizes of their own
  // A row of text needs at least a digit and a separator, so that a row that is too short is found
  // by its line; the last line needs no separator.
  const bool text = layout.encoding == Encoding::ascii;
  const std::uint64_t available = file.remaining() + (text ? 1 : 0);
  std::uint64_t needed = 0;
  for (const Element& element : layout.elements) {
    needed = saturatingSum(needed, saturatingProduct(element.rows, text ? 2 : element.rowBytes()));
    if (needed > available) {
      file.fail(
          "is too short for its header: expected {} rows of {}, which need at least {}, found {}",
          element.rows, inQuotes(element.name), bytesText(needed), bytesText(file.remaining()));
    }
  }
}

std::string classComments(const LabelSet& labels, const std::string& mark) {
  if (labels.isGeneric()) return {};
  std::string lines = mark + "xview label_set " + inOneLine(labels.name()) + "\n";
  for (const auto& [id, info] : labels.classes()) {
    const auto& [red, green, blue] = info.color;
    lines += fmt::format("{}xview class {} {} {} {} {} {} {}\n", mark, id, toString(info.role),
                         toString(info.kind), red, green, blue, inOneLine(info.name));
  }
  return lines;
}

std::string pcdHeader(const std::vector<Column>& columns, std::uint64_t points,
                      const std::string& comments) {
  std::string fields, sizes, types, counts;
  for (const Column& column : columns) {
    const bool is_signed = isInteger(column.type) && static_cast<int>(column.type) % 2 == 0;
    const bool is_real = !isInteger(column.type) || column.name == "rgb";
    fields += " " + column.name;
    sizes += fmt::format(" {}", sizeOf(column.type));
    types += is_real ? " F" : is_signed ? " I" : " U";
    counts += " 1";
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\n{}VERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\n"
      "COUNT{}\nWIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      comments, fields, sizes, types, counts, points, points);
}

std::string plyHeader(const std::vector<Column>& columns, std::uint64_t points,
                      const std::string& comments) {
  constexpr const char* kTypes[] = {"char", "uchar", "short",  "ushort", "int",
                                    "uint", "int64", "uint64", "float",  "double"};
  std::string header = "ply\nformat binary_little_endian 1.0\n" + comments;
  header += fmt::format("element vertex {}\n", points);
  for (const Column& column : columns)
    header += fmt::format("property {} {}\n", kTypes[static_cast<int>(column.type)], column.name);
  return header + "end_header\n";
}

void requireReadable(const std::string& path, const std::string& header) {
  std::size_t longest = 0;
  for (std::size_t begin = 0; begin < header.size();) {
    const std::size_t end = std::min(header.find('\n', begin), header.size());
    longest = std::max(longest, end - begin);
    begin = end + 1;
  }
  if (longest <= kLongestLine && header.size() <= kLongestHeader) return;
  throw Error(path,
              fmt::format("cannot be written: the names of its classes would need a header of "
                          "{} bytes with lines of up to {}, expected {} and {} at most; "
                          "shorten the names in classes.yaml",
                          header.size(), longest, kLongestHeader, kLongestLine));
}

namespace {

/// Lower case, without what names are joined by: "SemanticKITTI" and "semantic_kitti" are one.
std::string plainName(std::string_view word) {
  std::string plain;
  for (const char c : word) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

/// Exporters tell the label set in a comment of their own, such as "label = NYU40 id". Short names
/// and `shapes` are words that mean other things as well.
std::optional<LabelSet> shippedSetNamedIn(const std::vector<std::string>& comments) {
  constexpr std::size_t kShortestName = 5;
  for (const std::string& set : shippedLabelSets()) {
    const std::string name = plainName(set);
    if (name.size() < kShortestName || set == "shapes") continue;
    for (const std::string& comment : comments) {
      for (const std::string_view word : splitWords(comment)) {
        if (plainName(word) == name) return shippedLabelSet(set);
      }
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<LabelSet> readClassComments(const std::vector<std::string>& comments,
                                          const InputFile& file) {
  std::string set_name;
  std::vector<ClassInfo> classes;
  for (const std::string& comment : comments) {
    const std::string line = inOneLine(comment);
    const Words words = splitWords(line);
    if (words.size() < 2 || words[0] != "xview") continue;
    if (words[1] == "label_set") set_name = joinFrom(words, 2);
    if (words[1] != "class") continue;
    const auto info = parseClass(words);
    if (!info) {
      file.fail("expected the comment 'xview class ID ROLE KIND RED GREEN BLUE NAME', found '{}'",
                comment);
    }
    classes.push_back(*info);
  }
  if (classes.empty()) return shippedSetNamedIn(comments);
  LabelSet labels(set_name);
  for (ClassInfo& info : classes) labels.add(std::move(info));
  return labels;
}

}  // namespace xview::io
