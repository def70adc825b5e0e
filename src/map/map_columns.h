// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cloud_tiles.h"
#include "edge_blocks.h"
#include "plan_tiles.h"
#include "xview/map/semantic_map.h"

namespace xview {

/// A row of the table of key frames.
struct Keyframe {
  std::int64_t number = 0;
  double stamp_s = 0;
  std::uint32_t source = 0;
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
};

// The columns of the tables behind the key, in order: once for writing and for reading.

template <class Row>
void columns(Row& row, Vertex& v) {
  row(v.label);
  row(v.instance);
  for (int i = 0; i < 3; ++i) row(v.position[i]);
  for (int i = 0; i < 3; ++i) row(v.extent[i]);
  row(v.sigma_m);
  row(v.observations);
  row(v.points);
  row(v.first_frame);
  row(v.last_frame);
}

template <class Row>
void columns(Row& row, Keyframe& k) {
  row(k.number);
  row(k.stamp_s);
  row(k.source);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) row(k.T_map_sensor.matrix()(i, j));
  }
}

template <class Row>
void columns(Row& row, PlanTile& t) {
  row(t.x);
  row(t.y);
  row(t.known);
  row(t.samples);
  row(t.data);
}

template <class Row>
void columns(Row& row, CloudTile& t) {
  row(t.x);
  row(t.y);
  row(t.z);
  row(t.points);
  row(t.data);
}

template <class Row>
void columns(Row& row, EdgeBlock& b) {
  row(b.edges);
  row(b.data);
}

}  // namespace xview
