// SPDX-License-Identifier: BSD-3-Clause
// Recordings, clouds and maps that are made, grown and compared.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "support/e57.h"
#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"
#include "xview/io/recording.h"
#include "xview/map/semantic_map.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

TEST_F(TinyTown, LiftedCloudsRememberTheirClasses) {
  succeed({"lift", "-q", town("forward"), file("town.pcd")});
  succeed({"lift", "-q", town("rear"), file("rear.ply")});
  const Json of_folders =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  const Json of_clouds =
      jsonLines(succeed({"localize", "-q", "--json", file("rear.ply"), file("town.pcd")}).out)
          .at(0);
  const Eigen::Vector3d last_sensor =
      io::readPoses(town("rear") + "/poses.txt").back().T_frame_sensor.translation();
  EXPECT_LT((poseIn(of_clouds) * last_sensor - poseIn(of_folders) * last_sensor).norm(), 0.1);
}

TEST_F(TinyTown, MapsInTilesAreMapsWithTheSameAnswers) {
  succeed({"lift", "-q", map(), file("whole.pcd")});
  succeed({"lift", "-q", map(), "--tiles", "20", file("tiles")});
  const auto answer = [&](const std::string& in) {
    return poseIn(jsonLines(succeed({"localize", "-q", "--json", town("rear"), in}).out).at(0));
  };
  const Eigen::Isometry3d whole = answer(file("whole.pcd")), tiled = answer(file("tiles"));
  // Points come in another order, and sums of weights move a sample of the view from above or two,
  // and with the ground some points over the height from which on something stands.
  EXPECT_LT((whole.translation() - tiled.translation()).norm(), 0.05);
  EXPECT_LT((whole.linear() - tiled.linear()).norm(), 1e-3);
  const std::string about = succeed({"info", "-q", file("tiles")}).out;
  EXPECT_NE(about.find(" tiles of 20 x 20 m, PCD binary\n"), std::string::npos) << about;
  succeed({"lift", "-q", file("tiles"), "--tiles", "50", file("larger")});
  succeed({"map", "-q", file("larger"), file("larger.xvm")});
  succeed({"view", "-q", file("larger"), file("larger.png")});
  EXPECT_EQ(runXview({"lift", map(), "--tiles", "-1", file("none")}).code, 2);
}

Json meeting(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"info", "-q", "--json"});
  return Json::parse(succeed(arguments).out);
}

TEST_F(TinyTown, WhatAQueryWillMeetInAMapIsSaid) {
  const Json same = meeting({town("rear"), map()});
  EXPECT_EQ(same["findable"], true);
  EXPECT_EQ(same["only_in_query"], Json::array());
  EXPECT_EQ(same["only_in_map"], Json::array());
  EXPECT_EQ(same["partners"][0]["by"], "name");
  EXPECT_EQ(same["size"], "town");
  EXPECT_GT(same["query_length"].get<double>(), 10);
  EXPECT_EQ(same["up"]["map"]["known"], true);
  EXPECT_EQ(same["graph_space"]["query"], "cloud");
  EXPECT_EQ(same["notes"], Json::array()) << same["notes"];
  const Json own = meeting({town("forward"), map()});
  EXPECT_NE(own["notes"].dump().find("a recording that the map was made of"), std::string::npos);
  const Json raw = meeting({town("lidar"), "--labels", "shapes", map()});
  EXPECT_EQ(raw["query_classes"], "shapes");
  EXPECT_EQ(raw["partners"][0]["by"], "kind");
  EXPECT_NE(raw["notes"].dump().find("classes from shapes: "), std::string::npos);
  const std::string text = succeed({"info", "-q", town("rear"), map()}).out;
  EXPECT_NE(text.find("\nfindable      worth a search\n"), std::string::npos) << text;
}

TEST_F(TinyTown, AQueryInMillimetresOrWithOtherClassesIsSaidToBeUnfindable) {
  const auto graph = [](const char* name, double metre) {
    std::string vertices;
    for (int i = 0; i < 40; ++i)
      vertices += std::to_string(metre * 7 * (i % 8)) + " " + std::to_string(metre * 9 * (i / 8)) +
                  " 1 7\n";
    return "ply\nformat ascii 1.0\ncomment xview class 7 object other_object 1 2 3 " +
           std::string(name) +
           "\nelement vertex 40\nproperty float x\nproperty float y\nproperty float z\n"
           "property int label\nend_header\n" +
           vertices;
  };
  writeText(file("mm.ply"), graph("pole", 1000));
  const Json millimetres = meeting({file("mm.ply"), map()});
  EXPECT_EQ(millimetres["findable"], false);
  EXPECT_NE(millimetres["reason"].get<std::string>().find("millimetres"), std::string::npos);
  writeText(file("other.ply"), graph("giraffe", 1));
  const Json other = meeting({file("other.ply"), map()});
  EXPECT_EQ(other["only_in_query"], Json::array({"giraffe"}));
  EXPECT_EQ(other["findable"], false);
  // Check fix for: classes that --class-names makes one were said to have nothing in common.
  writeText(file("words.txt"), "object pole: giraffe, pole\n");
  EXPECT_EQ(meeting({"--class-names", file("words.txt"), file("other.ply"), map()})["findable"],
            true);
}

