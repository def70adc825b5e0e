// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "base/random.h"
#include "base/user_text.h"

namespace xview {
namespace {

TEST(Printable, KeepsWritingOfAllKinds) {
  for (const char* text :
       {"", "pole 7", "Mülltonne", "電柱", "\xF0\x9F\x9A\x97", "a\"b'c\\d", "\xC2\xA0"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsWhatWouldSteerATerminal) {
  EXPECT_EQ(printable("\x1b[31mred\x07\x7f"), "\\x1b[31mred\\x07\\x7f");
  EXPECT_EQ(printable("two\r\nlines\t"), "two  lines\\x09");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\x9b31m")
      << "C1";
  EXPECT_EQ(printable("\xE2\x80\xAE"
                      "txt.exe"),
            "\\u202etxt.exe")
      << "right to left";
  EXPECT_EQ(printable("\xE2\x81\xA6\xEF\xBB\xBF"), "\\u2066\\ufeff");
}

TEST(Printable, ShowsBytesThatAreNoCharacters) {
  EXPECT_EQ(printable("\xFF\x80"), "\\xff\\x80");
  EXPECT_EQ(printable("a\xC3"), "a\\xc3") << "cut off";
  EXPECT_EQ(printable("\xC0\x8A\xE0\x80\x8A"), "\\xc0\\x8a\\xe0\\x80\\x8a") << "longer than needed";
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80") << "half of a pair of UTF-16";
  EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond Unicode";
}

TEST(Printable, OfAnythingHasNoControlBytes) {
  Random random(5);
  for (int run = 0; run < 20000; ++run) {
    std::string text;
    for (std::uint32_t i = random.below(12); i > 0; --i)
      text += static_cast<char>(random.below(256));
    for (const char c : printable(text)) {
      EXPECT_GE(static_cast<unsigned char>(c), 0x20);
      EXPECT_NE(c, '\x7f');
    }
    EXPECT_EQ(printable(printable(text)), printable(text));
  }
}

TEST(YamlQuoted, EscapesWhatYamlKnows) {
  EXPECT_EQ(yamlQuoted("a \"b\" \\n\n\x1b"), "\"a \\\"b\\\" \\\\n\\x0a\\x1b\"");
  EXPECT_EQ(yamlQuoted("Mülltonne"), "\"Mülltonne\"");
  EXPECT_EQ(yamlQuoted("\xE2\x80\xA8"), "\"\\u2028\"");
}

TEST(CsvQuoted, IsNoFormula) {
  EXPECT_EQ(csvQuoted("pole"), "\"pole\"");
  EXPECT_EQ(csvQuoted("a \"b\", c"), "\"a \"\"b\"\", c\"");
  for (const char* begin : {"=", "+", "-", "@", "\t", "\r"})
    EXPECT_EQ(csvQuoted(std::string(begin) + "HYPERLINK(1)"),
              "\"'" + std::string(begin) + "HYPERLINK(1)\"");
}

}  // namespace
}  // namespace xview
