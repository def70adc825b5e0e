// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "compare/self_similarity.h"
#include "inputs.h"
#include "outputs.h"
#include "process/atomic_file.h"
#include "scenes.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"

namespace xview::tools {
namespace {

constexpr std::size_t kPlaces = 60;  ///< at 5 lengths each: some seconds for any map

/// Among the lengths that were tried, from short to long; their number for what nothing tells.
std::size_t rankOf(const SelfSimilarity::Place& place, const SelfSimilarity& self_similarity) {
  const std::vector<double>& lengths = self_similarity.lengths_m;
  return static_cast<std::size_t>(
      std::find(lengths.begin(), lengths.end(), place.min_query_length_m.value_or(-1)) -
      lengths.begin());
}

/// From green for what a few metres tell to red for what nothing tells.
Color colorOf(const SelfSimilarity::Place& place, const SelfSimilarity& self_similarity) {
  const double share =
      static_cast<double>(rankOf(place, self_similarity)) /
      static_cast<double>(std::max<std::size_t>(1, self_similarity.lengths_m.size()));
  return {static_cast<std::uint8_t>(40 + 190 * std::min(1.0, 2 * share)),
          static_cast<std::uint8_t>(40 + 130 * std::min(1.0, 2 - 2 * share)), 40};
}

std::string nameOf(const SelfSimilarity::Place& place) {
  return place.min_query_length_m ? fmt::format("sure from {:.0f} m on", *place.min_query_length_m)
                                  : "not sure at all";
}

std::string toCsv(const SelfSimilarity& self_similarity) {
  std::string text = "x,y,z,sure_from_m,like_x,like_y,like_z\n";
  for (const SelfSimilarity::Place& place : self_similarity.places) {
    const Eigen::Vector3d& p = place.position;
    text += fmt::format("{:.2f},{:.2f},{:.2f},", p.x(), p.y(), p.z());
    text += place.min_query_length_m ? fmt::format("{:.0f},", *place.min_query_length_m)
                                     : std::string(",");
    if (place.second_best)
      text += fmt::format("{:.2f},{:.2f},{:.2f}", place.second_best->x(), place.second_best->y(),
                          place.second_best->z());
    else
      text += ",,";
    text += "\n";
  }
  return text;
}

/// Share of the places where a query of this length is sure, in percent.
double percentSure(const SelfSimilarity& self_similarity, const WrongScores& scores) {
  const auto sure =
      std::count_if(self_similarity.queries.begin(), self_similarity.queries.end(),
                    [&](const SelfQuery& q) { return q.window_m == scores.window_m && q.sure; });
  return 100.0 * static_cast<double>(sure) / static_cast<double>(scores.queries);
}

/// The path in the colour of its places, and lines between similar places.
Scene sceneOfLookalikes(const map::SemanticMap& map, const SelfSimilarity& self_similarity,
                        const Job& job) {
  Scene scene = tools::sceneOf(map);
  scene.title = "how far one must go to be sure";
  scene.caption = fmt::format("{}: share of {} places where a query of a length is sure",
                              job.operands[0], self_similarity.places.size());
  scene.made_by = madeBy(job);
  for (const WrongScores& scores : wrongScores(self_similarity))
    scene.facts.emplace_back(fmt::format("{:.0f} m", scores.window_m),
                             fmt::format("{:.0f} %", percentSure(self_similarity, scores)));
  std::multimap<std::size_t, SceneLine> by_rank;  // the legend goes from short to long
  for (const SelfSimilarity::Place& place : self_similarity.places) {
    if (place.second_best)
      by_rank.emplace(
          self_similarity.lengths_m.size(),
          SceneLine{"look alike", {200, 180, 215}, {place.position, *place.second_best}});
  }
  for (std::size_t i = 0; i < self_similarity.places.size(); ++i) {
    const SelfSimilarity::Place& place = self_similarity.places[i];
    if (!place.key_frame) continue;  // nobody is known to have gone there
    SceneLine line{nameOf(place), colorOf(place, self_similarity), {}};
    const std::size_t end = i + 1 < self_similarity.places.size()
                                ? *self_similarity.places[i + 1].key_frame + 1
                                : map.poses.size();
    for (std::size_t k = *place.key_frame; k < end; ++k)
      line.points.push_back(map.poses[k].translation());
    if (line.points.size() > 1) by_rank.emplace(rankOf(place, self_similarity), std::move(line));
  }
  for (auto& [rank, line] : by_rank) scene.lines.push_back(std::move(line));
  return scene;
}

/// What the map holds, each point with the length of the nearest place as its class.
void writeColoured(const std::string& path, const map::SemanticMap& map,
                   const SelfSimilarity& self_similarity) {
  LabelSet labels("lookalikes");
  const auto labelOf = [&](const SelfSimilarity::Place& place) {
    return static_cast<std::uint32_t>(rankOf(place, self_similarity)) + 1;
  };
  for (const SelfSimilarity::Place& place : self_similarity.places)
    labels.add({labelOf(place), nameOf(place), colorOf(place, self_similarity), Role::object,
                Kind::other_object, false});
  LabelledCloud cloud = map.cloud;
  if (cloud.empty()) {
    for (const Vertex& v : map.graph.vertices) {
      Point point;
      point.getVector3fMap() = v.position.cast<float>();
      cloud.points.push_back(point);
    }
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.position(i);
    const auto nearest =
        std::min_element(self_similarity.places.begin(), self_similarity.places.end(),
                         [&](const auto& a, const auto& b) {
                           return (a.position - p).squaredNorm() < (b.position - p).squaredNorm();
                         });
    cloud.points[i].label = labelOf(*nearest);
  }
  writeCloud(path, cloud, labels);
}

void printSummary(const SelfSimilarity& self_similarity) {
  for (const WrongScores& scores : wrongScores(self_similarity)) {
    fmt::print(
        "{:4.0f} m: sure at {:3.0f} % of {} places; the best wrong one has in the middle {:.0f} %, "
        "at worst {:.0f} % of the score of the right one\n",
        scores.window_m, percentSure(self_similarity, scores), scores.queries,
        100 * scores.share.front(), 100 * scores.share.back());
  }
}

class LookalikesCommand final : public Command {
 public:
  Description describe() const override {
    return {"lookalikes", "MAP",
            "which places of a map look alike, and how long a query must be there to be sure",
            "Stretches of the map are looked for in the map itself, with the noise of a usual "
            "query. OUT.csv is a table of places, OUT.png a picture, OUT.html a page, OUT.pcd or "
            "OUT.ply the cloud of the map, coloured by the length that is needed. Without -o: "
            "MAP's name + _lookalikes.png in the working folder.",
            "xview lookalikes town.xvm -o town_lookalikes.html"};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.addOutput("-o,--out", out_, "the file to write");
  }