/// The command fails, says why in one line, and leaves the map as it is; not so with --force.
void expectRefusedWithoutForce(std::vector<std::string> command, const std::string& map,
                               const std::string& why) {
  const std::string bytes = readText(map);
  const Outcome refused = runXview(command, {120, 0, ""});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find(why), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  EXPECT_TRUE(readText(map) == bytes);
  command.emplace_back("--force");
  succeed(command);
  EXPECT_FALSE(readText(map) == bytes);
}

TEST_F(TinyTown, WhatIsInAMapAlreadyIsRefused) {
  const std::string copy = file("again.xvm");
  fs::copy(map(), copy);
  expectRefusedWithoutForce({"map", "--append", town("forward"), copy}, copy,
                            " already; adding it once more");
  const Outcome learned =
      runXview({"learn", town("forward"), map(), file("own.txt")}, {120, 0, ""});
  EXPECT_EQ(learned.code, 1);
  EXPECT_NE(learned.err.find("is the drive that the map was made of"), std::string::npos)
      << learned.err;
}

/// Check fix for: a recording of another frame was added with a note, and could not be taken back.
TEST_F(TinyTown, WhatContradictsAMapIsRefused) {
  const std::string copy = file("contradicted.xvm");
  fs::copy(map(), copy);
  expectRefusedWithoutForce({"map", "--append", town("rear"), copy}, copy,
                            " m away from " + copy + "; are they in one frame?");
}

TEST_F(TinyTown, RecordingsOfTwoFramesAreSaidAndThoseOfOneAreNot) {
  succeed({"localize", "-q", town("rear"), map(), "--matrix", file("T.txt")});
  std::istringstream numbers(readText(file("T.txt")));
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T;
  for (double& number : T.reshaped<Eigen::RowMajor>()) numbers >> number;
  T(0, 3) += 4;
  std::ofstream(file("off.txt")) << T;
  const auto said = [&](const std::string& matrix) {
    succeed({"lift", "-q", town("rear"), "--transform", file(matrix), file("rear.pcd")});
    return runXview({"map", town("forward"), file("rear.pcd"), file("both.xvm")}, {120, 0, ""}).err;
  };
  EXPECT_EQ(said("T.txt").find("in one frame?"), std::string::npos);
  const std::string problem = said("off.txt");
  EXPECT_NE(problem.find(file("rear.pcd") + " does not fit " + town("forward")), std::string::npos)
      << problem;
  EXPECT_NE(problem.find("no common frame; `xview map --join`"), std::string::npos) << problem;
  const std::string heap = file("heap.xvm");
  EXPECT_EQ(runXview({"map", "-q", town("forward"), file("rear.pcd"), heap}).code, 1);
  EXPECT_FALSE(fs::exists(heap));
  succeed({"map", "-q", "--force", town("forward"), file("rear.pcd"), heap});
  T(0, 3) += 1000;
  std::ofstream(file("away.txt")) << T;
  const std::string away = said("away.txt");
  EXPECT_NE(away.find(" m away from " + town("forward") + "; are they in one frame?"),
            std::string::npos)
      << away;
}

/// A copy of a recording whose odometry measures ways 3 % too long and turns left by 5 degrees in
/// 100 m.
void makeDrifting(const std::string& recording, const std::string& copy) {
  constexpr double kLonger = 1.03, kTurn = 5 * M_PI / 180 / 100;
  fs::copy(recording, copy, fs::copy_options::recursive);
  const std::vector<io::StampedPose> given = io::readPoses(recording + "/poses.txt");
  std::vector<io::StampedPose> poses = given;
  double way_m = 0;
  for (std::size_t i = 1; i < given.size(); ++i) {
    const Eigen::Isometry3d &before = given[i - 1].T_frame_sensor, &pose = given[i].T_frame_sensor;
    const Eigen::Vector3d step = pose.translation() - before.translation();
    way_m += step.norm();
    const Eigen::AngleAxisd turn(kTurn * way_m, Eigen::Vector3d::UnitZ());
    Eigen::Isometry3d& drifted = poses[i].T_frame_sensor;
    drifted.linear() = turn * pose.linear();
    drifted.translation() = poses[i - 1].T_frame_sensor.translation() + kLonger * (turn * step);
  }
  io::writeTumPoses(copy + "/poses.txt", poses);
}

