// SPDX-License-Identifier: BSD-3-Clause
// Two definitions of one name in one namespace are undefined behaviour that no compiler reports
// when they are in different files: the linker takes either.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "architecture/source_files.h"

namespace xview::test {
namespace {

/// Where the bracket that opens at `first` closes, behind it.
std::size_t behindBracket(const std::string& code, std::size_t first, char open, char close) {
  int depth = 0;
  for (std::size_t i = first; i < code.size(); ++i) {
    if (code[i] == open) ++depth;
    if (code[i] == close && --depth == 0) return i + 1;
  }
  return code.size();
}

/// The head of a definition without `template <…>`, attributes, and needless space.
std::string plainHead(std::string head) {
  for (std::size_t at; (at = head.find("template")) != std::string::npos;) {
    const std::size_t open = head.find('<', at);
    head.erase(at, behindBracket(head, open, '<', '>') - at);
  }
  for (const char* attribute : {"__attribute__", "alignas"}) {
    for (std::size_t at; (at = head.find(attribute)) != std::string::npos;)
      head.erase(at, behindBracket(head, head.find('(', at), '(', ')') - at);
  }
  head = std::regex_replace(head, std::regex(R"(\[\[.*?\]\])"), " ");
  head = std::regex_replace(head, std::regex(R"(\s+)"), " ");
  return std::regex_replace(head, std::regex("^ | $"), "");
}

/// A parameter without its name and its default value.
std::string typeOfParameter(std::string parameter) {
  parameter = parameter.substr(0, parameter.find('='));
  static const std::regex named(R"(^(.*[\s&*>])\w+\s*$)");
  std::smatch match;
  if (std::regex_match(parameter, match, named)) parameter = match[1];
  return std::regex_replace(parameter, std::regex(R"(\s)"), "");
}

std::string typesOfParameters(const std::string& list) {
  std::string types, parameter;
  int depth = 0;
  for (const char c : list + ",") {
    if (c == '<' || c == '(' || c == '{') ++depth;
    if (c == '>' || c == ')' || c == '}') --depth;
    if (c != ',' || depth > 0) {
      parameter += c;
      continue;
    }
    const std::string type = typeOfParameter(parameter);
    if (!type.empty()) types += type + ",";
    parameter.clear();
  }
  return types;
}

/// What the text before a `{` at namespace scope defines; empty if it is a variable, or a function
/// that no other file sees.
std::string definedBy(const std::string& text) {
  static const std::regex type(
      R"(^(?:struct|class|union|enum(?: class| struct)?) ([\w:]+(?:<.*?>)?)(?: final)?(?: ?:.*)?$)");
  static const std::regex function(R"(^(.*?)([\w:~]+|operator ?[^\w\s(]+|operator ?\(\)) ?\()");
  const std::string head = plainHead(text);
  std::smatch match;
  if (std::regex_match(head, match, type)) return "type " + match[1].str();
  if (!std::regex_search(head, match, function)) return {};
  const std::string before = match[1];
  if (std::regex_search(before, std::regex(R"(\bstatic\b|=)"))) return {};
  const auto open = static_cast<std::size_t>(match.position(0) + match.length(0) - 1);
  const std::size_t close = behindBracket(head, open, '(', ')');
  return "function " + match[2].str() + "(" +
         typesOfParameters(head.substr(open + 1, close - open - 2)) + ")";
}

/// The names that a file defines in named namespaces, with these.
std::vector<std::string> definitionsIn(const std::string& code) {
  static const std::regex space(R"(^\s*(?:inline )?namespace ?([\w:]*)\s*$)");
  std::vector<std::string> names, scopes;
  std::size_t head = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == ';') head = i + 1;
    if (code[i] == '}' && !scopes.empty()) {
      scopes.pop_back();
      head = i + 1;
    }
    if (code[i] == '(') i = behindBracket(code, i, '(', ')') - 1;  // may hold default values {}
    if (code[i] != '{') continue;
    const std::string text = plainHead(code.substr(head, i - head));
    std::smatch match;
    if (std::regex_match(text, match, space)) {
      if (match[1].length() > 0) {
        scopes.push_back(match[1].str() + "::");
        head = i + 1;
        continue;
      }
    } else if (const std::string name = definedBy(text); !name.empty()) {
      std::string scope;
      for (const std::string& part : scopes) scope += part;
      names.push_back(scope + " " + name);
    }
    i = behindBracket(code, i, '{', '}') - 1;
    head = i + 1;
  }
  return names;
}

TEST(Definitions, AreFoundInATextOfTheirKind) {
  const std::vector<std::string> expected = {
      "a::b:: type S",          "a::b:: type K",
      "a::b:: type E",          "a::b:: function f(int,constT&,)",
      "a::b:: function S::g()", "a::b:: function operator==(S,S,)"};
  EXPECT_EQ(definitionsIn(bareCode(R"(
#define X {
namespace a::b {
struct F;  // struct G {
int h(int);
struct S { int x; void g(); };
template <class T> class K final : public S { };
enum class E : int { one, two };
template <class T, class U = V<T>> int f(int i, const T& t = {}) { if (i) { return 1'000; } return "{"[0]; }
void S::g() { }
static int g() { return 0; }
constexpr int kTable[] = {1, 2};
bool operator==(S a, S b) { return true; }
namespace {
struct Hidden { };
}
}
)")),
            expected);
}

TEST(Definitions, OfANameInANamespaceAreInOneFileOnly) {
  std::map<std::string, std::set<std::string>> files_of;
  for (const SourceFile& file : sourceFiles()) {
    for (const std::string& name : definitionsIn(bareCode(file.text)))
      files_of[name].insert(file.path.lexically_relative(XVIEW_SOURCE_DIR).string());
  }
  EXPECT_GT(files_of.size(), 500u) << "the scan has missed most of the project";
  files_of.erase(" function main(int,char**,)");  // each program has one
  for (const auto& [name, files] : files_of)
    EXPECT_EQ(files.size(), 1u) << name << " is defined in " << testing::PrintToString(files);
}

}  // namespace
}  // namespace xview::test
