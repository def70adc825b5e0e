// SPDX-License-Identifier: BSD-3-Clause
#include "process/atomic_file.h"
#include "process/library_chatter.h"
#include "tool.h"

int main(int argc, char** argv) {
  xview::removeUnfinishedOnInterrupt();
  xview::allowQuietLibraries();
  return xview::tools::runProgram({argv + 1, argv + argc});
}
