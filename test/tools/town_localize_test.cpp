// SPDX-License-Identifier: BSD-3-Clause
// What xview localize answers, in every mode.
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "io/image_files.h"
#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/io/label_files.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

TEST_F(TinyTown, RearViewIsFoundWhereItIs) {
  const Outcome found = succeed({"localize", "-q", "--json", town("rear"), map()});
  writeText(file("rear.jsonl"), found.out);
  const std::string report = file("report");
  const Outcome judged = succeed(
      {"evaluate", "-q", file("rear.jsonl"), town("rear") + "/groundtruth.txt", "-o", report});
  EXPECT_NE(judged.out.find("1 queries: 1 accepted"), std::string::npos) << judged.out;
  const Json summary = Json::parse(readText(report + "/summary.json"));
  EXPECT_DOUBLE_EQ(summary["accepted_only"]["within_m"]["1"].get<double>(), 1) << judged.out;
  EXPECT_EQ(summary["covariance"]["answers"].get<int>(), 1);
  EXPECT_GT(summary["covariance"]["nees_over_6_mean"].get<double>(), 0);
  for (const char* name : {"results.csv", "pr.csv", "success.csv", "report.html"}) {
    EXPECT_GT(fs::file_size(report + "/" + name), 20u) << name;
  }
  const std::string blocked = file("blocked report");
  fs::create_directories(blocked + "/summary.json");
  EXPECT_EQ(runXview({"evaluate", "-q", file("rear.jsonl"), town("rear") + "/groundtruth.txt", "-o",
                      blocked})
                .code,
            1);
  EXPECT_EQ(std::distance(fs::directory_iterator(blocked), {}), 1) << "all files or none";
}

