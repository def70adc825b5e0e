// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"

namespace xview::io {

/// Names of the fields to use; empty = the first of the well-known names that is present.
struct CloudFields {
  std::string label;
  std::string instance;
};

/// What the header of a PCD, PLY, LAS or E57 says.
struct CloudHeader {
  std::string format;  ///< "PCD ascii", "PLY binary_big_endian", …
  std::size_t points = 0;
  std::vector<std::string> fields;  ///< names of the point fields in order
  std::string label_field;          ///< the one that would be used; empty = none
  std::string instance_field;
  std::optional<LabelSet> labels;  ///< the classes that its comments name
  std::string georeference;        ///< coordinate system as the file says it; empty = none
  std::vector<std::string> notes;  ///< what is odd about the file, in sentences
};
/// The kinds of files that hold one cloud: ".pcd", ".ply", ….
std::vector<std::string> cloudEndings();
bool isCloudFile(const std::string& path);  ///< ends in one of them, in letters of either case
/// Reads no more than the header; it is checked against the size of the file. Throws Error.
CloudHeader readCloudHeader(const std::string& path, const CloudFields& fields = {});

/// The setups of an E57 as paths of their own (FILE.e57#1, FILE.e57#2, …), each of which is read as
/// a file with one scan; of everything else the path. Throws Error.
std::vector<std::string> setupsOf(const std::string& path);

/// Reads .pcd, .ply, .las, .e57 and folders of tiles (writeTiles) strictly; throws Error with path
/// and line, or path and number of the point (from 0) in binary files.
/// - The header is checked against the size of the file in 64 bit before anything is allocated;
/// rows that are missing, too
///   short, too long or too many, and fields of the same name that are used, are errors.
/// - Labels and instances may have any numeric type. Negative ones, NaN, and -1 stored unsigned,
///   become 0; fractions and numbers beyond 32 bit are errors.
/// - Points that are not finite are dropped with their labels (PCD uses NaN for "no point").
/// - If double coordinates go beyond 1 km, or coordinates in a text beyond 10 km, the first such
/// point, rounded down to
///   metres, becomes the origin. Binary float32 coordinates are kept as they are.
/// - VIEWPOINT is not applied to the points, as in PCL.
/// - LAS 1.0 to 1.4, point formats 0 to 10: the class is the label, without the flags beside it.
/// `require_label`: a file without a label field is an error that lists the fields it has.
LabelledCloud readCloud(const std::string& path, const CloudFields& fields = {},
                        bool require_label = true);

/// Whether the cloud is written as doubles, because single precision would lose more than half a
/// millimetre.
bool needsDoubles(const LabelledCloud& cloud);
/// Binary PCD with x y z label [instance]; with a label set also rgb, so that pcl_viewer shows it,
/// and its classes as comments of the header. x y z are float32, unless the cloud has an origin and
/// a coordinate of 10 km or more: then they are doubles (F 8), which this program reads but PCL
/// does not. Written beside and renamed. Throws Error.
void writePcd(const std::string& path, const LabelledCloud& cloud,
              const LabelSet* labels = nullptr);
/// Same as binary PLY (x y z, red green blue, label, instance).
void writePly(const std::string& path, const LabelledCloud& cloud,
              const LabelSet* labels = nullptr);

/// Same as LAS 1.4 (class, class colour, millimetres); ids of classes are at most 255.
void writeLas(const std::string& path, const LabelledCloud& cloud,
              const LabelSet* labels = nullptr);

/// A PCD, PLY or LAS again as .pcd, .ply or .las by the ending of `to`, moved, with all its points,
/// in one row, and all fields of one number each: normals turn along, coordinates are double from
/// 10 km on, integers beyond 2^53 are rounded. `labels`, if given, names its classes. LAS has no
/// place for some fields and for points that are not finite. Of LAS in LAS every byte stays but
/// those of coordinates. Returns what it had to leave out and who cannot read it, in sentences.
/// Throws Error.
std::vector<std::string> copyCloud(const std::string& from, const std::string& to,
                                   const Eigen::Affine3d& moved, const LabelSet* labels = nullptr);

/// The cloud in square tiles as Autoware divides its map: `folder` gets
/// pointcloud_map_metadata.yaml and pointcloud_map.pcd/, with one PCD as of writePcd() for each
/// tile that has points. It appears whole or not at all; tiles of before are replaced. Throws
/// Error, UsageError if there would be too many.
void writeTiles(const std::string& folder, const LabelledCloud& cloud, int size_m,
                const LabelSet* labels = nullptr);

/// A SemanticKITTI scan: float32 x y z intensity and uint32 labels (class low, instance high 16
/// bits). Rows of five numbers are told by whole ones in the last place, the ring. Points that are
/// not finite are dropped. Throws Error, also if the two files disagree in the number of points.
LabelledCloud readKittiScan(const std::string& bin_path, const std::string& label_path);

}  // namespace xview::io
