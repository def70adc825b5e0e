// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "place/edges.h"
#include "xview/base/bev_grid.h"
#include "xview/base/graph.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/options.h"

namespace xview {

/// Merges the blobs of successive frames into the vertices of one place graph (paper section
/// III-C). The cost of a frame does not depend on the size of the graph: vertices are found through
/// a hash of cells. Blobs of ignored classes and blobs whose position is not finite are left out.
///
/// Mode first_observation: a blob is absorbed by the nearest vertex of its class within the merge
/// distance (and of its instance, if both have one). That vertex stays where it was first seen.
/// Otherwise the blob becomes a vertex. All classes are treated the same way; surfaces get evenly
/// spaced vertices.
///
/// Mode running_mean: blobs of object and dynamic classes are paired with vertices (same class and
/// instance, within object_m) from the nearest pair outwards, at most one vertex per blob and one
/// blob per vertex in a frame; the rest become vertices. A vertex is at the mean of its blobs,
/// weighted by their points up to a cap, so that one close view does not outvote many. Surface
/// classes get vertices from their points (addSurfacePoints; their blobs are ignored) on a lattice
/// of surface_m that is fixed in the odometry frame, each at the mean of the points in its cell.
///
/// Image space (addImageBlobs): blobs of all classes become vertices, because that is what edges in
/// the image join; surfaces merge as in first_observation in both modes, objects as the mode says.
/// Two vertices are neighbours if blobs of them were neighbours in any frame.
///
/// Vertex::extent: mean size of the blobs, weighted alike, because a maximum would keep the worst
/// blob for ever; as first seen in first_observation; the box around the points for surfaces.
/// Vertex::sigma_m: root mean square distance of the blobs from the vertex per axis, 0 after one
/// observation and for surfaces. Vertex::observations: frames, not blobs.
class PlaceGraphBuilder {
 public:
  PlaceGraphBuilder(const LabelSet& labels, const MergeOptions& options);
  ~PlaceGraphBuilder();

  /// Blobs of one frame in the odometry frame; frames in order.
  void add(const std::vector<Blob>& blobs, std::int64_t frame_number);
  /// Points of surface classes of the same frame; used by running_mean only.
  void addSurfacePoints(const LabelledCloud& cloud, std::int64_t frame_number);
  /// Blobs and edges of one frame in image space, instead of the two above; frames in order.
  void addImageBlobs(const std::vector<Blob>& blobs, const BlobEdges& edges,
                     std::int64_t frame_number);
  /// The vertices so far, in order of first observation; edges only of image space.
  SemanticGraph graph() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Adds the vertices of another graph of the same frame: one within the merge distance of a vertex
/// of its class (half the spacing of surfaces) is that vertex, at the mean of both, weighted by how
/// often each was seen. Edges are those of the radius; in image space those of both stay.
void mergeGraphs(SemanticGraph& graph, const SemanticGraph& addition, const LabelSet& labels,
                 const MergeOptions& options, const EdgeOptions& edge_options);

/// Replaces the vertices of poles, signs and lights by those of the BEV grid of the same points.
/// The centre of a cluster depends on which part of a post was seen, and a cluster smears along the
/// rays of a noisy camera; a density peak does not, and its foot on the ground is the same from the
/// street and from the air. A post is a pole whatever its labels say, also that of a sign, because
/// in noise its labels differ from visit to visit; the sign is a vertex beside it. Posts without a
/// cluster of poles are of the first class of poles, if there is one. A vertex keeps what is known
/// of the nearest cluster of its kind; the new ones come last, in the order of the BEV grid. Edges
/// are dropped. Nothing changes without a BEV grid.
void placeThinObjects(SemanticGraph& graph, const BevGrid& bev, const LabelSet& labels);

}  // namespace xview
