// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <utility>
#include <vector>

#include "xview/view/scene.h"

namespace xview {

// What all drawings share: which edges and pieces of a trajectory they show, and in which colours.

/// The edges that a picture shows: all of them, or, of a graph with more than six edges per vertex,
/// those that are among the three shortest of one of their ends. Edges of vertices that are not
/// finite are left out.
std::vector<std::pair<std::uint32_t, std::uint32_t>> readableEdges(const SemanticGraph& graph);

/// Positions of successive poses, cut where a step is more than 20 m and five times the usual one:
/// from one recording to the next.
std::vector<std::vector<Eigen::Vector3d>> trajectoryPieces(
    const std::vector<Eigen::Isometry3d>& poses);

/// A color mixed with white; 0 leaves it, 1 is white.
Color paler(const Color& color, double share);

/// Channels of a plan view that are drawn, the lowest first. Borders and obstacles repeat what is
/// drawn already.
std::vector<Channel> drawnChannels();
Color channelColor(Channel channel);

constexpr Color kKeyframeColor{70, 90, 140};
constexpr Color kQueryEdgeColor{90, 130, 200};
constexpr Color kKeptColor{20, 160, 60};
constexpr Color kPutativeColor{230, 180, 180};
constexpr Color kTruthColor{20, 20, 20};

/// The page around the data: everything before the JSON text of the scene, and everything behind
/// it.
extern const char* const kHtmlPageBegin;
extern const char* const kHtmlPageEnd;

}  // namespace xview
