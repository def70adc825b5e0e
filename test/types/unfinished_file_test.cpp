// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/unfinished_file.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace xview {
namespace {

namespace fs = std::filesystem;

class UnfinishedFileOf : public testing::Test {
 protected:
  UnfinishedFileOf() {
    folder_ = fs::temp_directory_path() / ("xview_unfinished_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  ~UnfinishedFileOf() override { fs::remove_all(folder_); }

  std::string write(const std::string& name) const {
    const std::string path = folder_ / name;
    std::ofstream(path) << "half";
    return path;
  }
  bool isThere(const std::string& name) const { return fs::exists(folder_ / name); }

  /// The signal that ends another process that does this, 0 if none does.
  static int endOf(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
      work();
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  fs::path folder_;
};

TEST_F(UnfinishedFileOf, AnInterruptedProgramIsRemoved) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(endOf([&] {
                removeUnfinishedOnInterrupt();
                const UnfinishedFile first(write("first")), second(write("second"));
                write("other");
                std::raise(signal);
              }),
              signal);
    EXPECT_FALSE(isThere("first"));
    EXPECT_FALSE(isThere("second"));
    EXPECT_TRUE(isThere("other"));
  }
}

TEST_F(UnfinishedFileOf, AFinishedOneStays) {
  EXPECT_EQ(endOf([&] {
              removeUnfinishedOnInterrupt();
              { const UnfinishedFile file(write("whole")); }
              std::raise(SIGINT);
            }),
            SIGINT);
  EXPECT_TRUE(isThere("whole"));
}

TEST_F(UnfinishedFileOf, AProgramThatIgnoresHangUpsGoesOn) {
  EXPECT_EQ(endOf([&] {
              std::signal(SIGHUP, SIG_IGN);
              removeUnfinishedOnInterrupt();
              const UnfinishedFile file(write("going on"));
              std::raise(SIGHUP);
            }),
            0);
  EXPECT_TRUE(isThere("going on"));
}

TEST_F(UnfinishedFileOf, ManyFilesAreNoTrouble) {
  EXPECT_EQ(endOf([&] {
              removeUnfinishedOnInterrupt();
              std::vector<std::unique_ptr<UnfinishedFile>> files;
              for (int i = 0; i < 200; ++i)
                files.push_back(std::make_unique<UnfinishedFile>(write(std::to_string(i))));
              std::raise(SIGINT);
            }),
            SIGINT);
  EXPECT_FALSE(isThere("0"));
  EXPECT_FALSE(isThere("63"));
}

}  // namespace
}  // namespace xview
