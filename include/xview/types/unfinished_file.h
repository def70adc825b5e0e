// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

/// Names a file that is of no use before it is whole, for as long as it is not: a program that is
/// interrupted then leaves nothing behind, if it called removeUnfinishedOnInterrupt(). Does nothing
/// else with the file. Of more than 64 at a time only 64 are removed.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(std::string path);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 private:
  std::string path_;
  int slot_;  ///< -1 = none was free
};

/// From now on interrupt, hang-up and termination remove unfinished files before they end the
/// program, unless they are ignored.
void removeUnfinishedOnInterrupt();

}  // namespace xview
