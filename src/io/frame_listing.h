// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xview {

/// A file of a numbered series: depth/000017.png.
struct NumberedFile {
  std::string stem;  ///< "000017"
  std::string path;
};

/// The files of a folder that have one of the endings (".png"), in the order of the numbers in
/// their names, else by name. Throws Error: no such folder, none of these files, the same stem
/// twice.
std::vector<NumberedFile> listFiles(const std::string& folder,
                                    const std::vector<std::string>& endings);

/// The number at the end of each stem ("frame_17" -> 17); positions if not every stem has one of
/// its own.
std::vector<std::int64_t> frameNumbers(const std::vector<NumberedFile>& files);

/// Throws Error unless both series have the same stems; the message has both counts and a stem that
/// is missing.
void requireSameFrames(const std::string& folder, const std::string& what,
                       const std::vector<NumberedFile>& files, const std::string& other_what,
                       const std::vector<NumberedFile>& other);

/// Which line of a text file belongs to each frame, for files with one line per frame: in order if
/// there are as many lines as frames; with more lines, line `number` (from 0) belongs to frame
/// `number`. Fewer lines are an Error.
std::vector<std::size_t> linesOfFrames(const std::string& path, const std::string& what,
                                       std::size_t lines, const std::vector<std::int64_t>& numbers);

}  // namespace xview