/// Check fix for: what came before the first fix was as far off as odometry had drifted until then.
TEST_F(TinyTown, ADriveThatDriftsIsAddedWhereItWasFromItsFirstFrameOn) {
  const std::string drifting = file("drifting"), grown = file("grown.xvm");
  makeDrifting(town("rear"), drifting);
  fs::copy(map(), grown);
  succeed({"fuse", "-q", drifting, grown});
  const auto truth = io::readPoses(town("rear") + "/groundtruth.txt");
  const map::SemanticMap larger = map::openMap(grown);
  std::size_t added = 0;
  for (std::size_t i = 0; i < larger.poses.size(); ++i) {
    if (larger.source_of_pose[i] == 0) continue;
    ++added;
    const Eigen::Vector3d& there =
        truth.at(static_cast<std::size_t>(larger.frames[i])).T_frame_sensor.translation();
    EXPECT_LT((larger.poses[i].translation() - there).norm(), 0.5) << "frame " << larger.frames[i];
  }
  EXPECT_GT(added, 10u);
}

/// Check fix for: the trajectory of a drive that was found by its end was as far off at its begin
/// as odometry had drifted.
TEST_F(TinyTown, TheTrajectoryOfADriveThatDriftsIsWhereItWas) {
  const std::string drifting = file("adrift"), way = file("adrift.tum");
  makeDrifting(town("rear"), drifting);
  succeed({"localize", "-q", drifting, map(), "--trajectory", way});
  const auto truth = io::readPoses(town("rear") + "/groundtruth.txt"), found = io::readPoses(way);
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_LT(
        (found[i].T_frame_sensor.translation() - truth[i].T_frame_sensor.translation()).norm(), 0.5)
        << "frame " << i;
}

/// Check fix for: the second half of a drive was taken for the first one where the drive that the
/// map was made of had passed.
TEST_F(TinyTown, ADriveIsFusedPartByPart) {
  const std::string fused = file("parts.xvm");
  fs::copy(map(), fused);
  const std::size_t frames = io::readPoses(town("rear") + "/poses.txt").size();
  const std::string half = std::to_string(frames / 2);
  succeed({"fuse", "-q", town("rear"), fused, "--frames", "0:" + half});
  succeed({"fuse", "-q", town("rear"), fused, "--frames", half + ":" + std::to_string(frames)});
  const std::size_t all = map::openMap(fused).frames.size();
  EXPECT_GT(all, map::openMap(map()).frames.size());
  const Outcome again =
      runXview({"fuse", "-q", town("rear"), fused, "--frames", "0:" + half}, {120, 0, ""});
  EXPECT_NE(again.err.find(" already; adding it once more"), std::string::npos) << again.err;
  EXPECT_EQ(map::openMap(fused).frames.size(), all);
}

TEST_F(TinyTown, ADriveFusedUnderAnotherNameIsRefused) {
  const std::string fused = file("fused.xvm");
  fs::copy(map(), fused);
  succeed({"fuse", "-q", town("rear"), fused});
  fs::copy(town("rear"), file("another"), fs::copy_options::recursive);
  expectRefusedWithoutForce({"fuse", file("another"), fused}, fused,
                            " already; adding it once more");
}

/// How far the key frames of a source lie from where they should, at most [m].
double worstPose(const std::string& map_path, const std::string& recording) {
  const map::SemanticMap map = map::unpacked(map::openMap(map_path));
  const std::vector<io::StampedPose> truth = io::readPoses(recording + "/groundtruth.txt");
  const auto source = static_cast<std::size_t>(
      std::find(map.sources.begin(), map.sources.end(), recording) - map.sources.begin());
  double worst_m = 0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    if (map.source_of_pose[i] != source) continue;
    ++found;
    const auto frame = static_cast<std::size_t>(map.frames[i]);
    worst_m = std::max(
        worst_m,
        (map.poses[i].translation() - truth.at(frame).T_frame_sensor.translation()).norm());
  }
  EXPECT_GT(found, 5u) << recording;
  return worst_m;
}

