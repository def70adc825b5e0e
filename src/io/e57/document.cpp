// SPDX-License-Identifier: BSD-3-Clause
#include "document.h"

#include <expat.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include "base/user_text.h"

namespace xview::io {
namespace {

constexpr std::uint64_t kLongestXml = std::uint64_t{16} << 20;
constexpr std::size_t kMostNodes = 200000, kDeepest = 32;
constexpr std::size_t kLongestTag = std::size_t{1} << 17;  ///< with its attributes [bytes]

using Crc32c = boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true>;

// ---- XML

struct Node {
  std::string name, text;
  std::map<std::string, std::string> attributes;
  std::vector<Node> children;

  const Node* find(const std::string& child) const {
    const auto found = std::find_if(children.begin(), children.end(),
                                    [&](const Node& node) { return node.name == child; });
    return found == children.end() ? nullptr : &*found;
  }
  std::string attribute(const std::string& key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? std::string() : found->second;
  }
};

/// Builds the tree while expat reads; what it refuses ends the reading.
struct TreeBuilder {
  explicit TreeBuilder(XML_Parser used) : parser(used) {}

  XML_Parser parser;
  Node root;
  std::vector<Node*> open{&root};
  std::size_t nodes = 0;
  std::string refused;

  void refuse(const char* what) {
    if (refused.empty()) refused = what;
    XML_StopParser(parser, XML_FALSE);
  }
  static TreeBuilder& of(void* self) { return *static_cast<TreeBuilder*>(self); }
  static void begin(void* self, const char* name, const char** attributes) {
    TreeBuilder& tree = of(self);
    if (++tree.nodes > kMostNodes || tree.open.size() > kDeepest)
      return tree.refuse("more elements than are read");
    Node& node = tree.open.back()->children.emplace_back();
    node.name = name;
    for (; *attributes; attributes += 2) node.attributes[attributes[0]] = attributes[1];
    tree.open.push_back(&node);
  }
  static void end(void* self, const char*) { of(self).open.pop_back(); }
  static void text(void* self, const char* text, int length) {
    of(self).open.back()->text.append(text, static_cast<std::size_t>(length));
  }
  static void doctype(void* self, const char*, const char*, const char*, int) {
    of(self).refuse("a document type, which E57 does not have");
  }
};

/// The root element.
Node parseXml(const std::string& text, const InputFile& file) {
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                       XML_ParserFree);
  TreeBuilder tree(parser.get());
  XML_SetUserData(parser.get(), &tree);
  XML_SetElementHandler(parser.get(), TreeBuilder::begin, TreeBuilder::end);
  XML_SetCharacterDataHandler(parser.get(), TreeBuilder::text);
  XML_SetStartDoctypeDeclHandler(parser.get(), TreeBuilder::doctype);
  const auto refuse = [&](const std::string& what) {
    file.fail("line {} of its XML: {}", XML_GetCurrentLineNumber(parser.get()), what);
  };
  std::size_t given = 0;
  do {
    // In pieces, so that a tag without end, whose attributes take long, is noticed before it is
    // read.
    const std::size_t piece = std::min(text.size() - given, kLongestTag);
    const bool is_last = given + piece == text.size();
    if (XML_Parse(parser.get(), text.data() + given, static_cast<int>(piece), is_last) !=
        XML_STATUS_OK)
      refuse(tree.refused.empty() ? XML_ErrorString(XML_GetErrorCode(parser.get())) : tree.refused);
    given += piece;
    const auto done = static_cast<std::size_t>(XML_GetCurrentByteIndex(parser.get()));
    if (!is_last && done < given && given - done >= kLongestTag)
      refuse(fmt::format("a tag of more than {} bytes", kLongestTag));
  } while (given < text.size());
  return std::move(tree.root.children.front());
}

/// What an element or attribute says; nothing said is the default.
template <class Number>
Number numberIn(const std::string& text, Number absent, const std::string& name,
                const InputFile& file) {
  const auto words = splitWords(text);
  if (words.empty()) return absent;
  const auto number = words.size() == 1 ? numberFrom<Number>(words[0]) : std::nullopt;
  if (!number || !std::isfinite(static_cast<double>(*number)))
    file.fail("its XML has {} for {}, expected a number", inQuotes(text), inQuotes(name));
  return *number;
}

template <class Number>
Number numberAt(const Node& node, const char* key, Number absent, const InputFile& file) {
  return numberIn<Number>(node.attribute(key), absent, node.name + " " + key, file);
}

E57Field fieldOf(const Node& node, const InputFile& file) {
  E57Field field;
  field.name = node.name;
  const std::string type = node.attribute("type");
  if (type == "Float") {
    field.bits = node.attribute("precision") == "single" ? 32 : 64;
    return field;
  }
  if (type != "Integer" && type != "ScaledInteger")
    file.fail("its points have {} of type {}, expected Float, Integer or ScaledInteger",
              inQuotes(node.name), inQuotes(type));
  using Limits = std::numeric_limits<std::int64_t>;
  field.is_real = false;
  field.minimum = numberAt<std::int64_t>(node, "minimum", Limits::min(), file);
  const auto maximum = numberAt<std::int64_t>(node, "maximum", Limits::max(), file);
  if (maximum < field.minimum)
    file.fail("its XML has a minimum of {} above the maximum", inQuotes(node.name));
  const std::uint64_t range =
      static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(field.minimum);
  field.bits = 0;
  while (field.bits < 64 && range >> field.bits != 0) ++field.bits;
  if (type == "Integer") return field;
  field.scale = numberAt<double>(node, "scale", 1, file);
  field.offset = numberAt<double>(node, "offset", 0, file);
  return field;
}

Eigen::Isometry3d poseOfScan(const Node& scan, const InputFile& file) {
  constexpr double kRounding = 1e-3;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Node* pose = scan.find("pose");
  if (!pose) return T;
  const auto at = [&](const Node& node, const char* axis) {
    const Node* value = node.find(axis);
    return value ? numberIn<double>(value->text, 0, axis, file) : 0;
  };
  if (const Node* shift = pose->find("translation"))
    T.translation() = Eigen::Vector3d(at(*shift, "x"), at(*shift, "y"), at(*shift, "z"));
  if (const Node* turn = pose->find("rotation")) {
    const Eigen::Quaterniond q(at(*turn, "w"), at(*turn, "x"), at(*turn, "y"), at(*turn, "z"));
    if (!(std::abs(q.norm() - 1) < kRounding))
      file.fail("a scan is turned by a quaternion of length {:.3g}, expected 1", q.norm());
    T.linear() = q.normalized().toRotationMatrix();
  }
  return T;
}

/// `left`: bytes of the file that no scan before needs.
E57Scan scanOf(const Node& scan, const E57Pages& pages, std::uint64_t& left) {
  const InputFile& file = pages.file();
  const Node* points = scan.find("points");
  const Node* prototype = points ? points->find("prototype") : nullptr;
  if (!prototype) file.fail("a scan in its XML has no points with a prototype");
  E57Scan result;
  result.points = numberAt<std::uint64_t>(*points, "recordCount", 0, file);
  result.section = pages.withoutSums(numberAt<std::uint64_t>(*points, "fileOffset", 0, file));
  result.T_file_scan = poseOfScan(scan, file);
  std::uint64_t bits = 0;
  for (const Node& node : prototype->children) {
    result.fields.push_back(fieldOf(node, file));
    bits += static_cast<std::uint64_t>(result.fields.back().bits);
  }
  const std::uint64_t bytes = std::max<std::uint64_t>(1, bits / 8);
  if (result.points > left / bytes)
    file.fail(
        "is too short for its XML: a scan of {} points needs {} bytes for each, the file has "
        "{} for all scans",
        result.points, bytes, file.size());
  left -= result.points * bytes;
  return result;
}

}  // namespace

