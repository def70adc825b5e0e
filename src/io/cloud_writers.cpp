// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>

#include "class_comments.h"
#include "xview/io/atomic_file.h"
#include "xview/io/cloud_files.h"

namespace xview {
namespace {

/// What a file of this cloud has beside position and label.
struct Contents {
  bool doubles = false;
  bool instances = false;
  const LabelSet* labels = nullptr;
};

/// Whether single precision would lose more than half a millimetre.
bool needsDoubles(const LabelledCloud& cloud) {
  constexpr double kFar_m = 1e4;
  if (cloud.origin.isZero(0)) return false;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!(cloud.position(i).cwiseAbs().maxCoeff() < kFar_m)) return true;
  }
  return false;
}

Contents contentsOf(const LabelledCloud& cloud, const LabelSet* labels) {
  return {needsDoubles(cloud), cloud.hasInstances(), labels};
}

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

void appendPosition(std::string& bytes, const LabelledCloud& cloud, std::size_t i, bool doubles) {
  const Eigen::Vector3d position = cloud.position(i);
  for (int axis = 0; axis < 3; ++axis) {
    if (doubles) {
      append(bytes, position[axis]);
    } else {
      append(bytes, static_cast<float>(position[axis]));
    }
  }
}

/// Red, green and blue in the bits 16-23, 8-15 and 0-7, as PCL packs them into its float field
/// "rgb".
std::uint32_t packedColor(const LabelSet& colors, std::uint32_t label) {
  const auto [red, green, blue] = colors.color(label);
  return (std::uint32_t{red} << 16) | (std::uint32_t{green} << 8) | blue;
}

std::string pcdHeader(const LabelledCloud& cloud, const Contents& contents) {
  const char* position_size = contents.doubles ? "8" : "4";
  std::string fields = "x y z", types = "F F F", counts = "1 1 1";
  std::string sizes = std::string(position_size) + " " + position_size + " " + position_size;
  const auto addField = [&](const char* name, const char* type) {
    fields += std::string(" ") + name;
    types += std::string(" ") + type;
    sizes += " 4";
    counts += " 1";
  };
  if (contents.labels) addField("rgb", "F");
  addField("label", "U");
  if (contents.instances) addField("instance", "U");
  const std::string points = std::to_string(cloud.size());
  const std::string classes =
      contents.labels ? classComments(*contents.labels, "# ") : std::string();
  return "# .PCD v0.7 - Point Cloud Data file format\n" + classes + "VERSION 0.7\nFIELDS " +
         fields + "\nSIZE " + sizes + "\nTYPE " + types + "\nCOUNT " + counts + "\nWIDTH " +
         points + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA binary\n";
}

std::string plyHeader(const LabelledCloud& cloud, const Contents& contents) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (contents.labels) header += classComments(*contents.labels, "comment ");
  header += "element vertex " + std::to_string(cloud.size());
  for (const char* axis : {"x", "y", "z"}) {
    header += std::string("\nproperty ") + (contents.doubles ? "double " : "float ") + axis;
  }
  if (contents.labels) header += "\nproperty uchar red\nproperty uchar green\nproperty uchar blue";
  header += "\nproperty uint label";
  if (contents.instances) header += "\nproperty uint instance";
  return header + "\nend_header\n";
}

}  // namespace

void writePcd(const std::string& path, const LabelledCloud& cloud, const LabelSet* labels) {
  const Contents contents = contentsOf(cloud, labels);
  AtomicFile file(path);
  file.write(pcdHeader(cloud, contents));
  std::string row;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    row.clear();
    appendPosition(row, cloud, i, contents.doubles);
    if (labels) append(row, packedColor(*labels, cloud.points[i].label));
    append(row, cloud.points[i].label);
    if (contents.instances) append(row, cloud.points[i].instance);
    file.write(row);
  }
  file.commit();
}

void writePly(const std::string& path, const LabelledCloud& cloud, const LabelSet* labels) {
  const Contents contents = contentsOf(cloud, labels);
  AtomicFile file(path);
  file.write(plyHeader(cloud, contents));
  std::string row;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    row.clear();
    appendPosition(row, cloud, i, contents.doubles);
    if (labels) {
      for (const std::uint8_t channel : labels->color(cloud.points[i].label)) append(row, channel);
    }
    append(row, cloud.points[i].label);
    if (contents.instances) append(row, cloud.points[i].instance);
    file.write(row);
  }
  file.commit();
}

}  // namespace xview
