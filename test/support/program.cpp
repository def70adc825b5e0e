// SPDX-License-Identifier: BSD-3-Clause
#include "support/program.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "support/sanitizers.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

constexpr int kPatience = kSanitized ? 20 : 1;

void redirect(int descriptor, const std::string& path) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file < 0 || dup2(file, descriptor) < 0) _exit(126);
  close(file);
}

/// The child: only calls that are safe after fork.
[[noreturn]] void become(const std::vector<char*>& argv, const std::string& out,
                         const std::string& err, const Limits& limits) {
  redirect(STDOUT_FILENO, out);
  redirect(STDERR_FILENO, err);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  if (limits.address_space_mb > 0 && !kSanitized) {
    const rlimit space{limits.address_space_mb << 20, limits.address_space_mb << 20};
    setrlimit(RLIMIT_AS, &space);
  }
  if (limits.file_size_bytes > 0) {
    const rlimit size{limits.file_size_bytes, limits.file_size_bytes};
    setrlimit(RLIMIT_FSIZE, &size);
    signal(SIGXFSZ, SIG_IGN);  // survives exec; write() fails instead
  }
  alarm(static_cast<unsigned>(kPatience *
                              limits.seconds));  // survives exec; SIGALRM ends the program
  execv(argv[0], argv.data());
  _exit(127);
}

double secondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

Outcome runXview(const std::vector<std::string>& arguments, const Limits& limits) {
  return runProgram(XVIEW_PROGRAM, arguments, limits);
}

Outcome runProgram(const std::string& program, const std::vector<std::string>& arguments,
                   const Limits& limits) {
  const TemporaryFolder folder;
  const std::string out = limits.output_path.empty() ? folder / "out" : limits.output_path,
                    err = folder / "err";
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const pid_t child = fork();
  if (child < 0) std::abort();
  if (child == 0) become(argv, out, err, limits);
  int status = 0;
  rusage usage = {};
  siginfo_t end = {};
  const auto runs = [&] {
    return waitid(P_PID, static_cast<id_t>(child), &end, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           end.si_pid == 0;
  };
  while (limits.signal != 0 && runs()) {
    if (limits.when()) {
      kill(child, limits.signal);
      break;
    }
    usleep(500);
  }
  wait4(child, &status, 0, &usage);

  Outcome outcome;
  outcome.peak_mb = usage.ru_maxrss / 1024;
  outcome.cpu_s = secondsOf(usage.ru_utime) + secondsOf(usage.ru_stime);
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  if (limits.output_path.empty()) outcome.out = readText(out);
  outcome.err = readText(err);
  return outcome;
}

std::size_t lineCount(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace xview::test