TEST_F(TinyTown, AnExplanationThatCannotBeWrittenIsToldBeforeTheSearch) {
  const Outcome refused = runXview({"localize", "--json", town("rear"), map(), "--explain",
                                    file("no such folder") + "/why.html"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(lineCount(refused.err), 1u) << refused.err;
}

TEST_F(TinyTown, AQueryThatNamesNoClassesTakesThoseOfTheMap) {
  const std::string nameless = file("nameless");
  fs::copy(town("rear"), nameless, fs::copy_options::recursive);
  fs::remove(nameless + "/classes.yaml");
  const Outcome found = succeed({"localize", "--json", nameless, map()});
  EXPECT_NE(found.err.find("names no classes; its ids are taken as those of the map"),
            std::string::npos)
      << found.err;
  std::string named = succeed({"localize", "-q", "--json", town("rear"), map()}).out;
  named.replace(named.find(town("rear")), town("rear").size(), nameless);
  EXPECT_EQ(withoutTimes(found.out), withoutTimes(named));
}

TEST_F(TinyTown, AQueryInOtherClassesIsFoundAndSaysWhatItTookThemFor) {
  // The same drive as another program would have saved it: other ids, other words, a class that the
  // map does not know.
  const std::string foreign = file("foreign");
  fs::copy(town("rear"), foreign, fs::copy_options::recursive);
  const LabelSet labels = io::readLabelSet(foreign + "/classes.yaml");
  const std::map<std::string, std::string> words = {{"road", "street"},
                                                    {"building", "static.house"},
                                                    {"vegetation", "Plants"},
                                                    {"pole", "utility_pole"},
                                                    {"traffic light", "gnomon"}};
  std::string classes = "name: foreign\nclasses:\n";
  for (const auto& [id, info] : labels.classes()) {
    const auto word = words.find(info.name);
    classes += "  - {id: " + std::to_string(100 - id) + ", name: \"" +
               (word == words.end() ? info.name : word->second) + "\"}\n";
  }
  writeText(foreign + "/classes.yaml", classes);
  for (const auto& entry : fs::directory_iterator(foreign + "/label")) {
    LabelImage image = io::readLabels(entry.path().string());
    for (std::uint16_t& label : image.pixels) label = static_cast<std::uint16_t>(100 - label);
    io::writeLabelPng(entry.path().string(), image);
  }
  const Outcome found = succeed({"localize", "--json", "--verbose", foreign, map()});
  EXPECT_NE(found.err.find("street is road in the map (by meaning)"), std::string::npos)
      << found.err;
  EXPECT_NE(found.err.find("gnomon (no counterpart in label set"), std::string::npos) << found.err;
  const Json named =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(jsonLines(found.out).at(0)["pose"]["position"][axis].get<double>(),
                named["pose"]["position"][axis].get<double>(), 0.1);
  }
  // As part of a map, too.
  succeed({"map", "-q", town("forward"), foreign, file("both.xvm")});

  writeText(file("words.txt"), "object light: gnomon, traffic light\n");
  const Outcome told =
      succeed({"localize", "--json", "--class-names", file("words.txt"), foreign, map()});
  EXPECT_EQ(told.err.find("gnomon (no counterpart"), std::string::npos) << told.err;
}

/// Check fix for: the program translated a query into the classes of the map before the localizer
/// saw it, so that nothing was left out of the map that the query has no class for.
TEST_F(TinyTown, AQueryInOtherClassesHasTheAnswerOfTheLibrary) {
  const std::string foreign = file("without_posts");
  fs::copy(town("rear"), foreign, fs::copy_options::recursive);
  const LabelSet labels = io::readLabelSet(foreign + "/classes.yaml");
  std::set<std::uint32_t> posts;
  std::string classes = "name: without_posts\nclasses:\n";
  for (const auto& [id, info] : labels.classes()) {
    if (isPoleLike(info.kind)) posts.insert(id);
    if (!posts.count(id))
      classes += "  - {id: " + std::to_string(id) + ", name: \"" + info.name + "\"}\n";
  }
  ASSERT_FALSE(posts.empty());
  writeText(foreign + "/classes.yaml", classes);
  for (const auto& entry : fs::directory_iterator(foreign + "/label")) {
    LabelImage image = io::readLabels(entry.path().string());
    for (std::uint16_t& label : image.pixels) label = posts.count(label) ? 0 : label;
    io::writeLabelPng(entry.path().string(), image);
  }
  const Json told = jsonLines(runXview({"localize", "-q", "--json", foreign, map()}).out).at(0);
  const Localizer localizer(map::openMap(map()));
  const Localization fix = localizer.localize(*io::openRecording(foreign));
  EXPECT_EQ(told["status"], toString(fix.status));
  EXPECT_NEAR(told["p_wrong"].get<double>(), 1 - fix.confidence, 1e-6);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(told["pose"]["position"][static_cast<std::size_t>(axis)].get<double>(),
                fix.T_map_sensor.translation()[axis], 1e-3);
  }
}

TEST_F(TinyTown, UnknownIdsAreSaidWithTheirShare) {
  const std::string odd = file("odd");
  fs::copy(town("rear"), odd, fs::copy_options::recursive);
  const std::string image = odd + "/label/000003.png";
  LabelImage labels = io::readLabels(image);
  std::fill(labels.pixels.begin(), labels.pixels.end(), std::uint16_t{77});
  io::writeLabelPng(image, labels);
  const Outcome found = succeed({"localize", "--json", odd, map()});
  EXPECT_NE(found.err.find("class 77 (label set"), std::string::npos) << found.err;
}

TEST_F(TinyTown, AQueryThatTheMapWasMadeOfIsSaid) {
  const Outcome own = runXview({"localize", town("forward"), map()});
  EXPECT_NE(own.err.find("is a recording that the map was made of"), std::string::npos) << own.err;
  const Outcome other = runXview({"localize", town("rear"), map()});
  EXPECT_EQ(other.err.find("the map was made of"), std::string::npos) << other.err;
}

