// SPDX-License-Identifier: BSD-3-Clause
#include "commands.h"
#include "tool.h"
#include "xview/types/unfinished_file.h"

int main(int argc, char** argv) {
  using namespace xview::tools;
  xview::removeUnfinishedOnInterrupt();
  return runProgram(argc, argv,
                    {makeSimulate, makeInfo, makeLift, makeBlobs, makeGraph, makeMap, makeMatch,
                     makeLocalize, makeEvaluate, makeFuse, makeLearn, makeView});
}
