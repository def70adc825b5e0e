// SPDX-License-Identifier: BSD-3-Clause
// Files that somebody made to fool, flood or hang the program: one line, and little time and
// memory.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "io/image_files.h"
#include "io/small_files.h"
#include "support/onnx.h"
#include "support/program.h"
#include "support/sanitizers.h"
#include "support/test_data.h"
#include "tools/sequence.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

class Hostile : public testing::Test {
 protected:
  Hostile() { writeSequence(sequence_); }

  /// One line with `expected`, no more than 2 s of computing and 400 MB, and no output.
  void expectRefused(const std::vector<std::string>& arguments, const std::string& expected,
                     int code = 1) {
    const Outcome outcome = runXview(arguments, {60, 0, ""});
    EXPECT_EQ(outcome.code, code) << outcome.err << " signal " << outcome.signal;
    EXPECT_EQ(lineCount(outcome.err), code == 1 ? 1u : 2u) << outcome.err;
    EXPECT_NE(outcome.err.find(expected), std::string::npos) << outcome.err;
    if (!kSanitized) {
      EXPECT_LT(outcome.cpu_s, 2) << outcome.err;
      EXPECT_LT(outcome.peak_mb, 400) << outcome.err;
    }
    EXPECT_FALSE(fs::exists(out_));
  }
  void makeMap() { ASSERT_EQ(runXview({"map", "-q", sequence_, map_}).code, 0); }

  TemporaryFolder folder_;
  std::string sequence_ = folder_ / "seq", map_ = folder_ / "town.xvm", out_ = folder_ / "new.xvm";
};

/// Check fix for: the search for an id that is no class never ended.
TEST_F(Hostile, AClassForEveryIdIsRefused) {
  std::string classes = "name: all\nclasses:\n";
  for (int id = 0; id < 65536; ++id)
    classes += "- {id: " + std::to_string(id) + ", name: a, role: object}\n";
  writeText(sequence_ + "/classes.yaml", classes);
  const Outcome outcome = runXview({"map", "-q", sequence_, out_}, {60, 0, ""});
  EXPECT_EQ(outcome.code, 1) << outcome.signal;
  EXPECT_NE(outcome.err.find("label set 'all': all 65536 ids"), std::string::npos) << outcome.err;
  EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
}

/// A large image that packs into little; its pixels are forgotten.
std::string largePng(int type) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", cv::Mat(12000, 12000, type, cv::Scalar(3)), bytes,
               {cv::IMWRITE_PNG_COMPRESSION, 1});
  return std::string(bytes.begin(), bytes.end());
}

/// Check fix for: 2 MB of PNG became 6.4 GB of pixels before they were compared with the camera.
TEST_F(Hostile, ImagesLargerThanTheCameraAreNotUnpacked) {
  const std::string bomb = sequence_ + "/depth/000001.png", good = readText(bomb);
  writeText(bomb, largePng(CV_16U));
  expectRefused({"map", "-q", sequence_, out_}, "000001.png: depth of 12000 x 12000 pixels");
  writeText(bomb, good);
  writeText(sequence_ + "/label/000001.png", largePng(CV_8U));
  expectRefused({"map", "-q", sequence_, out_}, "000001.png: 12000 x 12000 pixels, but ");
}

