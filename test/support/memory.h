// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <fstream>

namespace xview::test {

/// Resident memory of this process [MB].
inline double resident_mb() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace xview::test
