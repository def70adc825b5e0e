// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "view/scene.h"

namespace xview {

// What all drawings share: which edges and pieces of a trajectory they show, and in which colours.

/// The edges that a picture shows: all of them, or, of a graph with more than six edges per vertex,
/// those that are among the three shortest of one of their ends. Edges of vertices that are not
/// finite are left out.
struct ReadableEdges {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> shown;
  std::size_t all = 0;
};
ReadableEdges readableEdges(SemanticGraph graph);

/// Of the sign of a vertex, from the typical length of the edges: 0.15 to 3 m.
double typicalVertexRadius(const SemanticGraph& graph);

/// Positions of successive poses, cut where a step is more than 20 m and five times the usual one:
/// from one recording to the next.
std::vector<std::vector<Eigen::Vector3d>> trajectoryPieces(
    const std::vector<Eigen::Isometry3d>& poses);

/// T_map_sensor of the frames of a query.
std::vector<Eigen::Isometry3d> posesInMap(const SceneQuery& query);

/// The colour of a class in a map that is to recede behind what lies on it: one quiet colour per
/// kind; what is of no known kind keeps a paler form of its own.
Color quietColor(const LabelSet& labels, std::uint32_t id);

/// A picture from above leaves the ceiling out, under which a room would disappear.
bool isCeiling(const LabelSet& labels, std::uint32_t id);

struct DrawnBevChannel {
  BevChannel channel;
  std::string name;  ///< "wall foot"
  Color color;
};
/// What a BEV grid holds that is drawn, the lowest first. Borders and obstacles repeat what is
/// drawn already.
std::vector<DrawnBevChannel> drawnBevChannels(const BevGrid& bev);

/// The two ends of a correspondence in the map frame.
struct MatchEnds {
  Eigen::Vector3d query, map;
};
/// Those that are in range and finite.
std::vector<MatchEnds> endsOf(const std::vector<Correspondence>& matches, const SceneQuery& query,
                              const SemanticGraph& map);

/// The pairs of `putative` that are not in `kept`.
std::vector<Correspondence> onlyPutative(const std::vector<Correspondence>& putative,
                                         const std::vector<Correspondence>& kept);

/// That of the scene, or an empty one.
const LabelSet& labelsOf(const Scene& scene);

/// Several queries with points have a number and a colour each in a picture; of many the colours
/// come again, and of one or more than kMostNumbered all are blue and without a number.
constexpr std::size_t kMostNumbered = 40;
bool areNumbered(const std::vector<SceneQuery>& queries);
Color queryColor(const std::vector<SceneQuery>& queries, std::size_t i);

/// The files of the page, which are part of the program: "page", "style" and "script" are those in
/// page/, "libraries" three.js with its camera controls and its lines.
std::map<std::string, std::string> pageParts();

constexpr Color kKeyframeColor{96, 104, 122};
constexpr Color kQueryColor{30, 96, 214};
constexpr Color kKeptColor{20, 160, 60};
constexpr Color kPutativeColor{214, 150, 150};
constexpr Color kTruthColor{20, 20, 20};

}  // namespace xview