/// Check fix for: libpng, libtiff and OpenCV said it first, in lines of their own.
TEST_F(Hostile, DamagedImagesAreOneLine) {
  const std::string png = sequence_ + "/depth/000001.png", good = readText(png);
  std::string rows(48 * 129, '\0');
  rows.resize(rows.size() - 7);  // checksums and lengths are right, pixels are missing
  writeText(png, pngBytes(64u, 48u, 0, 16, rows));
  expectRefused({"map", "-q", sequence_, out_}, "000001.png: PNG damaged: its data do not unpack");

  for (const auto& entry : fs::directory_iterator(sequence_ + "/depth")) fs::remove(entry);
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  for (const char* ending : {".tiff", ".exr"}) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) {
      const std::string path = sequence_ + "/depth/00000" + std::to_string(i) + ending;
      ASSERT_TRUE(cv::imwrite(path, cv::Mat(48, 64, CV_32F, 5.0F)));
      bytes = readText(path);
    }
    const std::string path = sequence_ + "/depth/000001" + ending;
    for (const std::size_t size : {bytes.size() / 2, bytes.size() / 4, bytes.size() - 1}) {
      writeText(path, bytes.substr(0, size));
      const Outcome outcome = runXview({"map", "-q", sequence_, out_});
      EXPECT_LE(lineCount(outcome.err), 1u) << size << ": " << outcome.err;
      EXPECT_EQ(outcome.code == 0, outcome.err.empty()) << outcome.code;
      fs::remove(out_);
    }
    std::string damaged = bytes;
    for (std::size_t i = 4; i < damaged.size(); i += 3) damaged[i] ^= '\x5A';
    writeText(path, damaged);
    expectRefused({"map", "-q", sequence_, out_}, std::string("000001") + ending + ": ");
    for (int i = 0; i < 4; ++i) fs::remove(sequence_ + "/depth/00000" + std::to_string(i) + ending);
  }
}

/// Check fix for: only the operands themselves were protected, not the files in them.
TEST_F(Hostile, NoOutputIsWrittenIntoAnInput) {
  makeMap();
  const std::string poses = readText(sequence_ + "/poses.txt");
  fs::create_directory_symlink(sequence_, folder_ / "link");
  const std::string inside = sequence_ + "/poses.txt";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"localize", sequence_, map_, "-o", inside},
        std::vector<std::string>{"localize", sequence_, map_, "--tum", inside},
        std::vector<std::string>{"localize", sequence_, map_, "--tum", sequence_ + "/new.tum"},
        std::vector<std::string>{"localize", sequence_, map_, "--matrix", inside},
        std::vector<std::string>{"localize", sequence_, map_, "--initialpose", inside},
        std::vector<std::string>{"localize", sequence_, map_, "--trajectory", inside},
        std::vector<std::string>{"localize", sequence_, map_, "--explain", sequence_ + "/a.html"},
        std::vector<std::string>{"localize", folder_ / "link", map_, "-o", inside},
        std::vector<std::string>{"localize", sequence_, map_, "-o", folder_ / "link/poses.txt"},
        std::vector<std::string>{"view", map_, sequence_, "-o", sequence_ + "/depth/000001.png"},
        std::vector<std::string>{"view", map_, sequence_, sequence_ + "/new.png"},
        std::vector<std::string>{"map", sequence_, sequence_ + "/new.xvm"},
        std::vector<std::string>{"lift", sequence_, sequence_ + "/depth/../new.pcd"},
        std::vector<std::string>{"label", sequence_, sequence_ + "/labelled"},
        std::vector<std::string>{"label", sequence_, folder_.path()},
        std::vector<std::string>{"info", sequence_, "-o", inside}}) {
    std::size_t before = 0, after = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      before += entry.exists();
    const Outcome outcome = runXview(arguments);
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      after += entry.exists();
    EXPECT_EQ(outcome.code, 2) << arguments[0] << " " << arguments.back() << outcome.err;
    EXPECT_EQ(lineCount(outcome.err), 2u) << outcome.err;  // and where help is
    EXPECT_NE(outcome.err.find("which is read"), std::string::npos) << outcome.err;
    EXPECT_EQ(readText(inside), poses);
    EXPECT_EQ(after, before) << arguments[0] << " " << arguments.back();
  }
  const Outcome beside = runXview({"localize", sequence_, map_, "-o", sequence_ + ".jsonl"});
  EXPECT_EQ(beside.code, 0) << beside.err;
}

