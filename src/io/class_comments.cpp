// SPDX-License-Identifier: BSD-3-Clause
#include "class_comments.h"

#include <algorithm>
#include <limits>

#include "header_text.h"
#include "number_words.h"

namespace xview {
namespace {

constexpr std::size_t kNameWord = 8;  ///< position of NAME in the line of a class

/// The enumerator of 0 to `last` with this name.
template <class Enum>
std::optional<Enum> enumerator(std::string_view name, Enum last) {
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (name == toString(static_cast<Enum>(i))) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

/// A name may hold blanks, but no line ends.
std::string inOneLine(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return name;
}

std::optional<ClassInfo> parseClass(const std::vector<std::string_view>& words) {
  if (words.size() <= kNameWord) return std::nullopt;
  const auto id = asInteger(words[2]);
  const auto role = enumerator(words[3], Role::ignored);
  const auto kind = enumerator(words[4], Kind::none);
  if (!id || *id < 0 || *id > std::numeric_limits<std::uint32_t>::max() || !role || !kind)
    return std::nullopt;
  ClassInfo info;
  info.id = static_cast<std::uint32_t>(*id);
  info.role = *role;
  info.kind = *kind;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto value = asInteger(words[5 + channel]);
    if (!value || *value < 0 || *value > 255) return std::nullopt;
    info.color[channel] = static_cast<std::uint8_t>(*value);
  }
  info.name = joinFrom(words, kNameWord);
  return info;
}

}  // namespace

std::string classComments(const LabelSet& labels, const std::string& mark) {
  if (labels.isGeneric()) return {};
  std::string lines = mark + "xview label_set " + inOneLine(labels.name()) + "\n";
  for (const auto& [id, info] : labels.classes()) {
    lines += mark + "xview class " + std::to_string(id) + " " + toString(info.role) + " " +
             toString(info.kind);
    for (const std::uint8_t channel : info.color) lines += " " + std::to_string(channel);
    lines += " " + inOneLine(info.name) + "\n";
  }
  return lines;
}

std::optional<LabelSet> readClassComments(const std::vector<std::string>& comments,
                                          const InputFile& file) {
  std::string set_name;
  std::vector<ClassInfo> classes;
  for (const std::string& comment : comments) {
    const std::vector<std::string_view> words = splitWords(comment);
    if (words.size() < 2 || words[0] != "xview") continue;
    if (words[1] == "label_set") set_name = joinFrom(words, 2);
    if (words[1] != "class") continue;
    const auto info = parseClass(words);
    if (!info) {
      file.fail("expected the comment 'xview class ID ROLE KIND RED GREEN BLUE NAME', found '" +
                comment + "'");
    }
    classes.push_back(*info);
  }
  if (classes.empty()) return std::nullopt;
  LabelSet labels(set_name);
  for (ClassInfo& info : classes) labels.add(std::move(info));
  return labels;
}

}  // namespace xview
