// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"

namespace xview {

/// Names of the fields to use; empty = the first of the well-known names that is present.
struct CloudFields {
  std::string label;
  std::string instance;
};

/// What the header of a PCD or PLY says.
struct CloudHeader {
  std::string format;  ///< "PCD ascii", "PLY binary_big_endian", …
  std::size_t points = 0;
  std::vector<std::string> fields;  ///< names of the point fields in order
  std::string label_field;          ///< the one that would be used; empty = none
  std::string instance_field;
  bool has_edges = false;  ///< PLY with element edge (or vertex with our graph properties)
};
CloudHeader readCloudHeader(const std::string& path, const CloudFields& fields = {});

/// Reads .pcd and .ply strictly: the header is checked against the size of the file in 64 bit
/// before anything is allocated; labels of any numeric type (a float label must be a whole number
/// >= 0; a negative one is unlabelled, 0); double coordinates minus a local origin; points that are
/// not finite are dropped (PCD uses NaN for "no point"). Throws Error with path and line or byte.
/// `require_label`: a file without a label field is an error that lists the fields it has.
LabelledCloud readCloud(const std::string& path, const CloudFields& fields = {},
                        bool require_label = true);

/// Binary PCD with x y z label [instance], and rgb if a label set is given, so that pcl_viewer
/// shows it. float32 if the origin is zero, else the origin is added back in double (x y z as F 8).
/// Written beside and renamed. Throws Error.
void writePcd(const std::string& path, const LabelledCloud& cloud,
              const LabelSet* colors = nullptr);
/// Same as binary PLY (x y z, red green blue, label, instance).
void writePly(const std::string& path, const LabelledCloud& cloud,
              const LabelSet* colors = nullptr);

/// A SemanticKITTI scan: float32 x y z intensity and uint32 labels (class low, instance high 16
/// bits). Throws Error.
LabelledCloud readKittiScan(const std::string& bin_path, const std::string& label_path);

}  // namespace xview
