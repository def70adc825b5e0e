// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "xview/base/bev_grid.h"
#include "xview/base/graph.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/base/localization.h"

namespace xview {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A place of the map frame that something was said about, e.g. a piece of a query that speaks for
/// or against its pose.
struct SceneMark {
  std::string group;  ///< marks of one group share a switch and a line of the legend
  Color color{0, 0, 0};
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< [m]
  std::string note;                              ///< what is told when it is picked
  bool is_listed = true;  ///< beside a picture of the page; the same of all of a group
};

/// A query in a picture, at its estimated pose. What is null or empty is not drawn.
struct SceneQuery {
  std::string name;
  Status status = Status::accepted;  ///< chooses the colour of its way and its arrow
  std::string reason;
  std::string chance_wrong;  ///< how likely the answer is wrong, in words
  double sigma_m = std::numeric_limits<double>::quiet_NaN();  ///< of its position, 3-D [m]
  double error_m = std::numeric_limits<double>::quiet_NaN();  ///< against the truth, if known
  double error_deg = std::numeric_limits<double>::quiet_NaN();
  double total_ms = std::numeric_limits<double>::quiet_NaN();
  bool out_of_map = false;               ///< there is no right place for it
  bool has_pose = true;                  ///< false: it is only listed
  const SemanticGraph* graph = nullptr;  ///< in the query's odometry frame
  const LabelledCloud* cloud = nullptr;  ///< in the query's odometry frame
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Isometry3d>
      poses;  ///< T_odom_sensor of its frames; the last one is the answer
  std::vector<Eigen::Isometry3d> true_poses;           ///< T_map_sensor of its frames, if known
  Eigen::Vector3d forward = Eigen::Vector3d::UnitZ();  ///< where the sensor looks, in its frame: z
                                                       ///< for cameras, x for LiDAR
  std::vector<Correspondence> putative, kept;          ///< into `graph` and the map graph
  std::vector<Eigen::Isometry3d> hypotheses;           ///< T_map_sensor, best first
  std::vector<SceneMark> marks;
};

/// A line through the map frame: a trajectory, an error.
struct SceneLine {
  std::string name;
  Color color{0, 0, 0};
  std::vector<Eigen::Vector3d> points;
};

/// What is along the x axis of a chart: a share from 0 to 1; a length [m], in decades; or a
/// confidence, evenly in its log odds.
enum class ChartAxis { share, length, odds };

/// Shares over one quantity. Over a confidence they are dots, one a curve, beside what was claimed.
struct SceneChart {
  std::string title, x_name, y_name;
  ChartAxis axis = ChartAxis::share;
  std::vector<std::pair<std::string, std::vector<Eigen::Vector2d>>> curves;  ///< y in [0, 1]
};

/// What a picture shows. Large parts are borrowed; null or empty parts are not drawn. Everything is
/// in the map frame but the queries.
struct Scene {
  std::string title;                                       ///< the outcome in one line
  std::string caption;                                     ///< a second line: of what, or why
  std::string made_by;                                     ///< version and command
  std::vector<std::pair<std::string, std::string>> facts;  ///< headline numbers: name, value
  const LabelSet* labels = nullptr;
  const SemanticGraph* map_graph = nullptr;
  const LabelledCloud* map_cloud = nullptr;
  const BevGrid* map_bev = nullptr;          ///< drawn where there is no cloud
  std::vector<Eigen::Isometry3d> map_poses;  ///< T_map_sensor of the key frames
  std::vector<SceneQuery> queries;
  std::vector<SceneLine> lines;
  std::vector<SceneMark> marks;
  std::vector<SceneChart> charts;
};

/// Colour of a status: green, amber, red.
Color statusColor(Status status);

/// Ids of the classes that are in the scene, ascending, without ignored ones.
std::vector<std::uint32_t> classesIn(const Scene& scene);

enum class PictureFormat { png, svg };

/// A picture from above as the bytes of a file: the map in quiet colours by kind of class, its key
/// frames, the cloud of each query at its estimated pose with an arrow where it looks, the kept
/// correspondences, the true pose if known; grid with coordinates, scale bar and legend. Needs no
/// display. A query that is small in its map gets a panel of its own.
std::string drawTopDown(const Scene& scene, PictureFormat format = PictureFormat::png);

/// A page to turn, shift and zoom: layers and classes with switches, search, the queries with their
/// reasons, charts. It holds everything it needs: opens from file:// without a network. Clouds of
/// more than `most_points` are thinned, and the page says so.
std::string htmlPage(const Scene& scene, std::size_t most_points = 1000000);

/// A chart as the text of an SVG file, which can be read on white and on black.
std::string chartSvg(const SceneChart& chart);

/// Everything as one cloud: points of the map with their classes; points, ways and arrows of
/// queries, and correspondences as dotted lines, as classes of their own, which are added to
/// `labels`.
LabelledCloud sceneCloud(const Scene& scene, LabelSet& labels);

enum class MeshFormat { vtk, ply };

/// Everything as one coloured mesh, the text of a legacy VTK file (`pcl_viewer cloud.pcd mesh.vtk`)
/// or of a PLY (MeshLab, CloudCompare), in millimetres' precision: graphs as octahedra and tubes,
/// ways, arrows and correspondences as tubes, clouds as vertices without faces.
std::string sceneMesh(const Scene& scene, MeshFormat format);

/// A text as SVG and other XML hold it, between tags or in quotes.
std::string xmlText(const std::string& text);

}  // namespace xview
