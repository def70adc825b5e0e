// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "support/test_data.h"

namespace xview::test {

/// What a run of the program left behind.
struct Outcome {
  int code = -1;    ///< exit code; -1 if it was killed by a signal
  int signal = 0;   ///< the signal, SIGALRM when the time was up
  std::string out;  ///< standard output
  std::string err;  ///< standard error
};

/// Circumstances of a run.
struct Limits {
  int seconds = 60;
  std::size_t address_space_mb = 0;  ///< 0 = none
  std::string output_path;           ///< where standard output goes instead of into Outcome::out
  std::size_t file_size_bytes = 0;   ///< more in one file fails, as on a full disk; 0 = none
};

/// Runs a program with these arguments, as a shell would.
Outcome runProgram(const std::string& program, const std::vector<std::string>& arguments,
                   const Limits& limits = {});
/// Runs the xview of this build.
Outcome runXview(const std::vector<std::string>& arguments, const Limits& limits = {});

std::size_t lineCount(const std::string& text);

}  // namespace xview::test