  ExitCode run(const Job& job) override {
    const std::string& path = job.operands[0];
    const std::string out =
        !out_.empty() ? out_ : std::filesystem::path(path).stem().string() + "_lookalikes.png";
    const std::string ending = endingOf(out);
    requireOutside("", out, {path});
    requireDrawingPath(out, true);
    const map::SemanticMap map = readWholeMap(path, input_, job);
    Stopwatch watch;
    const SelfSimilarity self_similarity = measureSelfSimilarity(map, job.options, kPlaces);
    job.narrate.stage("lookalikes", watch.lap_ms(),
                      fmt::format("{} places, {} queries", self_similarity.places.size(),
                                  self_similarity.queries.size()));
    if (self_similarity.places.empty())
      throw Error(path, "has no two places that could be compared; map a longer drive");
    if (ending == ".csv")
      writeFile(out, toCsv(self_similarity));
    else if (isCloudPath(out))
      writeColoured(out, map, self_similarity);
    else
      writeDrawing(out, sceneOfLookalikes(map, self_similarity, job), job.narrate);
    printSummary(self_similarity);
    fmt::print("{}\n", out);
    return kDone;
  }

 private:
  InputFlags input_;
  std::string out_;
};

}  // namespace

std::unique_ptr<Command> makeLookalikes() { return std::make_unique<LookalikesCommand>(); }

}  // namespace xview::tools
