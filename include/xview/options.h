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
#include "xview/match/object_places.h"
#include "xview/match/plan_places.h"
#include "xview/match/walks.h"
#include "xview/pose/posterior.h"
#include "xview/pose/refine.h"
#include "xview/types/option_field.h"
#include "xview/verify/clique.h"
#include "xview/verify/sample_consensus.h"
#include "xview/verify/object_verdict.h"
#include "xview/verify/verdict.h"

namespace xview {

struct MapOptions {
  double cloud_voxel_m = 0.25;   ///< the labelled cloud of a map has one point per voxel and class
  double keyframe_every_m = 2;   ///< distance between the poses that a map remembers
};

template <class Visitor>
void visit(MapOptions& o, Visitor&& field) {
  field("cloud_voxel_m", o.cloud_voxel_m, Range{0.02, 10}, "thin the labelled cloud of a map to one point per voxel and class [m]");
  field("keyframe_every_m", o.keyframe_every_m, Range{0, 1e4}, "distance between the sensor poses that a map remembers [m]");
}

struct PriorOptions {
  std::string near;  ///< "x,y,radius" of the last query pose in the map [m]; empty = anywhere
  std::string yaw;   ///< "heading,tolerance" of the last query pose in the map [deg]; empty = any
};

template <class Visitor>
void visit(PriorOptions& o, Visitor&& field) {
  field("near", o.near, "the last pose is within the circle x,y,radius of the map [m]; empty = anywhere");
  field("yaw", o.yaw, "the last pose looks along heading,tolerance, counter-clockwise from x of the map [deg]; empty = any");
}

/// Everything that can be set, one struct per stage. Struct path = YAML key = flag: walks.num_walks, --walks.num_walks 200.
struct Options {
  std::string method = "auto";
  std::string graph_space = "cloud";  ///< image: blobs and edges of the place graph are found in the images, as in the paper
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
  WalkOptions walks;
  MatchOptions match;
  ConsistencyOptions consistency;
  ConsensusOptions consensus;
  PlaceOptions places;
  ObjectPlaceOptions objects;
  VerdictOptions verdict;
  ObjectVerdictOptions object_verdict;
  PosteriorOptions posterior;
  RefineOptions refine;
};

template <class Visitor>
void visit(Options& o, Visitor&& field) {
  field("method", o.method, Choices{{"auto", "walks", "search"}},
        "who proposes poses: X-View's walks, the place search, or both");
  field("graph_space", o.graph_space, Choices{{"cloud", "image"}},
        "blobs and edges from points in space, or from regions near each other in depth+label images (the paper's image space)");
  field("seed", o.seed, Range{0, 2147483647}, "seed of everything random");
  field("threads", o.threads, Range{0, 1024}, "threads; 0 = all cores. Results do not depend on it");
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
  field.group("objects", o.objects);
  field.group("verdict", o.verdict);
  field.group("object_verdict", o.object_verdict);
  field.group("posterior", o.posterior);
  field.group("refine", o.refine);
}

}  // namespace xview
