// SPDX-License-Identifier: BSD-3-Clause
// Worlds and recordings that nobody makes on purpose: twins, mirrors, lattices, clocks that stand.
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "tools/tiny_town.h"
#include "xview/io/cloud_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

class DegenerateWorlds : public TinyTown {
 protected:
  /// A copy of the drive back whose lines of poses are changed.
  static std::string driveWith(const std::string& name,
                               const std::function<std::string(std::size_t, std::string)>& change) {
    const std::string copy = file(name);
    fs::copy(town("rear"), copy, fs::copy_options::recursive);
    std::istringstream lines(readText(town("rear") + "/poses.txt"));
    std::ofstream out(copy + "/poses.txt");
    std::size_t i = 0;
    for (std::string line; std::getline(lines, line);)
      out << (line[0] == '#' ? line : change(i++, line)) << '\n';
    return copy;
  }

  static Json answerTo(const std::string& query, const std::string& map) {
    const Outcome outcome = runXview({"localize", "-q", "--json", query, map}, {120, 0, ""});
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 3) << outcome.err;
    return jsonLines(outcome.out).at(0);
  }

  /// A town as a cloud, each point moved by a function.
  static std::string cloudWith(const std::string& name, const std::string& session,
                               const std::function<void(Point&)>& move) {
    const std::string path = file(name);
    succeed({"lift", "-q", town(session), path, "--voxel", "0.1"});
    LabelledCloud cloud = io::readCloud(path);
    for (Point& point : cloud.points) move(point);
    const LabelSet labels = io::readCloudHeader(path).labels.value();
    io::writePcd(path, cloud, &labels);
    return path;
  }
};

TEST_F(DegenerateWorlds, ATownThatIsThereTwiceMakesItsQueriesAmbiguous) {
  const auto stay = [](Point&) {};
  const std::string here = cloudWith("here.pcd", "forward", stay),
                    there = cloudWith("there.pcd", "forward", [](Point&p) { p.x += 900; }),
                    twins = file("twins.xvm"), once = file("once.xvm");
  succeed({"map", "-q", here, there, twins});
  succeed({"map", "-q", here, once});
  EXPECT_EQ(answerTo(town("rear"), once)["status"], "accepted");
  const Json answer = answerTo(town("rear"), twins);
  EXPECT_EQ(answer["status"], "ambiguous") << answer["reason"];
  EXPECT_NE(answer["reason"].get<std::string>().find("900 m apart"), std::string::npos)
      << answer["reason"];
}

TEST_F(DegenerateWorlds, AMirrorImageIsAnotherTown) {
  const std::string mirror = cloudWith("mirror.pcd", "rear", [](Point& p) { p.y = -p.y; });
  const std::string same = cloudWith("same.pcd", "rear", [](Point&) {});
  EXPECT_EQ(answerTo(same, map())["status"], "accepted");
  EXPECT_NE(answerTo(mirror, map())["status"], "accepted");
}

/// Rows of things of some classes, as far apart in both directions.
std::string latticeOf(int rows, int columns, const std::vector<std::string>& classes) {
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\n";
  for (std::size_t c = 0; c < classes.size(); ++c)
    text << "comment xview class " << c + 1 << " object " << classes[c] << " 9 9 9 " << classes[c]
         << "\n";
  text
      << "element vertex " << rows * columns
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty int label\nend_header\n";
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      text << 10 * column << " " << 10 * row << " 0 "
           << 1 + static_cast<std::size_t>(row + column) % classes.size() << "\n";
  }
  return text.str();
}

TEST_F(DegenerateWorlds, NoPlaceOfALatticeIsTheOneThatWasSeen) {
  for (const std::vector<std::string>& classes :
       {std::vector<std::string>{"pole"}, std::vector<std::string>{"pole", "sign", "trunk"}}) {
    writeText(file("lattice.ply"), latticeOf(30, 30, classes));
    writeText(file("piece.ply"), latticeOf(6, 6, classes));
    const Json answer = answerTo(file("piece.ply"), file("lattice.ply"));
    EXPECT_NE(answer["status"], "accepted") << answer["reason"];
  }
}