/// Check fix for: later frames of a recording were called those that the map was made of.
TEST_F(TinyTown, OtherFramesOfARecordingThatTheMapWasMadeOfAreAVisitOfTheirOwn) {
  const std::string part = file("part.xvm");
  succeed({"map", "-q", town("forward"), "--frames", "0:8", part});
  const auto isOwn = [&](const char* frames) {
    return runXview({"localize", town("forward"), "--frames", frames, part})
               .err.find("the map was made of") != std::string::npos;
  };
  EXPECT_TRUE(isOwn("4:12"));
  EXPECT_FALSE(isOwn("8:16"));
}

/// Check fix for: each raw cloud of a batch had a note above its line of the table.
TEST_F(TinyTown, WhereTheClassesOfRawCloudsComeFromIsSaidOnceForABatch) {
  std::vector<std::string> arguments{"localize"};
  for (const char* frames : {"0:2", "2:4"}) {
    const std::string points = file(std::string(frames, 1) + "points.ply");
    succeed({"lift", "-q", town("lidar"), "--frames", frames, points});
    arguments.push_back(points);
  }
  arguments.insert(arguments.end(), {"--labels", "shapes", map()});
  const std::string said = runXview(arguments).err;
  const std::size_t first = said.find("classes from shapes");
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("classes from shapes", first + 1), std::string::npos) << said;
}

/// Check fix for: a cloud in feet was refused without a word of that; one with x up was not found,
/// as the packed points of the map lay elsewhere for local features.
TEST_F(TinyTown, ACloudInOtherLengthsIsSaidToBeAndOneWithAnotherAxisUpIsFound) {
  const auto hintOf = [&](const std::string& name, const std::string& lines) {
    const std::string cloud = file(name + ".pcd");
    writeText(file(name + ".txt"), lines + "0 0 0 1\n");
    succeed({"lift", "-q", town("rear"), "--transform", file(name + ".txt"), cloud});
    const Outcome refused = runXview({"localize", cloud, "--labels", "shapes", map()});
    EXPECT_EQ(refused.code, 3) << refused.out;
    EXPECT_EQ(runXview({"localize", "-q", cloud, "--labels", "shapes", map()}).err, "");
    return refused.err;
  };
  const std::string typed = "`xview lift IN OUT.pcd --transform FILE` makes it so with the lines ";
  const std::string feet =
      hintOf("feet", "3.280839895 0 0 0\n0 3.280839895 0 0\n0 0 3.280839895 0\n");
  EXPECT_NE(feet.find("feet.pcd: it is found if its lengths are feet: " + typed +
                      "`0.3048 0 0 0`, `0 0.3048 0 0`, `0 0 0.3048 0`, `0 0 0 1`"),
            std::string::npos)
      << feet;
  writeText(file("x_up.txt"), "0 0 1 0\n0 1 0 0\n-1 0 0 0\n0 0 0 1\n");
  succeed({"lift", "-q", town("rear"), "--transform", file("x_up.txt"), file("x_up.pcd")});
  const Eigen::Isometry3d T_map_x_up = poseIn(Json::parse(
      succeed({"localize", "-q", "--json", file("x_up.pcd"), "--labels", "shapes", map()}).out));
  EXPECT_NEAR(T_map_x_up.linear()(2, 0), 1, 0.01) << "local features find it whichever way is up";
  const Outcome other = runXview({"localize", town("elsewhere"), map()});
  EXPECT_EQ(other.err.find("it is found if"), std::string::npos) << other.err;
  const std::string map_in_feet = file("map_in_feet.pcd"), in_metres = file("in_metres.pcd");
  succeed({"lift", "-q", town("forward"), "--transform", file("feet.txt"), map_in_feet});
  succeed({"lift", "-q", town("rear"), in_metres});
  const std::string said = runXview({"localize", in_metres, map_in_feet}).err;
  EXPECT_NE(said.find("it is found if the lengths of MAP are feet: " + typed +
                      "`0.3048 0 0 0`, `0 0.3048 0 0`, `0 0 0.3048 0`, `0 0 0 1`"),
            std::string::npos)
      << said;
}

