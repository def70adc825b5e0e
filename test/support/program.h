// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "support/test_data.h"

namespace xview::test {

/// What a run of the program left behind.
struct Outcome {
  int code = -1;     ///< exit code; -1 if it was killed by a signal
  int signal = 0;    ///< the signal, SIGALRM when the time was up
  std::string out;   ///< standard output
  std::string err;   ///< standard error
  long peak_mb = 0;  ///< the most memory that it had at a time
  double cpu_s = 0;  ///< time that it computed
};

/// Circumstances of a run.
struct Limits {
  int seconds = 60;
  std::size_t address_space_mb = 0;  ///< 0 = none
  std::string output_path;           ///< where standard output goes instead of into Outcome::out
  std::size_t file_size_bytes = 0;   ///< more in one file fails, as on a full disk; 0 = none
  int signal = 0;                    ///< sent as soon as `when` is true; 0 = none
  std::function<bool()> when = {};
};

/// Runs the xview of this build with these arguments, as a shell would.
Outcome runXview(const std::vector<std::string>& arguments, const Limits& limits = {});

std::size_t lineCount(const std::string& text);

}  // namespace xview::test
