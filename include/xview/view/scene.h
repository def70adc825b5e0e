// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/correspondence.h"
#include "xview/types/graph.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/localization.h"
#include "xview/types/plan_view.h"
#include "xview/view/color_mesh.h"

namespace xview {

/// A query in a picture, at its estimated pose. What is null or empty is not drawn.
struct SceneQuery {
  std::string name;
  Status status = Status::accepted;      ///< chooses the colour of its frame
  const SemanticGraph* graph = nullptr;  ///< in the query's odometry frame
  const LabelledCloud* cloud = nullptr;  ///< in the query's odometry frame
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Isometry3d>
      poses;  ///< T_odom_sensor of its frames; the last one is the answer
  std::vector<Eigen::Isometry3d> true_poses;           ///< T_map_sensor of its frames, if known
  Eigen::Vector3d forward = Eigen::Vector3d::UnitZ();  ///< where the sensor looks, in its frame: z
                                                       ///< for cameras, x for LiDAR
  std::vector<Correspondence> putative, kept;          ///< into `graph` and the map graph
};

/// A line through the map frame: a trajectory, an error.
struct SceneLine {
  std::string name;
  Color color{0, 0, 0};
  std::vector<Eigen::Vector3d> points;
};

/// What a picture shows. Large parts are borrowed; null or empty parts are not drawn. Everything is
/// in the map frame but the queries.
struct Scene {
  std::string title;  ///< one line, e.g. the verdict
  const LabelSet* labels = nullptr;
  const SemanticGraph* map_graph = nullptr;
  const LabelledCloud* map_cloud = nullptr;
  const PlanView* map_plan = nullptr;        ///< drawn where there is no cloud
  std::vector<Eigen::Isometry3d> map_poses;  ///< T_map_sensor of the key frames
  std::vector<SceneQuery> queries;
  std::vector<SceneLine> lines;
};

/// Colour of a status: green, amber, red.
Color statusColor(Status status);

/// Ids of the classes that are in the scene, ascending, without ignored ones.
std::vector<std::uint32_t> classesIn(const Scene& scene);

/// A picture from above as the bytes of a PNG: the map by class, its key frames, each query at its
/// estimated pose with its matches and view directions, the true pose if known, scale bar and
/// legend. Needs no display. A query that is small in its map gets a panel of its own.
std::vector<std::uint8_t> drawTopDown(const Scene& scene);

struct HtmlViewOptions {
  std::size_t most_points = 1000000;  ///< of each cloud, evenly thinned; each costs 20 bytes
  std::string below;  ///< HTML that stands below the view, e.g. a report; leaves it less room
};

/// A page with a 3-D view to turn, shift and zoom, and a switch per layer; lines of one name are
/// one layer. It holds everything it needs: opens from file:// without a network.
std::string htmlView(const Scene& scene, const HtmlViewOptions& options = {});

}  // namespace xview
