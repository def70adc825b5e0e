// SPDX-License-Identifier: BSD-3-Clause
#include "search/likelihoods.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>

#include "xview/base/error.h"

namespace xview::search {

/// Contents of config/likelihoods.txt, _rooms.txt and _shapes.txt, compiled in.
extern const char* const kDefaultLikelihoods;
extern const char* const kLikelihoodsOfRooms;
extern const char* const kLikelihoodsOfShapes;

namespace {

constexpr float kLowestRatio = -2.5f;
constexpr double kFewestCounts = 20;  ///< fewer samples at true poses say nothing about a channel
constexpr double kPriorCounts = 10;   ///< weight of "a true pose looks like a wrong one"
/// Share of wrong poses off the path of the map, where distances are those of any map. Along a
/// straight road all wrong poses on the path find its border where it is.
constexpr double kOffPath = 0.05;
constexpr std::array<const char*, kViewpoints> kViewpointNames = {"ground", "air", "ground_in_air"};

using Distribution = std::array<double, kDistanceBins>;

double sum(const Distribution& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0.0);
}

Distribution smoothed(const Distribution& counts, const Distribution& prior, double weight) {
  Distribution p{};
  const double total = sum(counts) + weight;
  for (int b = 0; b < kDistanceBins; ++b) p[b] = (counts[b] + weight * prior[b]) / total;
  return p;
}

Distribution uniform() {
  Distribution p{};
  p.fill(1.0 / kDistanceBins);
  return p;
}

/// False of files that were learned without such recordings.
bool tellsAnything(const LikelihoodTable& table, Viewpoint viewpoint) {
  const auto& channels = table.counts[static_cast<std::size_t>(viewpoint)];
  return std::any_of(channels.begin(), channels.end(),
                     [](const DistanceCounts& counts) { return sum(counts.at_true) > 0; });
}

/// False if the line is not what it should be.
bool parseLine(const std::string& line, LikelihoodTable& table) {
  std::istringstream words(line);
  std::string viewpoint, channel, hypothesis, more;
  words >> viewpoint >> channel >> hypothesis;
  Distribution counts{};
  for (double& n : counts) words >> n;
  const bool counted =
      words && std::all_of(counts.begin(), counts.end(), [](double n) { return n >= 0; });
  if (!counted || words >> more || (hypothesis != "true" && hypothesis != "wrong")) return false;
  const auto v = std::find(kViewpointNames.begin(), kViewpointNames.end(), viewpoint) -
                 kViewpointNames.begin();
  std::size_t c = 0;
  while (c < kBevChannels && channel != toString(static_cast<BevChannel>(c))) ++c;
  if (v == kViewpointNames.end() - kViewpointNames.begin() || c == kBevChannels) return false;
  DistanceCounts& entry = table.counts[v][c];
  (hypothesis == "true" ? entry.at_true : entry.at_wrong) = counts;
  return true;
}

}  // namespace

void LikelihoodTable::add(const LikelihoodTable& other) {
  for (std::size_t v = 0; v < counts.size(); ++v) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      for (int b = 0; b < kDistanceBins; ++b) {
        counts[v][c].at_true[b] += other.counts[v][c].at_true[b];
        counts[v][c].at_wrong[b] += other.counts[v][c].at_wrong[b];
      }
    }
  }
}

LogRatios logRatios(const LikelihoodTable& table, Viewpoint viewpoint, const MapNull* map_null,
                    double mix) {
  if (!tellsAnything(table, viewpoint)) viewpoint = Viewpoint::ground;
  LogRatios ratios;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const DistanceCounts& counts = table.at(viewpoint, static_cast<BevChannel>(c));
    if (sum(counts.at_true) < kFewestCounts) continue;
    const Distribution wrong = smoothed(counts.at_wrong, uniform(), kDistanceBins * 0.5);
    const Distribution right = smoothed(counts.at_true, wrong, kPriorCounts);
    const bool use_map = map_null && mix > 0 && sum((*map_null)[c]) >= 50;
    Distribution local = wrong;
    if (use_map) {
      const Distribution on_path = smoothed((*map_null)[c], uniform(), 2.0);
      for (int b = 0; b < kDistanceBins; ++b)
        local[b] = kOffPath * wrong[b] + (1 - kOffPath) * on_path[b];
    }
    for (int b = 0; b < kDistanceBins; ++b) {
      const double learned = std::log(right[b] / wrong[b]), here = std::log(right[b] / local[b]);
      const double blend = use_map ? mix * here + (1 - mix) * learned : learned;
      ratios.value[c][b] = std::max(kLowestRatio, static_cast<float>(blend));
      ratios.expected[c] += static_cast<float>(right[b]) * ratios.value[c][b];
    }
  }
  return ratios;
}

const LikelihoodTable& defaultLikelihoods() {
  static const LikelihoodTable table =
      parseLikelihoods(kDefaultLikelihoods, "built-in likelihoods");
  return table;
}

std::string toText(const LikelihoodTable& table) {
  std::ostringstream out;
  out << "# view-point channel hypothesis, counts of the nearest map sample within";
  for (const float limit : kBinLimits_m) out << ' ' << limit;
  out << " m and beyond\n";
  for (std::size_t v = 0; v < table.counts.size(); ++v) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      for (const bool at_true : {true, false}) {
        const DistanceCounts& counts = table.counts[v][c];
        out << kViewpointNames[v] << ' ' << toString(static_cast<BevChannel>(c))
            << (at_true ? " true" : " wrong");
        for (const double n : at_true ? counts.at_true : counts.at_wrong)
          out << ' ' << std::llround(n);
        out << '\n';
      }
    }
  }
  return out.str();
}

LikelihoodTable parseLikelihoods(const std::string& text, const std::string& path) {
  LikelihoodTable table;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    if (!parseLine(line, table)) {
      throw Error(path + ":" + std::to_string(number),
                  "expected 'ground|air|ground_in_air CHANNEL true|wrong' and " +
                      std::to_string(kDistanceBins) + " counts, found '" + line + "'");
    }
  }
  return table;
}

LikelihoodTable readLikelihoods(const std::string& path) {
  if (path == kRooms) return parseLikelihoods(kLikelihoodsOfRooms, "built-in likelihoods");
  if (path == kShapes) return parseLikelihoods(kLikelihoodsOfShapes, "built-in likelihoods");
  if (path == kShapesInLabels) {
    constexpr auto ground = static_cast<std::size_t>(Viewpoint::ground);
    LikelihoodTable table = readLikelihoods(kShapes);
    table.counts[ground] = defaultLikelihoods().counts[ground];
    return table;
  }
  const std::ifstream file(path);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  if (!file || !text) throw Error(path, "cannot be read; expected the likelihoods of xview learn");
  const LikelihoodTable table = parseLikelihoods(text.str(), path);
  for (const auto& viewpoint : table.counts) {
    for (const DistanceCounts& channel : viewpoint) {
      if (sum(channel.at_true) > 0 && sum(channel.at_wrong) > 0) return table;
    }
  }
  throw Error(path, "expected the likelihoods of xview learn, found no counts");
}

}  // namespace xview::search
