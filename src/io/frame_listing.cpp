// SPDX-License-Identifier: BSD-3-Clause
#include "frame_listing.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "number_words.h"
#include "xview/types/error.h"

namespace xview {
namespace {

/// Digits at the end of a stem. Not those behind a dot: "1305031102.175304" is a time, not frame
/// 175304.
std::optional<std::int64_t> trailingNumber(const std::string& stem) {
  const std::size_t last_other = stem.find_last_not_of("0123456789");
  const std::size_t begin = last_other == std::string::npos ? 0 : last_other + 1;
  if (begin > 0 && stem[begin - 1] == '.') return std::nullopt;
  return asInteger(std::string_view(stem).substr(begin));
}

/// A number for every stem, or nothing if one has none or two have the same.
std::optional<std::vector<std::int64_t>> ownNumbers(const std::vector<NumberedFile>& files) {
  std::vector<std::int64_t> numbers;
  std::set<std::int64_t> seen;
  for (const NumberedFile& file : files) {
    const std::optional<std::int64_t> number = trailingNumber(file.stem);
    if (!number || !seen.insert(*number).second) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// A stem of `files` that `other` does not have; empty if there is none.
std::string missingStem(const std::vector<NumberedFile>& files,
                        const std::vector<NumberedFile>& other) {
  std::set<std::string> stems;
  for (const NumberedFile& file : other) stems.insert(file.stem);
  for (const NumberedFile& file : files) {
    if (stems.count(file.stem) == 0) return file.stem;
  }
  return "";
}

}  // namespace

std::vector<NumberedFile> listFiles(const std::string& folder,
                                    const std::vector<std::string>& endings) {
  std::error_code failed;
  std::filesystem::directory_iterator entries(folder, failed);
  if (failed) throw Error(folder, "cannot list the folder: " + failed.message());
  std::vector<NumberedFile> files;
  for (const auto& entry : entries) {
    const std::filesystem::path& path = entry.path();
    const std::string ending = path.extension().string();
    if (std::find(endings.begin(), endings.end(), ending) == endings.end()) continue;
    if (path.filename().string()[0] == '.' || entry.is_directory(failed)) continue;
    files.push_back({path.stem().string(), path.string()});
  }
  if (files.empty()) throw Error(folder, "no " + joined(endings) + " files");
  std::sort(files.begin(), files.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.stem != b.stem ? a.stem < b.stem : a.path < b.path;
  });
  const auto twice = std::adjacent_find(
      files.begin(), files.end(),
      [](const NumberedFile& a, const NumberedFile& b) { return a.stem == b.stem; });
  if (twice != files.end()) {
    throw Error(twice->path, "there is also " + std::next(twice)->path + "; which is the frame?");
  }
  if (ownNumbers(files)) {
    std::stable_sort(files.begin(), files.end(), [](const NumberedFile& a, const NumberedFile& b) {
      return *trailingNumber(a.stem) < *trailingNumber(b.stem);
    });
  }
  return files;
}

std::vector<std::int64_t> frameNumbers(const std::vector<NumberedFile>& files) {
  if (auto numbers = ownNumbers(files)) return *std::move(numbers);
  std::vector<std::int64_t> positions(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) positions[i] = static_cast<std::int64_t>(i);
  return positions;
}

void requireSameFrames(const std::string& folder, const std::string& what,
                       const std::vector<NumberedFile>& files, const std::string& other_what,
                       const std::vector<NumberedFile>& other) {
  const std::string counts = std::to_string(files.size()) + " " + what + " files but " +
                             std::to_string(other.size()) + " " + other_what + " files; ";
  const std::string lonely = missingStem(files, other);
  if (!lonely.empty()) throw Error(folder, counts + lonely + " has no " + other_what + " file");
  const std::string orphan = missingStem(other, files);
  if (!orphan.empty()) throw Error(folder, counts + orphan + " has no " + what + " file");
}

std::vector<std::size_t> linesOfFrames(const std::string& path, const std::string& what,
                                       std::size_t lines,
                                       const std::vector<std::int64_t>& numbers) {
  const std::string counts =
      std::to_string(lines) + " " + what + " for " + std::to_string(numbers.size()) + " frames";
  if (lines < numbers.size()) throw Error(path, counts);
  std::vector<std::size_t> chosen(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::int64_t line = lines == numbers.size() ? static_cast<std::int64_t>(i) : numbers[i];
    if (line < 0 || static_cast<std::uint64_t>(line) >= lines) {
      throw Error(path, counts + ", taken by the number of the frame, but frame " +
                            std::to_string(line) + " is beyond the last line");
    }
    chosen[i] = static_cast<std::size_t>(line);
  }
  return chosen;
}

}  // namespace xview