/// Check fix for: a quote in the name of a class ended the name in the file that `label` writes.
TEST_F(Hostile, NamesOfClassesAreWrittenAsTheyAre) {
  fs::rename(sequence_ + "/label", folder_ / "label");
  fs::create_directories(sequence_ + "/rgb");
  for (int i = 0; i < 4; ++i)
    cv::imwrite(sequence_ + "/rgb/00000" + std::to_string(i) + ".png",
                cv::Mat(48, 64, CV_8UC3, cv::Scalar(250, 0, 0)));
  writeText(folder_ / "classes.yaml",
            "name: \"a\\\"b\\n\\e[31m\"\nclasses:\n- {id: 0, name: 'a: \"b\", role: dynamic}'}\n- "
            "{id: 7, name: \"line\\nbreak \\\\ \\e[2J\", role: object, kind: pole}\n");
  writeText(folder_ / "net.yaml", "labels: " + (folder_ / "classes.yaml") + "\nids: [0, 7]\n");
  writeText(folder_ / "net.onnx", onnxScores({{0, 0, 0}, {0, 0, 1}}, 48, 64));
  const std::string out = folder_ / "labelled";
  const Outcome label = runXview({"label", "-q", sequence_, out, "--net", folder_ / "net.onnx",
                                  "--net-config", folder_ / "net.yaml"});
  ASSERT_EQ(label.code, 0) << label.err;
  const Outcome info = runXview({"info", "--json", out});
  ASSERT_EQ(info.code, 0) << info.err << readText(out + "/classes.yaml");
  EXPECT_NE(info.out.find("\"label_set\": \"a\\\"b\\n\\u001b[31m\""), std::string::npos)
      << info.out;
  EXPECT_NE(info.out.find("\"name\": \"line\\nbreak \\\\ \\u001b[2J\""), std::string::npos)
      << info.out;
  EXPECT_NE(info.out.find("\"role\": \"object\""), std::string::npos) << info.out;
}

bool steersTerminal(const std::string& text) {
  return text.find_first_of("\x1b\x07\r\b\x7f") != std::string::npos ||
         text.find("\xE2\x80\xAE") != std::string::npos;
}

/// Check fix for: names of classes and files, and what messages quote, reached the terminal as they
/// are.
TEST_F(Hostile, NamesDoNotSteerTheTerminal) {
  std::string yaml = "classes:\n";
  for (int id : {0, 2, 3, 7}) {
    yaml += "- {id: " + std::to_string(id) + ", role: " + (id == 0 ? "ignored" : "object") +
            ", name: \"p\\e[2J\\a\\r\\n\\u202e" + std::to_string(id) + "\"}\n";
  }
  writeText(sequence_ + "/classes.yaml", yaml);
  const std::string moved = folder_ / "se\x1b[31mq\x07";
  fs::rename(sequence_, moved);
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"map", moved, map_}, std::vector<std::string>{"info", map_},
        std::vector<std::string>{"info", moved},
        std::vector<std::string>{"blobs", moved, folder_ / "blobs.pcd"},
        std::vector<std::string>{"localize", moved, map_},
        std::vector<std::string>{"localize", "--verbose", moved, map_}}) {
    const Outcome outcome = runXview(arguments);
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 3) << arguments[0] << outcome.err;
    EXPECT_FALSE(steersTerminal(outcome.out)) << arguments[0] << ": " << outcome.out;
    EXPECT_FALSE(steersTerminal(outcome.err)) << arguments[0] << ": " << outcome.err;
  }
  writeText(moved + "/classes.yaml", "- {id: 1, name: a, role: \"\\e[31m\"}\n");
  const Outcome refused = runXview({"map", moved, out_});
  EXPECT_EQ(refused.code, 1);
  EXPECT_FALSE(steersTerminal(refused.err)) << refused.err;
  EXPECT_NE(refused.err.find("\\x1b[31m"), std::string::npos) << refused.err;
}

/// Check fix for: a pose beyond everything was kept as a key frame, and its points vanished.
TEST_F(Hostile, PosesFarFromEarthAreRefused) {
  for (const char* far : {"1e308", "1e9", "-3e8"}) {
    writeText(sequence_ + "/poses.txt", "0 0 0 1.5 0 0 0 1\n1 0 " + std::string(far) +
                                            " 1.5 0 0 0 1\n2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n");
    expectRefused({"map", "-q", sequence_, out_},
                  "poses.txt:2: expected a position within 1e+08 m of the origin");
  }
}