TEST_F(TinyTown, ChancesToBeWrongAreInPercent) {
  const std::string table = succeed({"localize", "-q", town("rear"), map()}).out;
  EXPECT_NE(table.find(" wrong "), std::string::npos) << table;
  EXPECT_NE(table.find(" % "), std::string::npos) << table;
  EXPECT_EQ(table.find("1 in "), std::string::npos) << table;
}

TEST_F(TinyTown, RiskIsTheLargestChanceToBeWrongThatIsAccepted) {
  const Outcome found = succeed({"localize", "-q", "--json", town("rear"), map()});
  const double risk = 1 - jsonLines(found.out).at(0)["confidence"].get<double>();
  ASSERT_GT(risk, 2e-9);
  ASSERT_LT(risk, 0.2);
  const auto codeAt = [&](double allowed) {
    std::ostringstream text;
    text << allowed;
    return runXview({"localize", "-q", town("rear"), map(), "--risk", text.str()}).code;
  };
  EXPECT_EQ(codeAt(2 * risk), 0);
  EXPECT_EQ(codeAt(risk / 2), 3);
}

TEST_F(TinyTown, APriorOutsideOfTheMapIsMisuse) {
  const Outcome outside =
      runXview({"localize", "-q", "--json", "--near", "90000,0,10", town("rear"), map()});
  EXPECT_EQ(outside.code, 2);
  EXPECT_EQ(outside.out, "");
  EXPECT_NE(outside.err.find("the prior is outside of the map: x 90000.0"), std::string::npos)
      << outside.err;
}

TEST_F(TinyTown, WithoutAnyClassNamesShapesTellStreetsFromThings) {
  for (const char* session : {"forward", "rear"}) {
    fs::copy(town(session), file(std::string("bare_") + session), fs::copy_options::recursive);
    fs::remove(file(std::string("bare_") + session) + "/classes.yaml");
  }
  const Outcome mapped = succeed({"map", file("bare_forward"), file("bare.xvm")});
  EXPECT_NE(mapped.err.find("road: 3;"), std::string::npos) << mapped.err;
  EXPECT_NE(mapped.err.find("pole: 7"), std::string::npos) << mapped.err;
  const Json bare =
      jsonLines(succeed({"localize", "-q", "--json", file("bare_rear"), file("bare.xvm")}).out)
          .at(0);
  const Json named =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bare["pose"]["position"][axis].get<double>(),
                named["pose"]["position"][axis].get<double>(), 0.3);
  }
}

TEST_F(TinyTown, AnswerHasTheKeysOfTheContractInOrder) {
  const Json answer =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  std::vector<std::string> keys;
  for (const auto& [key, value] : answer.items()) keys.push_back(key);
  const std::vector<std::string> expected{
      "query",     "status",     "reason",     "reason_code", "confidence",     "p_wrong",
      "witnesses", "statistics", "size",       "map",         "map_checksum",   "T_map_query",
      "pose",      "covariance", "scale",      "gravity",     "gravity_reason", "inliers",
      "vertices",  "matches",    "hypotheses", "timing_ms"};
  EXPECT_EQ(keys, expected);
  EXPECT_EQ(answer["query"]["input"], town("rear"));
  EXPECT_EQ(answer["query"]["first_frame"], 0);
  const std::string copy = file("checksum_same.xvm"), other = file("checksum_other.xvm"),
                    cloud = file("checksum_map.pcd");
  fs::copy(map(), copy);
  succeed({"map", "-q", town("rear"), other});
  succeed({"lift", "-q", map(), cloud});
  const auto checksumIn = [&](const std::string& of) {
    return jsonLines(runXview({"localize", "-q", "--json", town("rear"), of}).out)
        .at(0)["map_checksum"]
        .get<std::string>();
  };
  EXPECT_EQ(checksumIn(map()).size(), 16u);
  EXPECT_EQ(checksumIn(copy), checksumIn(map()));
  EXPECT_NE(checksumIn(other), checksumIn(map()));
  EXPECT_EQ(checksumIn(cloud), checksumIn(cloud));
  EXPECT_EQ(answer["query"]["last_frame"], answer["pose"]["frame"]);
  EXPECT_EQ(answer["T_map_query"].size(), 16u);
  EXPECT_EQ(answer["covariance"].size(), 36u);
  EXPECT_EQ(answer["pose"]["position"].size(), 3u);
  EXPECT_EQ(answer["pose"]["quaternion"].size(), 4u);
  EXPECT_EQ(answer["hypotheses"][0]["T_map_query"].size(), 16u);
  for (const char* stage : {"read", "lift", "blobs", "graph", "descriptors", "matching",
                            "rejection", "pose", "refine", "total", "load_map"}) {
    EXPECT_TRUE(answer["timing_ms"].contains(stage)) << stage;
  }
}

