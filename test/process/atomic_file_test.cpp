// SPDX-License-Identifier: BSD-3-Clause
#include "process/atomic_file.h"

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
#include "xview/base/error.h"

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

/// The exit code of another process that does this.
int endOf(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    removeUnfinishedOnInterrupt();
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Ends this process by a signal from outside, which any thread may receive.
void interrupt(int signal) {
  kill(getpid(), signal);
  pause();
}

TEST(AtomicFile, OfAnInterruptedProgramLeavesTheOldFileAlone) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "out.txt") << "old";
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(endOf([&] {
                AtomicFile file(folder / "out.txt"), other(folder / "other.txt");
                file.write(std::string(3 << 20, 'x'));
                interrupt(signal);
              }),
              128 + signal);
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
              interrupt(SIGINT);
            }),
            130);
  EXPECT_EQ(test::readText(folder / "out.txt"), "whole");
}

TEST(AtomicFile, OfResultsOneByOneKeepsThoseSoFarInAnInterrupt) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(endOf([&] {
              AtomicFile file(folder / "out.txt"), none(folder / "none.txt");
              file.write("one\n");
              file.keepSoFar();
              file.write("two\n");
              file.keepSoFar();
              file.write("thr");
              interrupt(SIGTERM);
            }),
            143);
  EXPECT_EQ(test::readText(folder / "out.txt"), "one\ntwo\n");
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

TEST(AtomicFile, AnInterruptWaitsForAResultThatIsBeingWritten) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(endOf([&] {
              AtomicFile file(folder / "out.txt");
              file.keepSoFar();
              {
                const UninterruptedWrite whole;
                file.write("one ");
                kill(getpid(), SIGINT);
                usleep(200000);
                file.write("line\n");
                file.keepSoFar();
              }
              pause();
            }),
            130);
  EXPECT_EQ(test::readText(folder / "out.txt"), "one line\n");
}

TEST(AtomicFile, GoesOnInAProgramThatIgnoresHangUps) {
  const test::TemporaryFolder folder;
  std::signal(SIGHUP, SIG_IGN);
  EXPECT_EQ(endOf([&] {
              AtomicFile file(folder / "out.txt");
              kill(getpid(), SIGHUP);
              usleep(100000);
              file.commit();
            }),
            0);
  std::signal(SIGHUP, SIG_DFL);
  EXPECT_TRUE(std::filesystem::exists(folder / "out.txt"));
}

/// Check fix for: of more than 64 the rest stayed.
TEST(AtomicFile, ManyAtATimeAreNoTrouble) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(endOf([&] {
              std::deque<AtomicFile> files;
              for (int i = 0; i < 100; ++i) files.emplace_back(folder / std::to_string(i));
              interrupt(SIGINT);
            }),
            130);
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

/// The number of a process that has ended.
pid_t deadProcess() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

TEST(AtomicFile, OfAKilledRunIsRemovedByTheNextThatWritesTheSame) {
  const std::string dead = std::to_string(deadProcess()), alive = std::to_string(getppid());
  const test::TemporaryFolder folder;
  const std::string gone[] = {"out.txt.partial-" + dead + "-0", "out.txt.partial-" + dead + "-12",
                              "out.txt.partial-" + dead + "-3-journal",
                              "out.txt.partial-" + alive + "-4.partial-" + dead + "-5"};
  const std::string stay[] = {"other.txt.partial-" + dead + "-0", "out.txt.partial-" + alive + "-0",
                              "out.txt.partial-" + dead,          "out.txt.partial--1-0",
                              "out.txt.partial-" + dead + "-0x",  "out.txt.partial-",
                              "xout.txt.partial-" + dead + "-0"};
  for (const std::string& name : gone) test::writeText(folder / name, "part");
  for (const std::string& name : stay) test::writeText(folder / name, "mine");
  AtomicFile(folder / "out.txt").commit();
  for (const std::string& name : gone) EXPECT_FALSE(std::filesystem::exists(folder / name)) << name;
  for (const std::string& name : stay) EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
}

TEST(AtomicFile, ANameThatIsTakenIsNoTrouble) {
  const test::TemporaryFolder folder;
  const std::string prize = folder / "prize";
  test::writeText(prize, "whole");
  const std::string next = AtomicFile(folder / "out.txt").temporaryPath();
  const std::size_t number = next.rfind('-') + 1;
  for (int i = 1; i < 4; ++i)
    std::filesystem::create_symlink(
        prize, next.substr(0, number) + std::to_string(std::stoi(next.substr(number)) + i));
  AtomicFile file(folder / "out.txt");
  file.write("new");
  file.commit();
  EXPECT_EQ(test::readText(folder / "out.txt"), "new");
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "out.txt"));
  EXPECT_EQ(test::readText(prize), "whole");
}