E57Pages::E57Pages(InputFile& file) : file_(file) {
  char header[48];
  if (file.size() < sizeof(header))
    file.fail("expected an E57 header of 48 bytes, the file has {}", file.size());
  file.seek(0);
  file.readBytes(header, sizeof(header));
  if (std::string_view(header, 8) != "ASTM-E57")
    file.fail("expected an E57 file, which begins with ASTM-E57, found {}",
              inQuotes(std::string_view(header, 8)));
  const auto word = [&](int at) { return storedNumber<std::uint64_t>(header + at, false); };
  if (storedNumber<std::uint32_t>(header + 8, false) != 1)
    file.fail("expected E57 1.x, found version {}", storedNumber<std::uint32_t>(header + 8, false));
  if (word(40) != kPage) file.fail("expected pages of {} bytes, found {}", kPage, word(40));
  if (word(16) != file.size() || file.size() % kPage != 0)
    file.fail("its header says {} bytes, in pages of {}, the file has {}; was it cut off?",
              word(16), kPage, file.size());
  const std::uint64_t begin = withoutSums(word(24)), length = word(32);
  if (length > kLongestXml || length > size() - begin)
    file.fail("its XML of {} bytes from byte {} on is longer than the file or {} bytes", length,
              word(24), kLongestXml);
  xml_.resize(static_cast<std::size_t>(length));
  seek(begin);
  read(xml_.data(), xml_.size());
}

std::uint64_t E57Pages::withoutSums(std::uint64_t physical) const {
  if (physical >= file_.size() || physical % kPage >= kContent)
    file_.fail("points to byte {}, where it has no content", physical);
  return physical / kPage * kContent + physical % kPage;
}

void E57Pages::seek(std::uint64_t position) {
  if (position > size()) file_.fail("ends at a page where more is expected");
  position_ = position;
}

void E57Pages::readPage(std::uint64_t index) {
  file_.seek(index * kPage);
  file_.readBytes(page_.data(), kPage);
  // All else is little-endian, but the sums that every program writes are not.
  Crc32c sum;
  sum.process_bytes(page_.data(), kContent);
  if (sum.checksum() != storedNumber<std::uint32_t>(&page_[kContent], true))
    file_.fail("the page from byte {} on is damaged: its CRC-32C is another", index * kPage);
  page_index_ = index;
}

void E57Pages::read(void* data, std::size_t bytes) {
  if (bytes > size() - position_) file_.fail("ends where {} bytes more are expected", bytes);
  for (auto* to = static_cast<char*>(data); bytes > 0;) {
    if (position_ / kContent != page_index_) readPage(position_ / kContent);
    const std::size_t from = position_ % kContent, some = std::min(bytes, kContent - from);
    std::copy_n(&page_[from], some, to);
    to += some;
    bytes -= some;
    position_ += some;
  }
}

E57Document readE57Document(const E57Pages& pages) {
  const Node root = parseXml(pages.xml(), pages.file());
  E57Document document;
  const Node* scans = root.find("data3D");
  if (root.name != "e57Root" || !scans)
    pages.file().fail("its XML has no e57Root with data3D; it holds no scans");
  std::uint64_t left = pages.size();
  for (const Node& scan : scans->children) document.scans.push_back(scanOf(scan, pages, left));
  if (document.scans.empty()) pages.file().fail("has no scans");
  if (const std::size_t setup = setupPathOf(pages.file().path()).setup) {
    if (setup > document.scans.size())
      pages.file().fail("there is no such setup: it has {} of them", document.scans.size());
    document.scans = {document.scans[setup - 1]};
  }
  if (const Node* text = root.find("coordinateMetadata")) document.coordinates = text->text;
  return document;
}

}  // namespace xview::io