TEST_F(TinyTown, ThreadsDoNotChangeAByte) {
  for (const char* threads : {"1", "2"}) {
    const std::string t = threads;
    succeed({"lift", "-q", "--threads", t, town("rear"), file("lift" + t + ".pcd")});
    succeed({"blobs", "-q", "--threads", t, town("rear"), file("blobs" + t + ".pcd")});
    succeed({"graph", "-q", "--threads", t, town("rear"), file("graph" + t + ".ply")});
    succeed({"map", "-q", "--threads", t, town("rear"), file("map" + t + ".xvm")});
    writeText(file("fix" + t),
              withoutTimes(runXview({"localize", "-q", "--json", "--threads", t, town("rear"),
                                     town("elsewhere"), map(), "--window", "20", "--stride", "10"})
                               .out));
  }
  for (const char* name : {"lift1.pcd", "blobs1.pcd", "graph1.ply", "map1.xvm", "fix1"}) {
    std::string other = name;
    other.replace(other.find('1'), 1, "2");
    EXPECT_FALSE(readText(file(name)).empty()) << name;
    EXPECT_TRUE(readText(file(name)) == readText(file(other))) << name << " differs from " << other;
  }
}

TEST_F(TinyTown, QueryFromElsewhereIsRefusedWithCodeThree) {
  const Outcome outcome = runXview({"localize", "-q", "--json", town("elsewhere"), map()});
  EXPECT_EQ(outcome.code, 3) << outcome.out;
  EXPECT_NE(jsonLines(outcome.out).at(0)["status"], "accepted");
}