TEST_F(DegenerateWorlds, ClocksThatStandOrRunBackwardsChangeNoPose) {
  const Json usual = answerTo(town("rear"), map());
  const auto rest = [](const std::string& line) { return line.substr(line.find(' ')); };
  const std::string standing =
      driveWith("standing", [&](std::size_t, const std::string& line) { return "5" + rest(line); });
  const std::string backwards = driveWith("backwards", [&](std::size_t i, const std::string& line) {
    return std::to_string(5000 - static_cast<int>(i)) + rest(line);
  });
  for (const std::string& drive : {standing, backwards}) {
    EXPECT_EQ(answerTo(drive, map())["T_map_query"], usual["T_map_query"]) << drive;
    succeed({"localize", "-q", drive, map(), "--window", "20", "--stride", "10", "--track",
             "--trajectory", file("way.txt")});
    EXPECT_EQ(lineCount(readText(file("way.txt"))), 41u);
    succeed({"map", "-q", drive, file("clock.xvm")});
  }
}

TEST_F(DegenerateWorlds, OdometryThatIsNoNumberOrFarAwayIsRefusedWithItsLine) {
  for (const std::string number : {"nan", "inf", "1e308", "1e9"}) {
    fs::remove_all(file("odd"));
    const std::string odd = driveWith("odd", [&](std::size_t i, const std::string& line) {
      if (i != 7) return line;
      const std::size_t first = line.find(' ') + 1;
      return line.substr(0, first) + number + line.substr(line.find(' ', first));
    });
    const Outcome outcome = runXview({"localize", "-q", odd, map()});
    EXPECT_EQ(outcome.code, 1) << number;
    EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find("poses.txt:"), std::string::npos) << outcome.err;
  }
}

TEST_F(DegenerateWorlds, AQueryLargerThanItsMapIsRightOrRefused) {
  const std::string small = file("small.xvm");
  succeed({"map", "-q", town("forward"), "--frames", "0:5", small});
  const Json in_all = answerTo(town("rear"), map()), in_part = answerTo(town("rear"), small);
  if (in_part["status"] == "accepted") {
    const auto at = [](const Json& answer) {
      const auto p = answer["pose"]["position"].get<std::vector<double>>();
      return Eigen::Vector3d(p[0], p[1], p[2]);
    };
    EXPECT_LT((at(in_part) - at(in_all)).norm(), 5) << in_part["reason"];
  }
}

TEST_F(DegenerateWorlds, AMissingFrameIsNamed) {
  const std::string gap =
      driveWith("gap", [](std::size_t, const std::string& line) { return line; });
  fs::remove(gap + "/depth/000010.png");
  const Outcome outcome = runXview({"localize", "-q", gap, map()});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("000010"), std::string::npos) << outcome.err;
}

TEST_F(DegenerateWorlds, NamesMayHoldBlanksQuotesOtherScriptsAndBeLong) {
  const std::string folder = file("a b'c\"d äö 日本 $(e)");
  fs::create_directories(folder);
  fs::copy(town("rear"), folder + "/drive \"1\"", fs::copy_options::recursive);
  const std::string answers = folder + "/å.jsonl", page = folder + "/å.html";
  succeed({"localize", "-q", folder + "/drive \"1\"", map(), "-o", answers});
  EXPECT_EQ(jsonLines(readText(answers)).at(0)["query"]["input"], folder + "/drive \"1\"");
  succeed({"view", "-q", map(), answers, "-o", page});
  EXPECT_GT(fs::file_size(page), 100000u);
  const std::string long_name = file(std::string(240, 'x') + ".xvm");
  succeed({"map", "-q", town("rear"), long_name});
  succeed({"fuse", "-q", town("forward"), long_name});
  const Outcome too_long =
      runXview({"map", "-q", town("rear"), file(std::string(300, 'x') + ".xvm")});
  EXPECT_EQ(too_long.code, 1);
  EXPECT_EQ(lineCount(too_long.err), 1u) << too_long.err;
}

TEST_F(DegenerateWorlds, ThousandsOfFramesOfOnePointAreNothingToFind) {
  const std::string folder = file("dots");
  fs::create_directories(folder);
  std::ofstream poses(folder + "/poses.txt");
  for (int i = 0; i < 2000; ++i) {
    const std::string number = std::to_string(10000 + i);
    writeText(folder + "/" + number + ".pcd",
              "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\n"
              "COUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n"
              "1 2 0 7\n");
    poses << i << " " << 0.1 * i << " 0 0 0 0 0 1\n";
  }
  poses.close();
  const Outcome outcome = runXview(
      {"localize", "-q", folder, map(), "--labels", town("rear") + "/classes.yaml"}, {120, 0, ""});
  EXPECT_NE(outcome.code, 0);
  EXPECT_LE(outcome.code, 3);
}

}  // namespace
}  // namespace xview::test