TEST_F(TinyTown, SessionsWithoutACommonFrameAreJoinedAndStrangersLeftOut) {
  const std::string joined = file("joined.xvm");
  const Outcome outcome = succeed({"map", "-q", "--join", "--matrix", file("placed"),
                                   town("forward"), town("elsewhere"), town("rear"), joined});
  EXPECT_TRUE(io::readMatrix(file("placed/forward.txt")).isApprox(Eigen::Affine3d::Identity()));
  EXPECT_FALSE(fs::exists(file("placed/elsewhere.txt")));
  const Eigen::Affine3d T_map_rear = io::readMatrix(file("placed/rear.txt"));
  const Eigen::Vector3d begin = io::openRecording(town("rear"))->pose(0).translation();
  const auto truth = io::readPoses(town("rear") + "/groundtruth.txt").front();
  EXPECT_LT((T_map_rear * begin - truth.T_frame_sensor.translation()).norm(), 0.5);
  EXPECT_EQ(runXview({"map", "--matrix", file("placed"), town("rear"), joined}).code, 2);
  EXPECT_EQ(outcome.out.find(town("elsewhere") + ": left out: "), 0u) << outcome.out;
  EXPECT_EQ(map::unpacked(map::openMap(joined)).sources,
            (std::vector<std::string>{town("forward"), town("rear")}));
  EXPECT_LT(worstPose(joined, town("rear")), 0.5);
  succeed({"map", "-q", "--undo", joined});
  EXPECT_EQ(map::unpacked(map::openMap(joined)).sources, std::vector<std::string>{town("forward")});

  succeed({"map", "-q", town("rear"), file("rear.xvm")});
  succeed({"map", "-q", "--join", "--append", file("rear.xvm"), joined});
  EXPECT_LT(worstPose(joined, town("rear")), 0.5) << "a map is turned into the frame of the other";

  const std::string none = file("none.xvm");
  EXPECT_EQ(runXview({"map", "--join", town("forward"), town("elsewhere"), none}).code, 3);
  EXPECT_FALSE(fs::exists(none));
}

/// What a cloud has, with its classes.
E57Points setupOf(const std::string& path) {
  E57Points setup;
  setup.columns = {e57Real("cartesianX", 64), e57Real("cartesianY", 64), e57Real("cartesianZ", 64),
                   e57Whole("label", 0, 255)};
  const LabelledCloud cloud = io::readCloud(path);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.position(i);
    setup.rows.push_back({p.x(), p.y(), p.z(), static_cast<double>(cloud.points[i].label)});
  }
  setup.packets = 1 + cloud.size() / 2000;  // which have 64 KB at most
  return setup;
}

TEST_F(TinyTown, SetupsOfAnE57AreJoinedAsFilesAre) {
  const std::string site = file("site.e57"), joined = file("site.xvm");
  succeed({"lift", "-q", "--voxel", "0.3", town("forward"), file("setup_1.pcd")});
  succeed({"lift", "-q", "--voxel", "0.3", town("rear"), file("setup_2.pcd")});
  writeText(site,
            e57Paged(e57Content({setupOf(file("setup_1.pcd")), setupOf(file("setup_2.pcd"))})));
  succeed({"map", "-q", "--join", "--matrix", file("setups"), "--labels",
           town("forward") + "/classes.yaml", site, joined});
  EXPECT_EQ(map::openMap(joined).sources, (std::vector<std::string>{site + "#1", site + "#2"}));
  EXPECT_TRUE(io::readMatrix(file("setups/site_1.txt")).isApprox(Eigen::Affine3d::Identity()));
  const Eigen::Vector3d begin = io::openRecording(town("rear"))->pose(0).translation();
  const auto truth = io::readPoses(town("rear") + "/groundtruth.txt").front();
  EXPECT_LT((io::readMatrix(file("setups/site_2.txt")) * begin - truth.T_frame_sensor.translation())
                .norm(),
            0.5);
}