TEST_F(TinyTown, CodeThreeSaysThatNothingWasAccepted) {
  const Outcome outcome =
      runXview({"localize", "-q", "--json", town("elsewhere"), town("rear"), map()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(jsonLines(outcome.out).at(0)["status"], "accepted");
  EXPECT_EQ(jsonLines(outcome.out).at(1)["status"], "accepted");
  EXPECT_EQ(jsonLines(outcome.out).at(1)["map"], map());
}

TEST_F(TinyTown, WindowsAreQueriesOfTheirOwn) {
  const Outcome outcome = runXview({"localize", "-q", "--json", town("rear"), map(), "--window",
                                    "20", "--stride", "10", "--tum", file("a.tum")});
  const std::vector<Json> answers = jsonLines(outcome.out);
  ASSERT_GE(answers.size(), 3u);
  EXPECT_EQ(answers[1]["query"]["first_frame"], 10);
  EXPECT_EQ(answers[1]["query"]["last_frame"], 29);
  std::size_t accepted = 0;
  for (const Json& answer : answers) accepted += answer["status"] == "accepted";
  EXPECT_EQ(lineCount(readText(file("a.tum"))), accepted);
  EXPECT_EQ(outcome.code, accepted == answers.size() ? 0 : 3);
}

TEST_F(TinyTown, WithoutJsonThereIsALinePerQueryUnderAHeading) {
  const Outcome outcome = runXview({"localize", "-q", town("rear"), map(), "--window", "20"});
  EXPECT_EQ(outcome.out.rfind("  status ", 0), 0u) << outcome.out;
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos) << "no colours in a pipe";
  EXPECT_EQ(lineCount(outcome.out), 3u) << outcome.out;
}

TEST_F(TinyTown, AFileOfJsonLeavesTheTableToTheTerminal) {
  const Outcome shown = succeed({"localize", town("rear"), map(), "-o", file("shown.jsonl")});
  EXPECT_NE(shown.out.find("accepted"), std::string::npos) << shown.out;
  EXPECT_EQ(Json::parse(readText(file("shown.jsonl")))["status"], "accepted");
  EXPECT_EQ(succeed({"localize", "-q", town("rear"), map(), "-o", file("shown.jsonl")}).out, "");
}

TEST_F(TinyTown, SeveralResultsAreJudgedTogether) {
  const std::string truth = town("rear") + "/groundtruth.txt", folder = file("together");
  succeed({"localize", "-q", town("rear"), map(), "-o", file("one.jsonl")});
  const Outcome judged =
      succeed({"evaluate", "-q", file("one.jsonl"), truth, file("one.jsonl"), truth, "-o", folder});
  EXPECT_EQ(judged.out.rfind("2 queries: 2 accepted", 0), 0u) << judged.out;
  for (const char* name : {"success.svg", "pr.svg", "calibration.svg"})
    EXPECT_EQ(readText(folder + "/" + name).rfind("<svg", 0), 0u) << name;
  EXPECT_EQ(runXview({"evaluate", file("one.jsonl"), truth, file("one.jsonl")}).code, 2);
}

TEST_F(TinyTown, GraphIsAQueryAndAMap) {
  succeed({"graph", "-q", town("forward"), file("forward.ply")});
  const Outcome outcome =
      succeed({"localize", "-q", "--json", file("forward.ply"), file("forward.ply")});
  ASSERT_EQ(lineCount(outcome.out), 1u);
  EXPECT_TRUE(poseIn(jsonLines(outcome.out)[0]).isApprox(Eigen::Isometry3d::Identity(), 1e-3))
      << outcome.out;
}

/// What is in the marks of the page: "building, -1.2 nats of 3.4, 0.56 m from its partner".
TEST_F(TinyTown, ExplanationsAddUpToTheScore) {
  const Outcome outcome =
      succeed({"localize", "-q", "--json", town("rear"), map(), "--explain", file("why.html"),
               "--refine.enabled", "false", "--posterior.enabled", "false"});
  const Json answer = jsonLines(outcome.out).at(0);
  const std::string page = readText(file("why.html")), opening = "type=\"application/json\">";
  const std::size_t begin = page.find(opening) + opening.size();
  const Json query =
      Json::parse(page.substr(begin, page.find("</script>", begin) - begin))["queries"][0];
  EXPECT_EQ(query["reason"], answer["reason"]);
  double sum = 0;
  std::size_t samples = 0, vertices = 0;
  for (const Json& group : query["marks"]) {
    for (const std::string note : group["notes"]) {
      const std::size_t comma = note.find(','), unit = note.find(" nats");
      if (unit == std::string::npos) {
        ++vertices;
        continue;
      }
      ++samples;
      const double nats = std::stod(note.substr(comma + 1, unit - comma));
      EXPECT_TRUE(nats == 0 || (group["group"] == "speaks against it") == (nats < 0)) << note;
      sum += nats;
    }
  }
  EXPECT_GT(samples, 100u);
  EXPECT_EQ(vertices, answer["inliers"].get<std::size_t>());
  const double score = answer["hypotheses"][0]["score"].get<double>();
  EXPECT_NEAR(sum, score, 0.02 * score);
  EXPECT_EQ(runXview({"localize", town("rear"), map(), "--explain", file("why.csv")}).code, 2);
}

TEST_F(TinyTown, AnswersAreATableForSpreadsheetsAsWell) {
  const std::string csv = file("answers.csv");
  EXPECT_EQ(runXview({"localize", "-q", town("rear"), town("elsewhere"), file("missing"), map(),
                      "-o", csv},
                     {120, 0, ""})
                .code,
            1);
  std::istringstream lines(readText(csv));
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].rfind("query,map,first_frame,last_frame,status,confidence,x,y,z,", 0), 0u);
  EXPECT_NE(rows[1].find(",accepted,"), std::string::npos) << rows[1];
  EXPECT_NE(rows[2].find(",rejected,"), std::string::npos) << rows[2];
  EXPECT_NE(rows[3].find(",error,"), std::string::npos) << rows[3];
  for (const char* wrong : {"answers.json", "answers.xlsx"})
    EXPECT_EQ(runXview({"localize", "-q", town("rear"), map(), "-o", file(wrong)}).code, 2);
}

