// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "support/test_data.h"
#include "xview/types/error.h"

namespace xview {
namespace {

std::size_t filesIn(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                                std::filesystem::directory_iterator()));
}

TEST(AtomicFile, AppearsOnCommitAndLeavesNothingBeside) {
  const test::TemporaryFolder folder;
  AtomicFile file(folder / "out.txt");
  file.write("hello ");
  file.write("world", 5);
  EXPECT_FALSE(std::filesystem::exists(folder / "out.txt"));
  file.commit();
  EXPECT_EQ(test::readText(folder / "out.txt"), "hello world");
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

/// The signal that ends another process that does this, 0 if none does.
int endOf(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    removeUnfinishedOnInterrupt();
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(AtomicFile, OfAnInterruptedProgramLeavesTheOldFileAlone) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "out.txt") << "old";
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(endOf([&] {
                AtomicFile file(folder / "out.txt"), other(folder / "other.txt");
                file.write(std::string(3 << 20, 'x'));
                std::raise(signal);
              }),
              signal);
    EXPECT_EQ(test::readText(folder / "out.txt"), "old");
    EXPECT_EQ(filesIn(folder.path()), 1u);
  }
}

TEST(AtomicFile, ThatIsWholeSurvivesAnInterrupt) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(endOf([&] {
              AtomicFile file(folder / "out.txt");
              file.write("whole");
              file.commit();
              std::raise(SIGINT);
            }),
            SIGINT);
  EXPECT_EQ(test::readText(folder / "out.txt"), "whole");
}

TEST(AtomicFile, GoesOnInAProgramThatIgnoresHangUps) {
  const test::TemporaryFolder folder;
  std::signal(SIGHUP, SIG_IGN);
  EXPECT_EQ(endOf([&] {
              AtomicFile file(folder / "out.txt");
              std::raise(SIGHUP);
              file.commit();
            }),
            0);
  std::signal(SIGHUP, SIG_DFL);
  EXPECT_TRUE(std::filesystem::exists(folder / "out.txt"));
}

TEST(AtomicFile, ManyAtATimeAreNoTrouble) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(endOf([&] {
              std::deque<AtomicFile> files;
              for (int i = 0; i < 100; ++i) files.emplace_back(folder / std::to_string(i));
              std::raise(SIGINT);
            }),
            SIGINT);
  EXPECT_EQ(filesIn(folder.path()), 36u);
}

TEST(AtomicFile, WithoutCommitTheOldFileStays) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "out.txt") << "old";
  {
    AtomicFile file(folder / "out.txt");
    file.write("new");
  }
  EXPECT_EQ(test::readText(folder / "out.txt"), "old");
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

TEST(AtomicFile, MoreThanTheBufferArrivesInOrder) {
  const test::TemporaryFolder folder;
  std::string expected;
  AtomicFile file(folder / "out.bin");
  for (int i = 0; i < 300000; ++i) {
    const std::string line = std::to_string(i) + "\n";
    expected += line;
    file.write(line);
  }
  file.commit();
  EXPECT_EQ(test::readText(folder / "out.bin"), expected);
}

TEST(AtomicFile, ALibraryMayWriteToTheTemporaryPath) {
  const test::TemporaryFolder folder;
  AtomicFile file(folder / "out.txt");
  std::ofstream(file.temporaryPath()) << "by name";
  file.commit();
  EXPECT_EQ(test::readText(folder / "out.txt"), "by name");
}

TEST(AtomicFile, FollowsASymbolicLink) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "target") << "old";
  std::filesystem::create_symlink("target", folder / "link");
  AtomicFile file(folder / "link");
  file.write("new");
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(test::readText(folder / "target"), "new");
}

TEST(AtomicFile, KeepsThePermissionsOfTheOldFile) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "out.txt") << "old";
  ASSERT_EQ(chmod((folder / "out.txt").c_str(), 0640), 0);
  AtomicFile file(folder / "out.txt");
  file.commit();
  struct stat status = {};
  ASSERT_EQ(stat((folder / "out.txt").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFile, AFullDiskIsAnErrorAndTheDeviceSurvives) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  AtomicFile file("/dev/full");
  file.write("lost");
  EXPECT_EQ(test::messageOf<Error>([&] { file.commit(); }),
            "/dev/full: cannot write: No space left on device");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, AMissingFolderAndAFolderAsTargetAreErrors) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(AtomicFile(folder / "missing/out.txt"), Error);
  EXPECT_THROW(AtomicFile(folder.path()), Error);
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

}  // namespace
}  // namespace xview