TEST(AtomicFile, MayHaveTheLongestNameThatThereIs) {
  const test::TemporaryFolder folder;
  std::string letters;
  while (letters.size() < 254) letters += "\u00e4";  // two bytes
  for (const std::string& name : {std::string(255, 'n'), letters, std::string(217, 'n')}) {
    AtomicFile file(folder / name);
    file.write("x");
    file.commit();
    EXPECT_EQ(test::readText(folder / name), "x") << name.size();
  }
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

// ---- folders

void fillRecording(const AtomicFolder& made, const std::string& text) {
  for (const char* name : {"depth/0.png", "poses.txt", "truth.txt"})
    test::writeText(made.temporaryPath() + "/" + name, text);
}

TEST(AtomicFolder, AppearsOnCommitWithTheFoldersAboveIt) {
  const test::TemporaryFolder folder;
  {
    AtomicFolder made(folder / "a/b/c/");
    fillRecording(made, "new");
    EXPECT_FALSE(std::filesystem::exists(folder / "a"));
    made.commit();
  }
  EXPECT_EQ(test::readText(folder / "a/b/c/depth/0.png"), "new");
  EXPECT_EQ(filesIn(folder.path()), 1u);
  EXPECT_EQ(filesIn(folder / "a/b/c"), 3u);
}

TEST(AtomicFolder, WithoutCommitOrInterruptedLeavesNothing) {
  const test::TemporaryFolder folder;
  { fillRecording(AtomicFolder(folder / "a/b"), "part"); }
  EXPECT_EQ(filesIn(folder.path()), 0u);
  EXPECT_EQ(endOf([&] {
              const AtomicFolder made(folder / "a/b");
              fillRecording(made, "part");
              const AtomicFile file(made.temporaryPath() + "/more.txt");
              interrupt(SIGTERM);
            }),
            143);
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(AtomicFolder, ThatExistsKeepsWhatIsNoPartOfIt) {
  const test::TemporaryFolder folder;
  for (const char* name : {"out/rgb/0.png", "out/depth/0.png", "out/depth/1.png", "out/poses.txt",
                           "out/instance/0.png", "out/truth.txt", "out/notes.txt"})
    test::writeText(folder / name, "old");
  {
    AtomicFolder made(folder / "out");
    fillRecording(made, "new");
    EXPECT_EQ(test::readText(folder / "out/poses.txt"), "old");
    made.commit({"instance", "depth", "poses.txt"});
  }
  for (const char* name : {"out/depth/0.png", "out/poses.txt", "out/truth.txt"})
    EXPECT_EQ(test::readText(folder / name), "new") << name;
  for (const char* name : {"out/rgb/0.png", "out/notes.txt"})
    EXPECT_EQ(test::readText(folder / name), "old") << name;
  EXPECT_EQ(filesIn(folder / "out"), 5u) << "instance/ is of the old one";
  EXPECT_EQ(filesIn(folder / "out/depth"), 1u);
}

/// Whenever it is killed, the last part is there only if all others are of the same making.
TEST(AtomicFolder, HasItsLastPartOnlyWhileItIsWhole) {
  for (int killed_us = 0; killed_us < 3000; killed_us += 30) {
    const test::TemporaryFolder folder;
    for (const char* name : {"depth/0.png", "label/0.png", "camera.yaml", "poses.txt"})
      test::writeText(folder / (std::string("out/") + name), "old");
    const pid_t child = fork();
    if (child == 0) {
      AtomicFolder made(folder / "out");
      for (const char* name : {"depth/0.png", "label/0.png", "camera.yaml", "poses.txt"})
        test::writeText(made.temporaryPath() + "/" + name, "new");
      made.commit({"depth", "label", "camera.yaml", "poses.txt"});
      _exit(0);
    }
    usleep(static_cast<useconds_t>(killed_us));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::string last = test::readText(folder / "out/poses.txt");
    for (const char* name : {"out/depth/0.png", "out/label/0.png", "out/camera.yaml"}) {
      if (!last.empty()) {
        EXPECT_EQ(test::readText(folder / name), last) << name << " at " << killed_us << " us";
      }
    }
    AtomicFolder(folder / "out").commit();
    for (const auto& entry : std::filesystem::directory_iterator(folder / "out"))
      EXPECT_EQ(entry.path().filename().string().find(".new"), std::string::npos)
          << "what the killed run left is still there";
  }
}

TEST(AtomicFolder, WhereAFileIsOrNobodyMayWriteIsAnError) {
  const test::TemporaryFolder folder;
  test::writeText(folder / "file", "x");
  EXPECT_EQ(test::messageOf<Error>([&] { AtomicFolder(folder / "file"); }),
            (folder / "file") + ": cannot write: it is no folder");
  EXPECT_NE(test::messageOf<Error>([&] { AtomicFolder(folder / "file/below"); }), "");
  EXPECT_NE(test::messageOf<Error>([&] { AtomicFolder("/proc/nothing"); }), "");
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

}  // namespace
}  // namespace xview
