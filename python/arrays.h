// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/graph.h"
#include "xview/base/labels.h"

namespace xview::python {

constexpr const char* kArrays = "points";  ///< name of the recording that clouds of arrays are

namespace py = pybind11;

/// Clouds in arrays of numpy as a recording.
/// @param points  array (N, 3) of float32 or float64 [m], or a sequence of them. They are read
/// where
///                they are, whatever their strides, each time a frame is read.
/// @param labels  None, or an integer array (N,) per cloud: class ids, negative ones are 0
/// @param poses   None for clouds in one frame, or T_odom_sensor (4, 4) per cloud [m]
/// @param stamps  None, or a time per cloud [s]
/// @param classes what the ids mean; without it the clouds are raw
/// Throws UsageError that names the argument, its shape and what was expected.
std::shared_ptr<FrameSource> recordingOf(const py::object& points, const py::object& labels,
                                         const py::object& poses, const py::object& stamps,
                                         const LabelSet& classes);

/// A time [s]. Throws UsageError if it is no finite number.
double stampOf(const py::handle& stamp);
/// A path as the operating system has it. Throws UsageError if it is none.
std::string pathText(const py::object& path, const char* name = "path");

/// The ids that occur in label arrays, rising.
std::vector<std::uint32_t> idsIn(const py::object& labels);

/// The classes that `classes` means: a shipped label set by name, a classes.yaml by path, or a
/// mapping from ids to names, whose roles follow from the names. Throws UsageError, Error.
LabelSet labelSetOf(const py::object& classes);
/// Ids and names.
py::dict namesOf(const LabelSet& labels);

/// A (4, 4) array as a pose. Throws UsageError if it is no rigid motion.
Eigen::Isometry3d poseOf(const py::handle& matrix, const std::string& name);
/// A (N, 4, 4) array, a sequence of (4, 4), or one (4, 4) array, as poses.
std::vector<Eigen::Isometry3d> posesOf(const py::handle& matrices, const std::string& name);

template <int Rows, int Columns>
py::array_t<double> arrayOf(const Eigen::Matrix<double, Rows, Columns>& matrix) {
  py::array_t<double> array({Rows, Columns});
  auto values = array.mutable_unchecked<2>();
  for (int row = 0; row < Rows; ++row) {
    for (int column = 0; column < Columns; ++column) values(row, column) = matrix(row, column);
  }
  return array;
}
py::array_t<double> arrayOf(const std::vector<Eigen::Isometry3d>& poses);  ///< (N, 4, 4)
/// Vertices of query and map, (K, 2).
py::array_t<std::uint32_t> pairsOf(const std::vector<Correspondence>& correspondences);

/// A read-only view of memory that `owner` keeps.
template <class Value, class Owner>
py::array viewOf(const Value* data, std::vector<py::ssize_t> shape,
                 std::vector<py::ssize_t> strides, std::shared_ptr<Owner> owner) {
  auto* kept = new std::shared_ptr<Owner>(std::move(owner));
  const py::capsule base(kept, [](void* p) { delete static_cast<std::shared_ptr<Owner>*>(p); });
  py::array array(py::dtype::of<Value>(), std::move(shape), std::move(strides), data, base);
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// The points of a cloud (N, 3) [m]: a view, or float64 if they are relative to an origin. Neither
/// can be written.
py::array pointsOf(std::shared_ptr<const LabelledCloud> cloud);
/// Their class ids (N,): a view.
py::array labelsOf(std::shared_ptr<const LabelledCloud> cloud);

}  // namespace xview::python
