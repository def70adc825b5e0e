// SPDX-License-Identifier: BSD-3-Clause
/// Runs commands of `xview`, one per line of stdin, one after the other in this process: what is
/// done for a line is what `xview` does, without loading a hundred libraries first. A line is a
/// file for stderr and then the arguments, separated by tabs; what a command prints is dropped.
/// Answers with a line each: exit code, seconds of CPU, peak memory of the process so far [kB].
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "process/atomic_file.h"
#include "process/library_chatter.h"
#include "tool.h"

namespace {

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, '\t');) fields.push_back(field);
  return fields;
}

double secondsOf(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

double cpuSecondsOf(const rusage& used) {
  return secondsOf(used.ru_utime) + secondsOf(used.ru_stime);
}

rusage usedSoFar() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used;
}

}  // namespace

int main() {
  std::FILE* const answers = fdopen(dup(STDOUT_FILENO), "w");
  const int nowhere = open("/dev/null", O_WRONLY);
  if (answers == nullptr || nowhere < 0) return 1;
  dup2(nowhere, STDOUT_FILENO);
  xview::removeUnfinishedOnInterrupt();
  xview::allowQuietLibraries();
  for (std::string line; std::getline(std::cin, line);) {
    std::vector<std::string> fields = fieldsOf(line);
    if (std::freopen(fields.front().c_str(), "w", stderr) == nullptr) return 1;
    fields.erase(fields.begin());
    const double before_s = cpuSecondsOf(usedSoFar());
    const int code = xview::tools::runProgram(fields);
    std::fflush(stderr);
    const rusage used = usedSoFar();
    fmt::print(answers, "{} {:.4f} {}\n", code, cpuSecondsOf(used) - before_s, used.ru_maxrss);
    std::fflush(answers);
  }
  return 0;
}
