// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/option_field.h"
#include "base/user_text.h"
#include "xview/options.h"

namespace xview {

// Each option once: its key, its range or syntax, and what --print-config and the manual say of it.

template <class Visitor>
void visit(CleanOptions& o, Visitor&& field) {
  field("enabled", o.enabled, "smooth label images before they are lifted");
  field("boundary_px", o.boundary_px, Range{0, 200},
        "close classes over their neighbours, too, by this much in images 1280 px wide; 0 = keep "
        "boundaries [px]");
}

template <class Visitor>
void visit(LiftOptions& o, Visitor&& field) {
  field("min_range_m", o.min_range_m, Range{0, 1e4}, "drop measurements nearer than this [m]");
  field("max_range_m", o.max_range_m, Range{0.1, 1e4},
        "drop measurements further than this; LiDAR reaches 1.2 times as far, cameras in the air "
        "2.4 times [m]");
}

template <class Visitor>
void visit(BlobOptions& o, Visitor&& field) {
  field("tolerance_m", o.tolerance_m, Range{0.01, 100},
        "points of one class nearer than this are one blob [m]");
  field("min_points", o.min_points, Range{1, 1e9}, "drop blobs with fewer points");
  field("voxel_m", o.voxel_m, Range{0, 10},
        "thin points to one per voxel and class before clustering; 0 = off [m]");
  field("max_surface_m", o.max_surface_m, Range{0, 1e6},
        "cut blobs of surface classes that spread further into squares of this side; 0 = off [m]");
  field("min_share", o.min_share, Range{0, 1},
        "drop regions of label images of a smaller share of the image");
  field("instances", o.instances, Choices{{"all", "dynamic", "none"}},
        "classes whose instances part a region of a label image");
}

template <class Visitor>
void visit(MergeOptions& o, Visitor&& field) {
  field(
      "mode", o.mode, Choices{{"running_mean", "first_observation"}},
      "running_mean: objects at their mean, surfaces sampled; first_observation: as in the paper");
  field("first_observation_m", o.first_observation_m, Range{0.01, 1e4},
        "merge distance of first_observation, and of surfaces in image space [m]");
  field("object_m", o.object_m, Range{0.01, 1e4}, "merge distance of objects in running_mean [m]");
  field("surface_m", o.surface_m, Range{0.01, 1e4},
        "spacing of surface vertices in running_mean [m]");
  field("min_surface_points", o.min_surface_points, Range{1, 1e9},
        "surface vertices need this many points over all frames");
}

template <class Visitor>
void visit(EdgeOptions& o, Visitor&& field) {
  field("radius_m", o.radius_m, Range{0.01, 1e4}, "connect vertices nearer than this [m]");
}
namespace match {

template <class Visitor>
void visit(WalkOptions& o, Visitor&& field) {
  field(
      "num_walks", o.num_walks, Range{0, 100000},
      "random walks per vertex, n of the paper; 0 = every walk, counted by its probability, which "
      "is the limit of many and needs no seed");
  field("walk_length", o.walk_length, Range{2, 8},
        "vertices per walk including its start, m of the paper");
  field("nearest", o.nearest, Range{0, 1000},
        "number of nearest neighbours of a vertex that a walk may go on to, as it may to vertices "
        "of which it is one; 0 = all neighbours");
  field("immediate_return", o.immediate_return,
        "allow a walk to step back to the vertex it just left");
}

template <class Visitor>
void visit(MatchOptions& o, Visitor&& field) {
  field("candidates", o.candidates, Range{1, 10000},
        "best map vertices kept per query vertex, k of the paper");
  field("rare_words", o.rare_words, "weight walk words by their rarity in the map");
}
}  // namespace match

namespace match {

template <class Visitor>
void visit(ConsensusOptions& o, Visitor&& field) {
  field("inlier_m", o.inlier_m, Range{0.001, 1e3},
        "a correspondence supports a pose if it ends this near [m]");
  field("iterations", o.iterations, Range{1, 1e8}, "samples drawn by the sample consensus");
  field("min_inliers", o.min_inliers, Range{3, 1e6},
        "fewer supporting correspondences are no pose");
}
}  // namespace match

namespace search {

template <class Visitor>
void visit(SearchOptions& o, Visitor&& field) {
  field("hypotheses", o.hypotheses, Range{1, 1000}, "distinct places reported");
  field("likelihoods", o.likelihoods, "file of xview learn; empty = built in");
  field("cell_m", o.cell_m, Range{0.5, 8}, "cells of the exhaustive (x, y, yaw) search [m]");
  field("detection", o.detection, Range{0.05, 0.99},
        "bare graphs: chance that a query finds an object of the map again");
  field("sigma_m", o.sigma_m, Range{0.05, 20},
        "bare graphs: position error of objects, map and query together [m]");
}
}  // namespace search

namespace verdict {

template <class Visitor>
void visit(VerdictOptions& o, Visitor&& field) {
  field("min_confidence", o.min_confidence, Range{0.5, 0.999999999},
        "confidence from which on an answer is accepted");
  field("min_known_share", o.min_known_share, Range{0, 1},
        "share of the query that must lie where the map was seen");
  field("model", o.model, "file of xview learn --verdict; empty = built in");
}
}  // namespace verdict

namespace pose {

template <class Visitor>
void visit(PosteriorOptions& o, Visitor&& field) {
  field("enabled", o.enabled,
        "correct the pose by the matched vertices and the odometry of the window");
  field(
      "solver", o.solver, Choices{{"trust_region", "gauss_newton"}},
      "trust_region: from the given pose, robust; gauss_newton: as in the paper, quadratic costs, "
      "from the mean of the matched map vertices");
  field(
      "gravity", o.gravity, Choices{{"auto", "aligned", "free"}},
      "aligned: up is known in query and map; free: it is not; auto: aligned if the given pose is "
      "upright within 5 degrees");
  field("odometry_sigma_m", o.odometry_sigma_m, Range{1e-6, 1e3},
        "odometry error after one metre; grows with the root of the distance [m]");
  field("odometry_sigma_rad", o.odometry_sigma_rad, Range{1e-8, 10},
        "same for the direction [rad]");
}

template <class Visitor>
void visit(RefineOptions& o, Visitor&& field) {
  field("enabled", o.enabled, "refine accepted and ambiguous poses on the labelled clouds");
  field("cell_m", o.cell_m, Range{0.1, 10},
        "side of the cells whose points make one distribution [m]");
  field("reach_m", o.reach_m, Range{0, 1e4}, "use the points of the last metres of the query [m]");
  field("max_sigma_m", o.max_sigma_m, Range{0.01, 100},
        "leave out points of map and query that are known less well [m]");
  field("tilt_sigma_deg", o.tilt_sigma_deg, Range{0.001, 360},
        "error of the common gravity direction of query and map [deg]");
  field("max_shift_m", o.max_shift_m, Range{0, 1000},
        "give up if the pose moves further than this: it has found something else [m]");
}

}  // namespace pose

template <class Visitor>
void visit(MapOptions& o, Visitor&& field) {
  field("cloud_voxel_m", o.cloud_voxel_m, Range{0.02, 10},
        "thin the labelled cloud of a map to one point per voxel and class [m]");
}

template <class Visitor>
void visit(PriorOptions& o, Visitor&& field) {
  field("near", o.near, Syntax{requireCircle},
        "the last pose is within the circle x,y,radius of the map [m]; empty = anywhere");
  field("yaw", o.yaw, Syntax{requireHeading},
        "the last pose looks along heading,tolerance, counter-clockwise from x of the map [deg]; "
        "empty = any");
}

template <class Visitor>
void visit(OdometryOptions& o, Visitor&& field) {
  field("drift", o.drift, Range{0, 1}, "error of the odometry as a share of the path length");
  field("drift_deg_per_m", o.drift_deg_per_m, Range{0, 180}, "error of its heading [deg/m]");
  field("check", o.check,
        "hold the odometry against the scans: queries begin behind a jump, maps refuse one");
}

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

}  // namespace xview
