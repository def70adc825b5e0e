// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/base/semantic_place.h"

namespace xview {

struct CleanOptions {
  bool enabled = true;
  /// Half size of the element that may also take pixels of other classes (paper: 4 px), in images
  /// 1280 pixels wide as in the paper; scaled with the width.
  int boundary_px = 0;
};

struct LiftOptions {
  double min_range_m = 0.3;
  double max_range_m = 50;  ///< of cameras near the ground; from the air and of LiDAR it is more
};

struct BlobOptions {
  double tolerance_m = 0.5;  ///< two points of a class nearer than this are in one blob
  int min_points = 20;       ///< smaller blobs are dropped
  double voxel_m = 0.1;      ///< thin a frame to one point per voxel and class first; 0 = off
  double max_surface_m =
      20;  ///< surfaces that spread further are cut into squares; 0 = off (paper)
  /// Regions of label images of a smaller share of the image are leaves and specks, whose median
  /// depth says little (the paper's scripts: 0.002).
  double min_share = 0.001;
  std::string instances = "all";  ///< classes whose instances part a region of a label image
};

struct MergeOptions {
  std::string mode = "running_mean";
  /// Merge distance of mode first_observation (paper: 10 m SYNTHIA, 15 m others).
  double first_observation_m = 10;
  double object_m = 2;          ///< merge distance of objects in mode running_mean
  double surface_m = 3;         ///< spacing of surface vertices in mode running_mean
  int min_surface_points = 10;  ///< a cell of a surface with fewer, over all frames, is no vertex
};

struct EdgeOptions {
  double radius_m = 15;  ///< vertices nearer than this are neighbours
};
namespace match {

struct WalkOptions {
  int num_walks = 0;              ///< n (paper: 200); 0 = all of them, by their probability
  int walk_length = 4;            ///< m, vertices per walk including the first (paper: 3 to 5)
  int nearest = 8;                ///< neighbours that a walk may go on to; 0 = all (paper)
  bool immediate_return = false;  ///< may a walk step back to where it just came from (paper: no)
};

struct MatchOptions {
  int candidates = 15;     ///< k best map vertices per query vertex
  bool rare_words = true;  ///< weight words by their rarity in the map (inverse document frequency)
};
}  // namespace match

namespace match {

struct ConsensusOptions {
  double inlier_m = 3;  ///< a correspondence fits a pose if it ends this near
  int iterations = 10000;
  int min_inliers = 4;  ///< fewer than this is no pose
};
}  // namespace match

namespace search {

struct SearchOptions {
  int hypotheses = 5;       ///< distinct places that are reported
  std::string likelihoods;  ///< file of xview learn; empty = what the program comes with
  double cell_m = 2;        ///< of the exhaustive search over BEV grids, taken as the nearest
                            ///< power of two of bev.cell_m; twice that at first in
                            ///< large maps. Larger is faster and less sure
  double detection = 0.62;  ///< bare graphs: chance that a query finds an object again
  double sigma_m = 0.9;     ///< bare graphs: of an object's position, map and query together
};
}  // namespace search

namespace verdict {

struct VerdictOptions {
  /// An answer is accepted if this share of answers that are at least as sure is right.
  double min_confidence = 0.99;
  double min_known_share = 0.15;  ///< share of the query that must lie where the map was seen
  std::string model;  ///< file of xview learn --verdict; empty = what the program comes with
};
}  // namespace verdict

namespace pose {

struct PosteriorOptions {
  bool enabled = true;
  std::string solver = "trust_region";
  std::string gravity = "auto";
  double odometry_sigma_m = 0.05;
  double odometry_sigma_rad = 0.002;

  /// What a caller may know better than this, but a user need not.
  struct Model {
    double vertex_sigma_m = 0.1;      ///< of an observed vertex, beside what its graph says
    double match_sigma_m = 0.3;       ///< of a vertex to its partner, beside the error of the map
    double gravity_sigma_rad = 0.01;  ///< of the known up
    /// Of trust_region: matches further apart than this many standard deviations count less
    /// (Cauchy); 0 = quadratic.
    double robust_scale = 2;
    /// Longer windows are thinned to about this number of poses, which odometry then interpolates.
    int max_poses = 60;
  } model;
};

struct RefineOptions {
  bool enabled = true;
  double cell_m = 0.8;
  double reach_m = 40;
  double max_sigma_m = 0.5;
  double tilt_sigma_deg = 0.5;
  double max_shift_m = 2.5;

