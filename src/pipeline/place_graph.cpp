// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/place_graph.h"

#include "pipeline/thin_objects.h"
#include "xview/graph/edges.h"
#include "xview/types/error.h"

namespace xview {

PlaceGraph::PlaceGraph(const LabelSet& labels, const Options& options)
    : places_(labels, options.merge), labels_(labels), options_(options) {}

void PlaceGraph::add(const FrameDigest& frame) {
  if (isImageSpace(options_)) {
    places_.addImageBlobs(frame.blobs, frame.blob_edges, frame.number);
  } else {
    places_.add(frame.blobs, frame.number);
    places_.addSurfacePoints(frame.cloud, frame.number);
  }
}

SemanticGraph PlaceGraph::finish(const PlanView& plan) const {
  SemanticGraph graph = places_.graph();
  if (isImageSpace(options_)) return graph;
  if (options_.merge.mode == "running_mean") placeThinObjects(graph, plan, labels_);
  connectByRadius(graph, options_.edges);
  return graph;
}

void requireGraphSpace(const Options& options, Sensor sensor, const std::string& recording) {
  if (!isImageSpace(options) || sensor == Sensor::camera) return;
  throw UsageError("graph_space = image needs depth and label images, but " + recording +
                   (sensor == Sensor::lidar ? " holds LiDAR scans" : " is a cloud") +
                   "; use graph_space = cloud");
}

bool isImageSpace(const Options& options) { return options.graph_space == "image"; }

}  // namespace xview
