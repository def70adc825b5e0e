// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "panel.h"
#include "xview/view/scene.h"

namespace xview {

// Layers of a picture from above, in the order in which they are drawn. `unit_px` is the size of
// small things: 1 in a picture 1200 pixels high.

void drawGrid(Panel& panel, double unit_px);
void drawPlan(Panel& panel, const PlanView& plan);
/// The highest point of a place is seen. `fade` mixes white into the colours, more into the ground.
void drawCloud(Panel& panel, const LabelledCloud& cloud, const LabelSet& labels,
               const Eigen::Isometry3d& T_map_cloud, double fade);
void drawMapGraph(Panel& panel, const SemanticGraph& graph, const LabelSet& labels, double unit_px);
void drawKeyframes(Panel& panel, const std::vector<Eigen::Isometry3d>& poses, double unit_px);
void drawPutative(Panel& panel, const SceneQuery& query, const SemanticGraph& map);
void drawKept(Panel& panel, const SceneQuery& query, const SemanticGraph& map, double unit_px);
void drawQueryGraph(Panel& panel, const SceneQuery& query, const LabelSet& labels, double unit_px);
void drawQueryPoses(Panel& panel, const SceneQuery& query, double unit_px);
void drawScaleBar(Panel& panel, double unit_px);

/// Channels that are drawn where there is no cloud, the lowest first.
std::vector<Channel> drawnChannels();

/// Colour of a channel of the plan view.
Color channelColor(Channel channel);

constexpr Color kKeyframeColor{70, 90, 140};
constexpr Color kKeptColor{20, 160, 60};
constexpr Color kPutativeColor{230, 180, 180};
constexpr Color kTruthColor{20, 20, 20};

}  // namespace xview