TEST_F(TinyTown, FilesAboutEachOfSeveralQueriesAreInAFolder) {
  const std::string folder = file("matrices");
  succeed({"localize", "-q", town("rear"), town("aerial"), town("elsewhere"), map(), "--matrix",
           folder});
  EXPECT_TRUE(fs::exists(folder + "/rear.txt"));
  EXPECT_FALSE(fs::exists(folder + "/elsewhere.txt"));
  succeed({"localize", "-q", town("rear"), map(), "--matrix", file("alone.txt")});
  EXPECT_EQ(readText(folder + "/rear.txt"), readText(file("alone.txt")));
  fs::create_directories(file("again"));
  fs::create_directory_symlink(town("rear"), file("again/rear"));
  EXPECT_EQ(
      runXview({"localize", "-q", town("rear"), file("again/rear"), map(), "--matrix", folder})
          .code,
      2);
}

TEST_F(TinyTown, GraphsAreWrittenForOtherPrograms) {
  const std::string said = succeed({"graph", "-q", map(), file("town.graphml")}).out;
  const std::string graphml = readText(file("town.graphml"));
  const auto count = [&](const std::string& word) {
    std::size_t found = 0;
    for (auto at = graphml.find(word); at != graphml.npos; at = graphml.find(word, at + 1)) ++found;
    return std::to_string(found);
  };
  EXPECT_EQ(said.rfind(count("<node ") + " vertices, " + count("<edge ") + " edges, ", 0), 0u)
      << said;
  succeed({"graph", "-q", map(), file("town.csv")});
  EXPECT_EQ(std::to_string(lineCount(readText(file("town.csv"))) - 1), count("<node "));
  EXPECT_EQ(runXview({"graph", map(), file("town.gml")}).code, 2);
}

TEST_F(TinyTown, ImageSpaceGoesThroughAllCommandsThatMakeGraphs) {
  const std::vector<std::string> image{"--graph_space", "image"};
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), image.begin(), image.end());
    return arguments;
  };
  const std::string of_images = file("image.xvm");
  EXPECT_EQ(runXview(with({"blobs", "-q", town("forward"), file("regions.pcd")})).code, 2);
  succeed(with({"graph", "-q", town("rear"), file("image.ply")}));
  EXPECT_NE(readText(file("image.ply")).find("comment graph_space image"), std::string::npos);
  succeed(with({"map", "-q", town("forward"), of_images}));
  EXPECT_NE(succeed({"info", "-q", of_images}).out.find("graph space   image"), std::string::npos);
  for (const std::string& against : {of_images, map()}) {
    const Outcome found =
        succeed(with({"localize", "-q", "--json", "--method", "walks", town("rear"), against}));
    writeText(file("image.jsonl"), found.out);
    const std::string truth = town("rear") + "/groundtruth.txt";
    const std::string report = file("image_report");
    succeed({"evaluate", "-q", file("image.jsonl"), truth, "-o", report});
    const Json summary = Json::parse(readText(report + "/summary.json"));
    EXPECT_DOUBLE_EQ(summary["accepted_only"]["within_m"]["5"].get<double>(), 1) << against;
  }
  const Outcome scans = runXview(with({"map", "-q", town("lidar"), file("scans.xvm")}));
  EXPECT_EQ(scans.code, 2) << scans.err;
  EXPECT_NE(scans.err.find("needs depth and label images"), std::string::npos) << scans.err;
  EXPECT_FALSE(fs::exists(file("scans.xvm")));
}