  /// What points seen once ask for; averaged ones ask for something else.
  struct Model {
    int max_points = 3000;      ///< of the query
    double first_gate_m = 2.0;  ///< a point may be this far from its distribution at first
    double last_gate_m = 0.8;   ///< and at the end
    double roughness_m = 0.05;  ///< standard deviation added to every distribution
    double drift_share = 0.03;  ///< error of the odometry per path length where a window drifts
    double start_reach_m = 1;   ///< multi-start: distance to both sides along the direction of
                                ///< least information [m]; 0 = from the given pose only
  } model;
};

}  // namespace pose

struct MapOptions {
  double cloud_voxel_m = 0.25;  ///< the labelled cloud of a map has one point per voxel and class
};

struct PriorOptions {
  std::string near;  ///< "x,y,radius" of the last query pose in the map [m]; empty = anywhere
  std::string yaw;   ///< "heading,tolerance" of the last query pose in the map [deg]; empty = any
};

/// How far the odometry of a recording goes wrong between two of its windows.
struct OdometryOptions {
  double drift = 0.03;           ///< error of its position, as a share of the path length
  double drift_deg_per_m = 0.1;  ///< error of its heading
  bool check = true;             ///< hold it against the scans (OdometryCheck)
};

/// Everything that can be set, one struct per stage. Struct path = YAML key = flag:
/// walks.num_walks, --walks.num_walks 200.
struct Options {
  std::string method = "auto";
  /// Where the blobs and the edges of a place graph come from: points in space, label images, or
  /// (regions) the one from label images and the other by distance in space, as in the paper.
  std::string graph_space = "cloud";
  std::string gravity =
      "auto";         ///< is z up in map and query? See Gravity in xview/base/localization.h
  std::string scale;  ///< "low,high" or "free"; empty = lengths of the query are right
  std::string size = "auto";  ///< what lengths are usual in the place; see semantic_place.h
  int seed = 1;
  int threads = 0;
  PriorOptions prior;
  CleanOptions clean;
  LiftOptions lift;
  BlobOptions blobs;
  MergeOptions merge;
  EdgeOptions edges;
  MapOptions map;
  match::WalkOptions walks;
  match::MatchOptions match;
  match::ConsensusOptions consensus;
  search::SearchOptions places;
  verdict::VerdictOptions verdict;
  pose::PosteriorOptions posterior;
  pose::RefineOptions refine;
  OdometryOptions odometry;
};

/// One option as the command line and --print-config see it.
struct OptionEntry {
  std::string key;       ///< "walks.num_walks"
  std::string value;     ///< current value as text
  std::string fallback;  ///< default as text
  std::string help;      ///< meaning, unit and range
};

std::vector<OptionEntry> listOptions(const Options& options);

/// Sets one option from text. Throws UsageError: unknown key (names the nearest known one), not a
/// number, out of range
/// ("walks.walk_length = 0, must be in [2, 8]"), not among the choices.
void setOption(Options& options, const std::string& key, const std::string& value);

/// Throws UsageError as setOption does if a value could not have been set so.
void requireValid(const Options& options);

/// Applies a YAML file (nested maps; only what differs from the defaults), or the one of this name
/// that comes with the program ("paper/synthia"). Throws Error with path:line for anything unknown
/// or wrong.
void applyOptionsFile(Options& options, const std::string& path);

/// All options as YAML that applyOptionsFile reads back to the same values; defaults carry the
/// comment "# default".
std::string toYaml(const Options& options);

/// The options for a place of this scale, in its own metres: lengths that nobody set are the
/// canonical ones times the scale.
Options atSize(Options options, double size);

/// The same options for a place that was brought to canonical scale: lengths that nobody set stay,
/// lengths that somebody set in metres of the place are divided by its scale.
Options inCanonicalLengths(Options options, double size);

}  // namespace xview
