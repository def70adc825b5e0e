// SPDX-License-Identifier: BSD-3-Clause
// One word for one thing, that of the field: what a user or a caller reads has no private words.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "architecture/source_files.h"
#ifdef XVIEW_PROGRAM
#include "support/program.h"
#endif

namespace xview::test {
namespace {

namespace fs = std::filesystem;

struct Word {
  const char* old;  ///< regular expression
  const char* now;
};

constexpr Word kWords[] = {
    {"plan[- ]views?|PlanView\\w*|PlanSample", "bird's-eye view, BEV grid"},
    {"views? (seen )?from above|seen from above", "bird's-eye view, BEV grid"},
    {"digest(s|ed|ing)?|FrameDigest|digest(Frame|Recording)", "preprocessed frame"},
    {"\\w*alikeness|look-alikes?|askItself", "self-similarity, perceptual aliasing"},
    {"(real_)?strangers?|from elsewhere|from_elsewhere", "out-of-map query, negative"},
    {"rivals?|rival_\\w+|passed[ _]over", "second-best hypothesis, alternative, best_unverified"},
    {"(in )?lengths of (a )?towns?|kTown|kRoom|kDesk", "canonical scale"},
    {"(seen|saw)[ _]through|seenThrough", "free-space violation"},
    {"close looks?|(look|looked|looks) at closely", "dense verification"},
    {"climb(s|ed|ing)?", "local refinement"},
    {"the lead|a lead", "likelihood-ratio margin"},
    {"frame guess(es)?|FrameGuess|GuessedQuery", "hypothesis of gravity alignment and scale"},
    {"settle[sd]?", "converged"},
    {"of_itself|by_chance|known_share|contradicted|null[ _](excess|missing)",
     "self-consistency, null inlier ratio, map coverage, conflict ratio"},
    {"on (its|their) like", "inlier ratio"},
    {"kEven\\w*|wayAlong|walkAlong", "threshold, path length"},
    {"so many|so much", "a noun and a unit"},
};

/// A contract that needs an old word: formats and names that may not change.
struct Exception {
  const char* file;  ///< how its path ends
  const char* text;
  const char* reason;
};

constexpr Exception kExceptions[] = {
    {"docs/formats.md", "`contradicted`", "a reason_code"},
    {"base/localization.h", "contradicted, ", "a reason_code"},
    {"docs/results/worlds.md", "real_strangers", "row of bench/regress_baseline.csv"},
};

/// The text without what is allowed in this file; every exception must be needed.
std::string withoutExceptions(const std::string& file, std::string text) {
  for (const Exception& allowed : kExceptions) {
    const std::string end = allowed.file, phrase = allowed.text;
    if (file.size() < end.size() || file.compare(file.size() - end.size(), end.size(), end) != 0)
      continue;
    EXPECT_NE(text.find(phrase), std::string::npos)
        << file << " no longer needs the exception for " << phrase << ": " << allowed.reason;
    for (std::size_t at = 0; (at = text.find(phrase, at)) != std::string::npos;)
      text.erase(at, phrase.size());
  }
  return text;
}

void expectWordsOfTheField(const std::string& name, const std::string& text) {
  static const std::vector<std::pair<std::regex, const Word*>> patterns = [] {
    std::vector<std::pair<std::regex, const Word*>> all;
    for (const Word& word : kWords)
      all.emplace_back(std::regex("\\b(" + std::string(word.old) + ")\\b",
                                  std::regex::icase | std::regex::optimize),
                       &word);
    return all;
  }();
  std::istringstream lines(withoutExceptions(name, text));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    for (const auto& [pattern, word] : patterns) {
      std::smatch found;
      EXPECT_FALSE(std::regex_search(line, found, pattern))
          << name << ":" << number << ": \"" << found.str() << "\"; the field says " << word->now;
    }
  }
}

std::string textOf(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(Words, OfHeadersAreThoseOfTheField) {
  std::size_t headers = 0;
  for (const SourceFile& file : sourceFiles()) {
    const std::string path = file.path.generic_string();
    if (file.path.extension() != ".h" || file.place == "tools" || file.place == "python") continue;
    ++headers;
    expectWordsOfTheField(path, file.text);
  }
  EXPECT_GT(headers, 50u);
}

TEST(Words, OfDocumentsAreThoseOfTheField) {
  const fs::path root = XVIEW_SOURCE_DIR;
  std::size_t pages = 0;
  for (const fs::path& folder : {root, root / "docs", root / "docs/results"}) {
    for (const fs::directory_entry& page : fs::directory_iterator(folder)) {
      // The history keeps its words.
      if (page.path().extension() != ".md" || page.path().filename() == "CHANGELOG.md") continue;
      ++pages;
      expectWordsOfTheField(page.path().generic_string(), textOf(page.path()));
    }
  }
  EXPECT_GT(pages, 12u);
}

#ifdef XVIEW_PROGRAM
TEST(Words, OfTheHelpOfEveryCommandAreThoseOfTheField) {
  const std::string all = runXview({"--help"}).out;
  expectWordsOfTheField("xview --help", all);
  static const std::regex command("\n  ([a-z]+) ");
  std::set<std::string> commands;
  for (std::sregex_iterator at(all.begin(), all.end(), command), end; at != end; ++at)
    commands.insert((*at)[1]);
  EXPECT_GT(commands.size(), 15u);
  for (const std::string& name : commands) {
    const Outcome help = runXview({name, "--help-all"});
    ASSERT_EQ(help.code, 0) << name << help.err;
    expectWordsOfTheField("xview " + name + " --help-all", help.out);
  }
}
#endif

}  // namespace
}  // namespace xview::test
