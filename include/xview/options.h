// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "xview/graph/blobs.h"
#include "xview/graph/clean_labels.h"
#include "xview/graph/edges.h"
#include "xview/graph/image_blobs.h"
#include "xview/graph/lift.h"
#include "xview/graph/merge.h"
#include "xview/graph/plan_view.h"
#include "xview/match/descriptors.h"
#include "xview/match/walks.h"
#include "xview/pose/posterior.h"
#include "xview/pose/refine.h"
#include "xview/search/search.h"
#include "xview/types/option_field.h"
#include "xview/types/prior_text.h"
#include "xview/verify/clique.h"
#include "xview/verify/sample_consensus.h"
#include "xview/verify/verdict.h"

namespace xview {

struct MapOptions {
  double cloud_voxel_m = 0.25;  ///< the labelled cloud of a map has one point per voxel and class
  double keyframe_every_m = 2;  ///< distance between the poses that a map remembers
};

template <class Visitor>
void visit(MapOptions& o, Visitor&& field) {
  field("cloud_voxel_m", o.cloud_voxel_m, Range{0.02, 10},
        "thin the labelled cloud of a map to one point per voxel and class [m]");
  field("keyframe_every_m", o.keyframe_every_m, Range{0, 1e4},
        "distance between the sensor poses that a map remembers [m]");
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

struct SequenceOptions {
  int windows = 12;      ///< windows that are remembered
  int places = 40;       ///< places that are followed through them
  double reach_m = 1.5;  ///< a place may move so far from one window to the next
  double drift = 0.03;   ///< and by this share of the way between them
};

template <class Visitor>
void visit(SequenceOptions& o, Visitor&& field) {
  field("windows", o.windows, Range{1, 10000}, "windows that are remembered");
  field("places", o.places, Range{2, 100000}, "places that are followed through them");
  field("reach_m", o.reach_m, Range{0, 100},
        "a place may move so far from one window to the next [m]");
  field("drift", o.drift, Range{0, 1}, "and by this share of the way between them");
}

struct TrackOptions {
  double min_radius_m = 3;       ///< a query is expected at least so far around
  double min_yaw_deg = 6;        ///< and turned by at least so much
  double drift = 0.03;           ///< error of the odometry, as share of the way
  double drift_deg_per_m = 0.1;  ///< and of its heading
  double max_radius_m = 20;      ///< expected farther around means not expected anywhere
};

template <class Visitor>
void visit(TrackOptions& o, Visitor&& field) {
  field("min_radius_m", o.min_radius_m, Range{0.1, 1000},
        "smallest radius in which the next window is searched [m]");
  field("min_yaw_deg", o.min_yaw_deg, Range{0.1, 180},
        "smallest turn to either side that is searched [deg]");
  field("drift", o.drift, Range{0, 1}, "error of the odometry as share of the way");
  field("drift_deg_per_m", o.drift_deg_per_m, Range{0, 180}, "error of its heading [deg/m]");
  field("max_radius_m", o.max_radius_m, Range{0.1, 1e5},
        "beyond this radius the whole map is searched again [m]");
}

/// Everything that can be set, one struct per stage. Struct path = YAML key = flag:
/// walks.num_walks, --walks.num_walks 200.
struct Options {
  std::string method = "auto";
  std::string graph_space = "cloud";  ///< image: blobs and edges of the place graph are found in
                                      ///< the images, as in the paper
  std::string gravity = "auto";       ///< is z up in map and query? See xview/types/gravity.h
  std::string scale;  ///< "low,high" or "free"; empty = lengths of the query are right
  int seed = 1;
  int threads = 0;
  PriorOptions prior;
  CleanOptions clean;
  LiftOptions lift;
  BlobOptions blobs;
  ImageBlobOptions image_blobs;
  MergeOptions merge;
  EdgeOptions edges;
  PlanOptions plan;
  MapOptions map;
  match::WalkOptions walks;
  match::MatchOptions match;
  verify::ConsistencyOptions consistency;
  verify::ConsensusOptions consensus;
  search::SearchOptions places;
  verify::VerdictOptions verdict;
  PosteriorOptions posterior;
  RefineOptions refine;
  SequenceOptions sequence;
  TrackOptions track;
};

template <class Visitor>
void visit(Options& o, Visitor&& field) {
  field("method", o.method, Choices{{"auto", "walks", "search"}},
        "who proposes poses: X-View's walks, the place search, or both");
  field("graph_space", o.graph_space, Choices{{"cloud", "image"}},
        "blobs and edges from points in space, or from regions near each other in depth+label "
        "images (the paper's image space)");
  field("gravity", o.gravity, Choices{{"auto", "aligned", "free"}},
        "aligned: z is up in map and query; free: it may not be, what they hold tells, else all "
        "six degrees of freedom are "
        "searched; auto: z is up unless they clearly say otherwise");
  field("scale", o.scale, Syntax{requireScale},
        "lengths of the query may be wrong by one factor: low,high of what they are to be "
        "multiplied with, or free = 0.75,1.34; empty = they are right");
  field("seed", o.seed, Range{0, 2147483647}, "seed of everything random");
  field("threads", o.threads, Range{0, 1024},
        "threads; 0 = all cores. Results do not depend on it");
  field.group("prior", o.prior);
  field.group("clean", o.clean);
  field.group("lift", o.lift);
  field.group("blobs", o.blobs);
  field.group("image_blobs", o.image_blobs);
  field.group("merge", o.merge);
  field.group("edges", o.edges);
  field.group("plan", o.plan);
  field.group("map", o.map);
  field.group("walks", o.walks);
  field.group("match", o.match);
  field.group("consistency", o.consistency);
  field.group("consensus", o.consensus);
  field.group("places", o.places);
  field.group("verdict", o.verdict);
  field.group("posterior", o.posterior);
  field.group("refine", o.refine);
  field.group("sequence", o.sequence);
  field.group("track", o.track);
}

}  // namespace xview
