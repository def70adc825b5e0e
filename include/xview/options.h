// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/graph/blobs.h"
#include "xview/graph/clean_labels.h"
#include "xview/graph/edges.h"
#include "xview/graph/lift.h"
#include "xview/graph/merge.h"
#include "xview/match/descriptors.h"
#include "xview/match/walks.h"
#include "xview/pose/posterior.h"
#include "xview/pose/refine.h"
#include "xview/search/search.h"
#include "xview/types/option_field.h"
#include "xview/types/semantic_place.h"
#include "xview/types/user_text.h"
#include "xview/verify/sample_consensus.h"
#include "xview/verify/verdict.h"

namespace xview {

struct MapOptions {
  double cloud_voxel_m = 0.25;  ///< the labelled cloud of a map has one point per voxel and class
};

template <class Visitor>
void visit(MapOptions& o, Visitor&& field) {
  field("cloud_voxel_m", o.cloud_voxel_m, Range{0.02, 10},
        "thin the labelled cloud of a map to one point per voxel and class [m]");
}

struct PriorOptions {
  std::string near;  ///< "x,y,radius" of the last query pose in the map [m]; empty = anywhere
  std::string yaw;   ///< "heading,tolerance" of the last query pose in the map [deg]; empty = any
};

template <class Visitor>
void visit(PriorOptions& o, Visitor&& field) {
  field("near", o.near, Syntax{requireCircle},
        "the last pose is within the circle x,y,radius of the map [m]; empty = anywhere");
  field("yaw", o.yaw, Syntax{requireHeading},
        "the last pose looks along heading,tolerance, counter-clockwise from x of the map [deg]; "
        "empty = any");
}

/// How far the odometry of a recording goes wrong between two of its windows.
struct OdometryOptions {
  double drift = 0.03;           ///< error of its position, as a share of the path length
  double drift_deg_per_m = 0.1;  ///< error of its heading
  bool check = true;             ///< hold it against the scans (OdometryCheck)
};

template <class Visitor>
void visit(OdometryOptions& o, Visitor&& field) {
  field("drift", o.drift, Range{0, 1}, "error of the odometry as a share of the path length");
  field("drift_deg_per_m", o.drift_deg_per_m, Range{0, 180}, "error of its heading [deg/m]");
  field("check", o.check,
        "hold the odometry against the scans: queries begin behind a jump, maps refuse one");
}

/// Everything that can be set, one struct per stage. Struct path = YAML key = flag:
/// walks.num_walks, --walks.num_walks 200.
struct Options {
  std::string method = "auto";
  /// Where the blobs and the edges of a place graph come from: points in space, label images, or
  /// (regions) the one from label images and the other by distance in space, as in the paper.
  std::string graph_space = "cloud";
  std::string gravity =
      "auto";         ///< is z up in map and query? See Gravity in xview/types/localization.h
  std::string scale;  ///< "low,high" or "free"; empty = lengths of the query are right
  std::string size = "auto";  ///< what lengths are usual in the place; see semantic_place.h
  int seed = 1;
  int threads = 0;
  PriorOptions prior;
  graph::CleanOptions clean;
  graph::LiftOptions lift;
  graph::BlobOptions blobs;
  graph::MergeOptions merge;
  graph::EdgeOptions edges;
  MapOptions map;
  match::WalkOptions walks;
  match::MatchOptions match;
  verify::ConsensusOptions consensus;
  search::SearchOptions places;
  verify::VerdictOptions verdict;
  pose::PosteriorOptions posterior;
  pose::RefineOptions refine;
  OdometryOptions odometry;
};

template <class Visitor>
void visit(Options& o, Visitor&& field) {
  field("method", o.method, Choices{{"auto", "walks", "search"}},
        "who proposes poses: X-View's walks, the place search, or both");
  field("graph_space", o.graph_space, Choices{{"cloud", "image", "regions"}},
        "blobs and edges from points in space; image: from regions near each other in depth+label "
        "images (the paper's image space); regions: the same blobs, edges in space (the paper's "
        "3-D space)");
  field("gravity", o.gravity, Choices{{"auto", "aligned", "free"}},
        "aligned: z is up in map and query; free: it may not be, what they hold tells, else all "
        "six degrees of freedom are "
        "searched; auto: z is up unless they clearly say otherwise");
  field("scale", o.scale, Syntax{requireScale},
        "lengths of the query may be wrong by one factor: low,high of what they are to be "
        "multiplied with, or free = 0.75,1.34; empty = they are right");
  field(
      "size", o.size, Syntax{requireSize},
      "what lengths are usual: town, room or desk, or the typical spacing of neighbouring objects "
      "[m]; auto follows from the data; a query has the size of the map");
  field("seed", o.seed, Range{0, 2147483647}, "seed of everything random");
  field("threads", o.threads, Range{0, 1024},
        "threads; 0 = all cores. Results do not depend on it");
  field.group("prior", o.prior);
  field.group("clean", o.clean);
  field.group("lift", o.lift);
  field.group("blobs", o.blobs);
  field.group("merge", o.merge);
  field.group("edges", o.edges);
  field.group("map", o.map);
  field.group("walks", o.walks);
  field.group("match", o.match);
  field.group("consensus", o.consensus);
  field.group("places", o.places);
  field.group("verdict", o.verdict);
  field.group("posterior", o.posterior);
  field.group("refine", o.refine);
  field.group("odometry", o.odometry);
}

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