/// Check fix for: one scan that could not be read lost the work on all others.
TEST_F(TinyTown, JoinsWhatCanBeReadAndItsExitCodeRemembersTheRest) {
  const std::string broken = file("broken_setup.pcd"), joined = file("with_broken.xvm");
  writeText(broken,
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 3\nDATA ascii\n1 2\n");
  const Outcome run =
      runXview({"map", "-q", "--join", town("forward"), broken, town("rear"), joined});
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_NE(run.err.find("error: " + broken + ":"), std::string::npos) << run.err;
  const Outcome missing =
      runXview({"map", "--join", town("forward"), town("rear"), file("no.pcd"), joined});
  EXPECT_EQ(missing.code, 1);
  EXPECT_EQ(missing.err.rfind("error: " + file("no.pcd") + ": no such file", 0), 0u)
      << "before any work: " << missing.err;
  EXPECT_EQ(map::openMap(joined).sources,
            (std::vector<std::string>{town("forward"), town("rear")}));
}

TEST_F(TinyTown, EveryChangeIsOnRecordAndCanBeTakenBack) {
  const std::string path = file("history.xvm");
  fs::copy(map(), path);
  const std::string first = succeed({"info", path}).out;
  EXPECT_EQ(first.find("changes"), std::string::npos);
  succeed({"fuse", "-q", town("rear"), path});
  succeed({"map", "-q", "--append", "--force", town("rear"), path});
  const std::string both = succeed({"info", path}).out;
  EXPECT_NE(both.find("fused " + town("rear") + ", wrong "), std::string::npos) << both;
  EXPECT_NE(both.find("; appended " + town("rear")), std::string::npos) << both;
  EXPECT_NE(succeed({"map", "--undo", path}).out.find("taken back: appended "), std::string::npos);
  EXPECT_NE(succeed({"fuse", "--undo", path}).out.find("taken back: fused "), std::string::npos);
  EXPECT_EQ(succeed({"info", path}).out, first);
  EXPECT_EQ(runXview({"map", "--undo", path}).code, 1);
  EXPECT_EQ(runXview({"map", "--undo", town("rear"), path}).code, 2);
}

TEST_F(TinyTown, WhatOneSourceAddedIsTakenOutAndLaterAdditionsStay) {
  const std::string path = file("with.xvm"), never = file("never.xvm");
  fs::copy(map(), path);
  fs::copy(map(), never);
  const std::vector<std::string> again{"map",           "-q",       "--append", "--force",
                                       town("forward"), "--frames", "0:20"};
  const auto append = [&](const std::string& target) {
    std::vector<std::string> command = again;
    command.push_back(target);
    succeed(command);
  };
  succeed({"fuse", "-q", town("rear"), path});
  append(path);
  append(never);
  succeed({"map", "-q", "--without", town("rear"), path});
  EXPECT_EQ(map::unpacked(map::openMap(path)).sources, map::unpacked(map::openMap(never)).sources);
  succeed({"graph", "-q", path, file("with.ply")});
  succeed({"graph", "-q", never, file("never.ply")});
  EXPECT_TRUE(readText(file("with.ply")) == readText(file("never.ply")));
  const std::string bytes = readText(path);
  for (const std::string& source : {town("aerial"), town("forward")})
    EXPECT_EQ(runXview({"map", "--without", source, path}).code, source == town("aerial") ? 1 : 0);
  EXPECT_EQ(runXview({"map", "--without", town("forward"), map()}).code, 1) << "it began with that";
}

TEST_F(TinyTown, WhatNobodySeesAnyMoreIsForgotten) {
  const std::string path = file("pruned.xvm");
  fs::copy(map(), path);
  EXPECT_EQ(runXview({"prune", path, "--absent", "1"}).code, 1) << "nothing was added";
  succeed({"fuse", "-q", town("rear"), path});
  const std::string before = readText(path);
  const Outcome pruned = succeed({"prune", "-q", path, "--absent", "1", "-o", file("less.xvm")});
  EXPECT_NE(pruned.out.find(" things forgotten"), std::string::npos) << pruned.out;
  EXPECT_LT(map::unpacked(map::openMap(file("less.xvm"))).graph.size(),
            map::unpacked(map::openMap(path)).graph.size())
      << "cars and people have moved on";
  EXPECT_EQ(map::readRevisions(file("less.xvm")).back().note.rfind("pruned ", 0), 0u);
  EXPECT_TRUE(readText(path) == before);
  /// Check fix for: without anything to forget the map that was asked for was not written.
  const Outcome same =
      succeed({"prune", "-q", file("less.xvm"), "--absent", "1", "-o", file("same.xvm")});
  EXPECT_EQ(same.out.rfind(file("same.xvm") + ": 0 of ", 0), 0u) << same.out;
  EXPECT_TRUE(readText(file("same.xvm")) == readText(file("less.xvm")));
  EXPECT_EQ(runXview({"prune", path, "--absent", "2"}).code, 1);
  EXPECT_EQ(runXview({"prune", path, "--absent", "0"}).code, 2);
}

TEST_F(TinyTown, ScansAreReadBackAsScans) {
  const Outcome outcome = succeed({"info", "-q", town("lidar")});
  EXPECT_NE(outcome.out.find("semantic_kitti"), std::string::npos) << outcome.out;
}

TEST_F(TinyTown, FuseAddsInOnePieceAndUndoTakesItBack) {
  const std::string copy = file("copy.xvm");
  fs::copy_file(map(), copy);
  const auto vertices = [&] { return succeed({"graph", "-q", copy, file("copy.ply")}).out; };
  const std::string before = vertices();
  succeed({"fuse", "-q", town("rear"), copy});
  EXPECT_NE(vertices(), before);
  succeed({"fuse", "-q", "--undo", copy});
  EXPECT_EQ(vertices(), before);
  EXPECT_EQ(runXview({"fuse", "-q", "--undo", copy}).code, 1);
}

TEST_F(TinyTown, FusesAtOneTimeBothStay) {
  const std::string copy = file("shared.xvm");
  fs::copy_file(map(), copy);
  std::thread other([&] { succeed({"fuse", "-q", town("rear"), copy}); });
  succeed({"fuse", "-q", town("aerial"), copy});
  other.join();
  const std::string about = succeed({"info", copy}).out;
  for (const std::string& source : {town("forward"), town("rear"), town("aerial")})
    EXPECT_NE(about.find(source), std::string::npos) << about;
}

TEST_F(TinyTown, FuseLeavesTheMapAloneIfTheQueryIsNotAccepted) {
  const std::string bytes = readText(map());
  EXPECT_EQ(runXview({"fuse", "-q", town("elsewhere"), map()}).code, 3);
  EXPECT_TRUE(readText(map()) == bytes);
}

TEST_F(TinyTown, WhatIsLearnedIsNotWrittenOverTheMap) {
  const std::string bytes = readText(map());
  EXPECT_EQ(runXview({"learn", "-q", town("rear"), map(), map()}).code, 2);
  EXPECT_TRUE(readText(map()) == bytes);
}

TEST_F(TinyTown, AMapThatCannotBeWrittenIsToldBeforeTheWork) {
  const Outcome refused = runXview({"map", town("forward"), file("no such folder") + "/town.xvm"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(lineCount(refused.err), 1u) << refused.err;
}

TEST_F(TinyTown, ARecordingThatDoesNotFitOntoTheDiskLeavesNothing) {
  Limits full;
  full.file_size_bytes = 2000;  // enough for poses, not for images
  const Outcome failed = runXview({"simulate", "-q", file("full"), "--route_length_m", "20",
                                   "--width", "160", "--height", "120"},
                                  full);
  EXPECT_EQ(failed.code, 1);
  EXPECT_EQ(lineCount(failed.err), 1u) << failed.err;
  EXPECT_FALSE(fs::exists(file("full")));
  fs::create_directories(file("kept"));
  runXview({"simulate", "-q", file("kept/town"), "--route_length_m", "20", "--width", "160",
            "--height", "120"},
           full);
  EXPECT_TRUE(fs::is_empty(file("kept")));
}

TEST_F(TinyTown, FuseIntoAnotherFileLeavesTheMapAlone) {
  const std::string bytes = readText(map()), larger = file("larger.xvm");
  succeed({"fuse", "-q", town("rear"), map(), "-o", larger});
  EXPECT_TRUE(readText(map()) == bytes);
  EXPECT_NE(succeed({"info", larger}).out.find(town("rear")), std::string::npos);
  fs::remove(larger);
  EXPECT_EQ(runXview({"fuse", "-q", town("elsewhere"), map(), "-o", larger}).code, 3);
  EXPECT_FALSE(fs::exists(larger));
}

TEST_F(TinyTown, LikelihoodsThatWereLearnedAreUsed) {
  const std::string table = file("learned.txt");
  const Outcome learned =
      succeed({"learn", "-q", town("rear"), town("aerial"), map(), table, "--length", "30"});
  EXPECT_NE(learned.out.find("samples at true poses"), std::string::npos) << learned.out;
  const auto scoreWith = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments{"localize", "-q", "--json", town("rear"), map()};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return jsonLines(succeed(arguments).out).at(0)["hypotheses"][0]["score"].get<double>();
  };
  const double built_in = scoreWith({});
  EXPECT_NE(scoreWith({"--places.likelihoods", table}), built_in);
  EXPECT_EQ(runXview({"localize", town("rear"), map(), "--places.likelihoods", map()}).code, 1)
      << "a map is no table";
}

TEST_F(TinyTown, LearningNeedsTruePoses) {
  const std::string blind = file("blind");
  fs::copy(town("rear"), blind, fs::copy_options::recursive);
  fs::remove(blind + "/groundtruth.txt");
  const Outcome outcome = runXview({"learn", "-q", blind, map(), file("none.txt")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("groundtruth.txt"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(file("none.txt")));
  succeed({"learn", "-q", blind, map(), file("none.txt"), "--length", "30", "--truth",
           town("rear") + "/groundtruth.txt"});
}

TEST_F(TinyTown, AVerdictIsLearnedFromAnswersThatSayAllItIsMadeOf) {
  const std::string answers = file("judged.jsonl"), model = file("verdict.txt");
  const Outcome found = runXview({"localize", "-q", "--json", town("rear"), town("elsewhere"),
                                  map(), "--window", "20", "--stride", "10"});
  writeText(answers, found.out);
  const Outcome learned = succeed({"learn", "--verdict", answers, model});
  const auto rights = static_cast<std::size_t>(std::stoi(learned.out.substr(model.size() + 2)));
  EXPECT_GE(rights, 2u) << learned.out;
  EXPECT_LT(rights, lineCount(found.out)) << learned.out;
  EXPECT_NE(readText(model).find("registered.margin "), std::string::npos);

  for (const char* name : {"\"dense_margin\":", "\"miss_ratio\":"}) {
    std::string older = found.out;
    const std::size_t at = older.find(name);
    ASSERT_NE(at, std::string::npos) << name;
    older.replace(at, std::strlen(name), "\"other\":");
    writeText(answers, older);
    const Outcome refused = runXview({"learn", "--verdict", answers, file("older.txt")});
    EXPECT_EQ(refused.code, 1);
    EXPECT_NE(refused.err.find("localize again"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(file("older.txt")));
  }

  // What decides bare graphs only is not asked of answers that were registered.
  std::string older = found.out;
  const std::string key = "\"vertex_inlier_ratio\":";
  ASSERT_NE(older.find(key), std::string::npos);
  for (std::size_t at; (at = older.find(key)) != std::string::npos;)
    older.replace(at, key.size(), "\"other\":");
  writeText(answers, older);
  succeed({"learn", "--verdict", answers, file("older.txt")});
}

TEST_F(TinyTown, AnswersOfGraphsAreJudgedByTheTruthBesideThem) {
  for (const char* graph : {"map.ply", "query.ply", "elsewhere.ply"}) {
    const std::string session =
        town(graph == std::string("elsewhere.ply") ? "elsewhere" : "forward");
    succeed({"graph", "-q", session, file(graph)});
  }
  writeText(file("query.truth.txt"), "1 0 0 0 0 1 0 0 0 0 1 0\n");
  writeText(file("answers.jsonl"), runXview({"localize", "-q", "--json", file("query.ply"),
                                             file("elsewhere.ply"), file("map.ply")})
                                       .out);
  const Outcome learned =
      succeed({"learn", "--verdict", file("answers.jsonl"), file("verdict.txt")});
  EXPECT_EQ(learned.out, file("verdict.txt") + ": 1 right and 1 wrong answers\n");
  EXPECT_NE(readText(file("verdict.txt")).find("bare.margin "), std::string::npos);
}

TEST_F(TinyTown, AShorterDriveInTheSameFolderLeavesNoOldFrames) {
  for (const char* length : {"20", "10"}) {
    succeed({"simulate", "-q", file("again"), "--route_length_m", length, "--width", "64",
             "--height", "48", "--sessions.rear=false", "--sessions.aerial=false"});
  }
  EXPECT_NE(succeed({"info", "-q", file("again/forward")}).out.find("frames        5,"),
            std::string::npos);
}

TEST_F(TinyTown, AppendingGrowsTheMapAndNotAppendingReplacesIt) {
  const std::string grown = file("grown.xvm");
  succeed({"map", "-q", town("forward"), "--frames", "0:20", grown});
  const auto keyframes = [&] { return succeed({"info", "-q", grown}).out; };
  const std::string first = keyframes();
  succeed({"map", "-q", "--append", town("forward"), "--frames", "20:40", grown});
  EXPECT_NE(keyframes(), first);
  succeed({"map", "-q", town("forward"), "--frames", "0:20", grown});
  EXPECT_EQ(keyframes(), first);
}

TEST_F(TinyTown, DiffComparesAVisitWithTheMap) {
  const Outcome outcome = succeed({"diff", map(), town("rear"), "-o", file("changes.csv")});
  EXPECT_EQ(outcome.out.find("0 gone, 0 new, 0 moved (of "), 0u) << outcome.out;
  EXPECT_EQ(readText(file("changes.csv")).rfind("change,class,dynamic,x,y,z,", 0), 0u);
  const std::string seen = outcome.out.substr(outcome.out.find("(of ") + 4);
  EXPECT_GT(std::stoi(seen), 3) << outcome.out;
  succeed({"diff", "-q", map(), town("rear"), "-o", file("changes.ply")});
  EXPECT_NE(readText(file("changes.ply")).find("element vertex"), std::string::npos);
  succeed({"diff", "-q", map(), town("rear"), "-o", file("changes.html")});
  EXPECT_NE(readText(file("changes.html")).find("seen by both"), std::string::npos);
}

/// Check fix for: what was seen without labels was translated into classes of the map, which the
/// map no longer had (diff) or which are others in it (fuse).
TEST_F(TinyTown, AVisitWithoutLabelsMeetsAMapWithLabelsByKind) {
  succeed({"diff", "-q", "--labels", "shapes", map(), town("rear"), "-o", file("raw.csv")});
  for (const char* indoors : {"ceiling", "table"})
    EXPECT_EQ(readText(file("raw.csv")).find(indoors), std::string::npos);
  const std::string grown = file("grown_by_raw.xvm");
  fs::copy_file(map(), grown);
  succeed({"fuse", "-q", "--labels", "shapes", town("rear"), grown});
}

/// Check fix for: clouds that lie far from the origin of their frame were found, and then put into
/// the map by the pose of another point.
TEST_F(TinyTown, AVisitIsTheSameWhereverItsFrameHasItsOrigin) {
  succeed({"lift", "-q", "--voxel", "0.2", town("forward"), file("first.ply")});
  succeed({"lift", "-q", "--voxel", "0.2", town("rear"), file("visit.ply")});
  const std::string first = file("first.xvm"), labels = town("forward") + "/classes.yaml";
  succeed({"map", "-q", "--labels", labels, file("first.ply"), first});
  const auto boundsOf = [](const std::string& path) {
    Eigen::AlignedBox3d box;
    for (const auto& vertex : map::unpacked(map::openMap(path)).graph.vertices)
      box.extend(vertex.position);
    return box;
  };
  const auto expectNear = [](const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
    EXPECT_LT((a.min() - b.min()).norm() + (a.max() - b.max()).norm(), 1);
  };
  std::optional<Eigen::AlignedBox3d> fused_here, joined_here;
  for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, 0, 0),
                                        Eigen::Vector3d(512000, 5412000, 400)}) {
    SCOPED_TRACE(origin.transpose());
    io::writeMatrix(file("move.txt"), Eigen::Isometry3d(Eigen::Translation3d(origin)));
    const std::string visit = file("visit_far.ply"), grown = file("grown_far.xvm"),
                      joined = file("joined_far.xvm");
    succeed({"lift", "-q", file("visit.ply"), "--transform", file("move.txt"), "-o", visit});
    succeed({"localize", "-q", "--labels", labels, visit, first, "--trajectory", file("way.txt"),
             "--tum", file("end.txt"), "--matrix", file("T.txt")});
    const Eigen::Isometry3d by_way = io::readPoses(file("way.txt")).back().T_frame_sensor,
                            by_end = io::readPoses(file("end.txt")).back().T_frame_sensor;
    EXPECT_LT((by_way.translation() - by_end.translation()).norm(), 1e-5);
    fs::copy_file(first, grown, fs::copy_options::overwrite_existing);
    succeed({"fuse", "-q", "--labels", labels, visit, grown});
    const Eigen::AlignedBox3d fused = boundsOf(grown);
    expectNear(fused, fused_here.value_or(fused));
    if (!fused_here) fused_here = fused;
    succeed({"map", "-q", "--labels", labels, "--join", file("first.ply"), visit, joined});
    const Eigen::AlignedBox3d of_both = boundsOf(joined);
    expectNear(of_both, joined_here.value_or(of_both));
    if (!joined_here) joined_here = of_both;
    const std::string changes = succeed({"diff", "-q", "--labels", labels, first, visit}).out;
    EXPECT_EQ(changes.find("(of 0 "), std::string::npos) << changes;
    runXview({"localize", "-q", "--labels", labels, visit, first, "--initialpose",
              file("far_pose.yaml")});
    runXview(
        {"follow", "-q", "--labels", labels, visit, first, "--initialpose", file("far_now.yaml")});
    for (const char* pose : {"far_pose.yaml", "far_now.yaml"})
      EXPECT_FALSE(fs::exists(file(pose))) << pose << ": no sensor was there";
  }
}

TEST_F(TinyTown, DiffRefusesWhatItCannotCompare) {
  writeText(file("changes.csv"), "of an earlier visit");
  const Outcome elsewhere =
      runXview({"diff", map(), town("elsewhere"), "-o", file("changes.csv")}, {120, 0, ""});
  EXPECT_EQ(elsewhere.code, 3);
  EXPECT_NE(elsewhere.out.find("not found in the map, nothing is compared: "), std::string::npos);
  EXPECT_FALSE(fs::exists(file("changes.csv")));
  succeed({"graph", "-q", map(), file("bare.ply")});
  const Outcome bare = runXview({"diff", map(), file("bare.ply")}, {120, 0, ""});
  EXPECT_NE(bare.code, 0);
  EXPECT_EQ(runXview({"diff", map(), town("rear"), "-o", "changes.txt"}).code, 2);
}

}  // namespace
}  // namespace xview::test