/// Check fix for: a frame number of 1e300 became the smallest integer.
TEST_F(Hostile, FrameNumbersInAnswersAreWholeNumbers) {
  makeMap();
  const Outcome answers = runXview({"localize", "-q", "--json", sequence_, map_});
  ASSERT_EQ(answers.code, 0) << answers.err;
  const std::string key = "\"last_frame\":3", file = folder_ / "answers.jsonl";
  ASSERT_NE(answers.out.find(key), std::string::npos);
  for (const char* value : {"1e300", "2.5", "-1e19", "18446744073709551615", "\"3\"", "null"}) {
    std::string text = answers.out;
    text.replace(text.find(key), key.size(), std::string("\"last_frame\":") + value);
    writeText(file, text);
    expectRefused({"evaluate", "-q", file, sequence_ + "/poses.txt"}, "answers.jsonl:1: ");
    expectRefused({"view", "-q", map_, file, "-o", folder_ / "a.png"}, "answers.jsonl:1: ");
  }
  std::string text = answers.out;
  text.replace(text.find(key), key.size(), "\"last_frame\":3.0");
  writeText(file, text);
  EXPECT_EQ(runXview({"evaluate", "-q", file, sequence_ + "/poses.txt"}).code, 0);
}

/// Check fix for: `graph` and `lift` wrote headers that no reader takes.
TEST_F(Hostile, NamesThatAreTooLongForAFileAreRefusedWhenItIsWritten) {
  const auto classesOf = [&](std::size_t length) {
    writeText(sequence_ + "/classes.yaml",
              "- {id: 0, name: void}\n- {id: 2, name: building}\n- "
              "{id: 3, name: road}\n- {id: 7, name: pole" +
                  std::string(length, 'x') + "}\n");
  };
  const std::string graph = folder_ / "g.ply", cloud = folder_ / "c.pcd";
  classesOf(1000000);
  ASSERT_EQ(runXview({"graph", "-q", sequence_, graph}).code, 0);
  EXPECT_EQ(runXview({"info", "-q", graph}).code, 0);
  ASSERT_EQ(runXview({"lift", "-q", sequence_, cloud}).code, 0);
  EXPECT_EQ(runXview({"info", "-q", cloud}).code, 0);
  fs::remove(graph), fs::remove(cloud);
  classesOf(1100000);
  expectRefused({"graph", "-q", sequence_, graph}, "g.ply: cannot be written: the names");
  expectRefused({"lift", "-q", sequence_, cloud}, "c.pcd: cannot be written: the names");
  EXPECT_FALSE(fs::exists(graph) || fs::exists(cloud));
}

TEST_F(Hostile, NamesOfAnyLengthMakeNoEndlessLine) {
  const std::string name(100000, 'a');
  for (const std::string& path : {name, name + ".pcd"}) {
    const Outcome outcome = runXview({"info", path});
    EXPECT_EQ(lineCount(outcome.err), 1u);
    EXPECT_LT(outcome.err.size(), 2600u);
    EXPECT_NE(outcome.err.find("aaa ... aaa"), std::string::npos);
  }
}

TEST_F(Hostile, RecordedFilesAreOneLineEach) {
  XVIEW_REQUIRE_DATA(data, "fault_inputs");
  if (!fs::exists(data)) GTEST_SKIP() << data << " is not here";
  for (const char* name : {"map_bomb_A.xvm", "map_bomb_B.xvm", "ansi_names.xvm"})
    expectRefused({"info", "-q", data + "/" + name}, "map of schema version 2");
  for (const char* name : {"undo_view.xvm", "undo_trigger.xvm"}) {
    const std::string copy = folder_ / name;
    writeText(copy, readText(data + "/" + name));
    const std::string before = readText(copy);
    expectRefused({"fuse", "-q", copy, "--undo"}, "map of schema version 2");
    EXPECT_TRUE(readText(copy) == before) << name;
  }
  expectRefused({"map", "-q", data + "/png_bad_zlib", out_}, "PNG damaged");
}

}  // namespace
}  // namespace xview::test
