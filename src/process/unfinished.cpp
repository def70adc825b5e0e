// SPDX-License-Identifier: BSD-3-Clause
#include "unfinished.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "base/user_text.h"
#include "process/atomic_file.h"

namespace xview {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".partial-";
constexpr const char* kJournal = "-journal";  ///< of SQLite, beside a map that is being written

/// Never destroyed, because a signal may come while the program ends.
struct Registry {
  std::recursive_timed_mutex mutex;                   ///< who holds it writes a result
  std::map<std::string, std::string> kept_as;         ///< by path; empty = removed
  std::set<std::string> searched;                     ///< folders
  std::multimap<std::string, std::string> abandoned;  ///< by the path of the target
  std::function<void()> finish = [] {};               ///< finishOnInterrupt
};
Registry& registry() {
  static auto* const one = new Registry;
  return *one;
}
using Guard = std::lock_guard<std::recursive_timed_mutex>;

// ---- names

/// The path with a last part that has room for the ending.
std::string cutForEnding(const std::string& path) {
  constexpr std::size_t kLongest = 255 - 38;      // mark, two numbers of 10 digits, -, -journal
  const std::size_t begin = path.rfind('/') + 1;  // 0 if there is none
  if (path.size() - begin <= kLongest) return path;
  std::size_t end = begin + kLongest;
  while (end > begin && (static_cast<unsigned char>(path[end]) & 0xC0) == 0x80) --end;  // UTF-8
  return path.substr(0, end);
}

struct PartialName {
  std::string target;  ///< cut (cutForEnding)
  pid_t process = 0;
};

/// Nothing if it is no name that partialNameFor gave. A part of a part belongs to the whole.
std::optional<PartialName> parsePartial(std::string path) {
  const std::size_t mark = path.rfind(kMark);
  if (mark == std::string::npos || mark == 0) return std::nullopt;
  const std::size_t journal = path.rfind(kJournal);
  if (journal != std::string::npos && journal > mark && journal + 8 == path.size())
    path.erase(journal);
  const std::string numbers = path.substr(mark + 9);
  const std::size_t dash = numbers.find('-');
  if (dash == std::string::npos) return std::nullopt;
  const auto is_number = [](const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  };
  const std::string process = numbers.substr(0, dash);
  const auto id = numberFrom<pid_t>(process);
  if (!id || *id <= 0 || !is_number(process) || !is_number(numbers.substr(dash + 1)))
    return std::nullopt;
  const std::string target = path.substr(0, mark);
  const auto whole = parsePartial(target);
  return PartialName{whole ? whole->target : target, *id};
}

bool isAlive(pid_t process) { return kill(process, 0) == 0 || errno != ESRCH; }

/// Once per folder, because a recording has many files in one.
void searchFolder(const fs::path& folder, Registry& all) {
  if (!all.searched.insert(folder.string()).second) return;
  std::error_code failed;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, failed), end;
       !failed && entry != end; entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    const auto partial = parsePartial(name);
    if (partial && !isAlive(partial->process))
      all.abandoned.emplace((folder / partial->target).string(), (folder / name).string());
  }
}

// ---- signals

void removeAll(const std::string& path) {
  constexpr int kTries = 100;
  std::error_code failed;
  // A thread may add the one file to the folder that it is about to finish.
  for (int i = 0; i < kTries; ++i) {
    fs::remove_all(path, failed);
    if (!failed) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// The lock is kept for ever: who comes to the next result or file waits there for the end.
[[noreturn]] void endBy(int signal) {
  Registry& all = registry();
  all.finish();
  const bool is_whole = all.mutex.try_lock_for(std::chrono::seconds(2));
  for (const auto& [path, target] : all.kept_as) {
    if (!is_whole || target.empty() || std::rename(path.c_str(), target.c_str()) != 0)
      removeAll(path);
  }
  _exit(128 + signal);
}

sigset_t interrupts() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action = {};
    if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
      sigaddset(&set, signal);
  }
  return set;
}

void* awaitInterrupt(void* /*unused*/) {
  const sigset_t set = interrupts();
  int signal = 0;
  while (sigwait(&set, &signal) != 0) {
  }
  endBy(signal);
}

}  // namespace

std::string partialNameFor(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  return cutForEnding(path) + kMark + std::to_string(getpid()) + "-" + std::to_string(counter++);
}

void removeAbandoned(const std::string& path) {
  Registry& all = registry();
  const Guard lock(all.mutex);
  searchFolder(fs::path(path).parent_path(), all);
  const auto [first, last] = all.abandoned.equal_range(cutForEnding(path));
  std::error_code ignored;
  for (auto entry = first; entry != last; ++entry) fs::remove_all(entry->second, ignored);
  all.abandoned.erase(first, last);
}

void addUnfinished(const std::string& path) { keepUnfinished(path, ""); }

void keepUnfinished(const std::string& path, const std::string& target) {
  const Guard lock(registry().mutex);
  registry().kept_as[path] = target;
}

void dropUnfinished(const std::string& path) {
  const Guard lock(registry().mutex);
  registry().kept_as.erase(path);
}

void finishOnInterrupt(std::function<void()> finish) { registry().finish = std::move(finish); }

// A handler could neither wait for a line that is being written nor remove a folder; a thread can.
void removeUnfinishedOnInterrupt() {
  registry();
  sigset_t set = interrupts();
  if (pthread_sigmask(SIG_BLOCK, &set, nullptr) != 0) return;
  pthread_attr_t small;
  pthread_attr_init(&small);
  pthread_attr_setstacksize(&small, std::size_t{1} << 18);
  pthread_attr_setdetachstate(&small, PTHREAD_CREATE_DETACHED);
  pthread_t thread = {};
  if (pthread_create(&thread, &small, awaitInterrupt, nullptr) != 0)
    pthread_sigmask(SIG_UNBLOCK, &set, nullptr);  // then they end the program as they always do
  pthread_attr_destroy(&small);
}

UninterruptedWrite::UninterruptedWrite() { registry().mutex.lock(); }
UninterruptedWrite::~UninterruptedWrite() { registry().mutex.unlock(); }

}  // namespace xview
