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
#include "xview/match/descriptors.h"
#include "xview/match/walks.h"
#include "xview/types/option_field.h"
#include "xview/verify/clique.h"
#include "xview/verify/sample_consensus.h"

namespace xview {

/// Everything that can be set, one struct per stage. Struct path = YAML key = flag: walks.num_walks, --walks.num_walks 200.
struct Options {
  std::string method = "auto";
  int seed = 1;
  int threads = 0;
  CleanOptions clean;
  LiftOptions lift;
  BlobOptions blobs;
  ImageBlobOptions image_blobs;
  MergeOptions merge;
  EdgeOptions edges;
  WalkOptions walks;
  MatchOptions match;
  ConsistencyOptions consistency;
  ConsensusOptions consensus;
};

template <class Visitor>
void visit(Options& o, Visitor&& field) {
  field("method", o.method, Choices{{"auto", "walks", "search"}},
        "who proposes poses: X-View's walks, the place search, or both");
  field("seed", o.seed, Range{0, 2147483647}, "seed of everything random");
  field("threads", o.threads, Range{0, 1024}, "threads; 0 = all cores. Results do not depend on it");
  field.group("clean", o.clean);
  field.group("lift", o.lift);
  field.group("blobs", o.blobs);
  field.group("image_blobs", o.image_blobs);
  field.group("merge", o.merge);
  field.group("edges", o.edges);
  field.group("walks", o.walks);
  field.group("match", o.match);
  field.group("consistency", o.consistency);
  field.group("consensus", o.consensus);
}

}  // namespace xview
