// SPDX-License-Identifier: BSD-3-Clause
#include "acceptance/answers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

/// The machine may be busy with other tests.
const Limits kPatient{300, 0, "", 0};

std::string joined(const std::vector<std::string>& words) {
  std::string line = "xview";
  for (const std::string& word : words) line += " " + word;
  return line;
}

std::vector<double> numbersIn(const std::string& line) {
  std::istringstream words(line);
  std::vector<double> numbers;
  for (double number; words >> number;) numbers.push_back(number);
  return numbers;
}

}  // namespace

std::string outputOf(const std::vector<std::string>& arguments) {
  const Outcome outcome = runXview(arguments, kPatient);
  EXPECT_EQ(outcome.code, 0) << joined(arguments) << ": " << outcome.err;
  return outcome.out;
}

std::string localize(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{"localize", "--json", "--quiet"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const Outcome outcome = runXview(words, kPatient);
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 3)
      << joined(words) << " ended with " << outcome.code << ": " << outcome.err;
  return outcome.out;
}

std::vector<Eigen::Vector3d> positionsIn(const std::string& path) {
  std::vector<Eigen::Vector3d> positions;
  std::istringstream lines(readText(path));
  for (std::string line; std::getline(lines, line);) {
    const std::vector<double> n = numbersIn(line);
    if (n.size() == 8) positions.emplace_back(n[1], n[2], n[3]);
    if (n.size() == 12) positions.emplace_back(n[3], n[7], n[11]);
  }
  EXPECT_FALSE(positions.empty()) << path << " holds no poses";
  return positions;
}

Eigen::Vector3d positionIn(const Json& answer) {
  if (!answer["pose"].is_object()) return Eigen::Vector3d::Constant(NAN);
  const Json& p = answer["pose"]["position"];
  return {p[0].get<double>(), p[1].get<double>(), p[2].get<double>()};
}

void count(Tally& tally, const Json& answer, double error_m, double tolerance_m) {
  ++tally.windows;
  std::ostringstream line;
  line << "\n  " << answer["query"].dump() << ": " << answer["status"] << ", " << error_m << " m, "
       << answer["reason"];
  tally.reasons += line.str();
  tally.right += error_m <= tolerance_m;
  if (answer["status"] != "accepted") return;
  ++tally.accepted;
  if (!(error_m <= tolerance_m)) ++tally.wrong;
  tally.worst_m = std::isnan(error_m) ? INFINITY : std::max(tally.worst_m, error_m);
}

Tally tallyOf(const std::string& answers, const std::vector<Eigen::Vector3d>& truth,
              double tolerance_m) {
  Tally tally;
  for (const Json& answer : jsonLines(answers)) {
    // A recording of one scan has one pose, whatever the number of the scan.
    const auto frame = truth.size() == 1 ? 0 : answer["query"]["last_frame"].get<std::size_t>();
    const Eigen::Vector3d there =
        frame < truth.size() ? truth[frame] : Eigen::Vector3d::Constant(NAN);
    count(tally, answer, (positionIn(answer) - there).norm(), tolerance_m);
  }
  return tally;
}

Tally tallyOfNegatives(const std::string& answers) {
  Tally tally;
  for (const Json& answer : jsonLines(answers)) count(tally, answer, NAN, 0);
  return tally;
}

MeshSize sizeOfMesh(const std::string& path) {
  std::istringstream in(readText(path));
  MeshSize size;
  std::string line;
  std::size_t properties = 0;  // of a vertex
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    std::string first, second;
    std::size_t count = 0;
    words >> first >> second >> count;
    if (first == "element") (second == "vertex" ? size.vertices : size.faces) = count;
    if (first == "property" && second != "list") ++properties;
  }
  EXPECT_EQ(line, "end_header") << path;
  for (std::size_t i = 0; i < size.vertices && std::getline(in, line); ++i)
    EXPECT_EQ(numbersIn(line).size(), properties) << path << ": vertex " << i;
  for (std::size_t i = 0; i < size.faces && std::getline(in, line); ++i) {
    const std::vector<double> face = numbersIn(line);
    EXPECT_EQ(face.size(), 4u) << path << ": face " << i;
    for (std::size_t k = 1; k < face.size(); ++k)
      EXPECT_LT(face[k], static_cast<double>(size.vertices)) << path << ": face " << i;
  }
  EXPECT_TRUE(in) << path << " is shorter than its header says";
  EXPECT_FALSE(std::getline(in, line)) << path << " is longer than its header says";
  return size;
}

}  // namespace xview::test
