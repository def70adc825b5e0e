// SPDX-License-Identifier: BSD-3-Clause
#include "tool.h"
#include "xview/types/atomic_file.h"
#include "xview/types/library_chatter.h"

int main(int argc, char** argv) {
  xview::removeUnfinishedOnInterrupt();
  xview::allowQuietLibraries();
  return xview::tools::runProgram({argv + 1, argv + argc});
}