/// A scan of one moment in a cloud of a whole drive, as people have them.
TEST_F(TinyTown, OneScanIsJudgedByItsRaysWhereItShowsLittle) {
  succeed({"lift", "-q", town("lidar"), file("drive.pcd")});
  succeed({"map", "-q", "--labels", "shapes", file("drive.pcd"), file("drive.xvm")});
  const auto answerTo = [&](const std::string& session, const std::string& frames) {
    return Json::parse(runXview({"localize", "-q", "--json", "--labels", "shapes", town(session),
                                 file("drive.xvm"), "--frames", frames})
                           .out);
  };
  const Json scan = answerTo("lidar_reverse", "9:10"), stretch = answerTo("lidar_reverse", "5:25");
  EXPECT_EQ(scan["status"], "accepted") << scan["reason"];
  EXPECT_FALSE(scan["statistics"].contains("map_overlap"));
  ASSERT_TRUE(scan["statistics"].contains("free_space_violation"));
  EXPECT_LT(scan["statistics"]["free_space_violation"].get<double>(), 0.5);
  EXPECT_EQ(stretch["status"], "accepted") << stretch["reason"];
  EXPECT_TRUE(stretch["statistics"].contains("map_overlap"));
  EXPECT_EQ(answerTo("lidar_elsewhere", "9:10")["status"], "rejected");
}

/// Check fix for: names of ground that nobody knew left towns without ground, where hardly anything
/// was accepted.
TEST_F(TinyTown, ATownWhoseGroundHasAnUnknownNameIsFound) {
  for (const char* session : {"forward", "rear"}) {
    const std::string renamed = file(std::string("renamed_") + session);
    fs::copy(town(session), renamed, fs::copy_options::recursive);
    std::ostringstream classes;
    const LabelSet labels = io::readLabelSet(town(session) + "/classes.yaml");
    for (const auto& [id, info] : labels.classes())
      classes << "- {id: " << id << ", name: \""
              << (isGround(info.kind) ? "zorb " + std::to_string(id) : info.name) << "\"}\n";
    writeText(renamed + "/classes.yaml", classes.str());
  }
  const Outcome mapped = runXview({"map", file("renamed_forward"), file("renamed.xvm")});
  ASSERT_EQ(mapped.code, 0) << mapped.err;
  const std::size_t surfaces = mapped.err.find("surface: ");
  ASSERT_NE(surfaces, std::string::npos) << mapped.err;
  EXPECT_NE(mapped.err.find("zorb", surfaces), std::string::npos) << mapped.err;
  const Json answer = Json::parse(
      succeed({"localize", "-q", "--json", file("renamed_rear"), file("renamed.xvm")}).out);
  EXPECT_EQ(answer["status"], "accepted");
  EXPECT_TRUE(answer["statistics"].contains("map_overlap"))
      << "what is asked where ground is known";
  const Json as_named = Json::parse(succeed({"localize", "-q", "--json", town("rear"), map()}).out);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(answer["pose"]["position"][k].get<double>(),
                as_named["pose"]["position"][k].get<double>(), 0.2);
}

}  // namespace
}  // namespace xview::test
