// SPDX-License-Identifier: BSD-3-Clause
#include "places.h"

#include <fmt/core.h>
#include <pybind11/stl.h>

#include "place/raw_recording.h"
#include "xview/base/error.h"

namespace xview::python {
namespace {

const Frame readFrame(const Recording& recording, py::ssize_t index) {
  const auto size = static_cast<py::ssize_t>(recording.source->size());
  const py::ssize_t at = index < 0 ? index + size : index;
  if (at < 0 || at >= size)
    throw py::index_error(fmt::format("frame {} of a recording of {}", index, size));
  return released([&] { return recording.source->read(static_cast<std::size_t>(at)); });
}

std::shared_ptr<const LabelledCloud> cloudOf(const Recording& recording, py::ssize_t index) {
  Frame frame = readFrame(recording, index);
  if (frame.sensor == Sensor::camera)
    throw UsageError(recording.source->name() +
                     ": its frames are images: see depth(), label_image() and cloud()");
  return std::make_shared<const LabelledCloud>(std::move(frame.cloud));
}

template <class Pixel>
py::array imageOf(Image<Pixel> image) {
  const auto kept = std::make_shared<const Image<Pixel>>(std::move(image));
  const py::ssize_t height = kept->height, width = kept->width, bytes = sizeof(Pixel);
  return viewOf(kept->pixels.data(), {height, width}, {width * bytes, bytes}, kept);
}

std::vector<Eigen::Isometry3d> posesOfFrames(const Recording& recording) {
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < recording.source->size(); ++i)
    poses.push_back(recording.source->pose(i));
  return poses;
}

/// The frames of a slice, none of which is read. Whoever opens the recording by its path is told
/// which they are.
Recording sliceOf(const Recording& recording, const py::slice& slice) {
  py::ssize_t begin = 0, end = 0, step = 0, count = 0;
  const auto size = static_cast<py::ssize_t>(recording.source->size());
  if (!slice.compute(size, &begin, &end, &step, &count)) throw py::error_already_set();
  if (step < 0) throw UsageError("the frames of a recording have one order; step must be > 0");
  if (count == 0) throw UsageError(fmt::format("no frame of the {} is in the slice", size));
  Recording part{recording.path, recording.input, nullptr, {}};
  std::vector<std::size_t> positions;
  for (py::ssize_t i = 0; i < count; ++i) {
    positions.push_back(static_cast<std::size_t>(begin + i * step));
    if (!recording.truth.empty()) part.truth.push_back(recording.truth[positions.back()]);
  }
  if (!part.path.empty()) {
    const io::FrameRange& of = recording.input.frames;
    part.input.frames = {of.begin + positions.front() * of.step,
                         of.begin + positions.back() * of.step + 1,
                         count == 1 ? 1 : of.step * static_cast<std::size_t>(step)};
  }
  std::vector<Eigen::Isometry3d> poses;
  for (const std::size_t at : positions) poses.push_back(recording.source->pose(at));
  const auto release = [whole = recording.source](const FrameSource* source) { delete source; };
  part.source = {new PosedRecording(*recording.source, positions, poses), release};
  return part;
}

Recording frameOf(const Recording& recording, py::ssize_t index) {
  const auto size = static_cast<py::ssize_t>(recording.source->size());
  const py::ssize_t at = index < 0 ? index + size : index;
  if (at < 0 || at >= size)
    throw py::index_error(fmt::format("frame {} of a recording of {}", index, size));
  return sliceOf(recording, py::slice(at, at + 1, 1));
}

py::tuple wholeCloud(const Recording& recording, double voxel_m, const py::kwargs& options) {
  Work work(optionsOf(options));
  auto cloud = released([&] {
    const std::unique_ptr<FrameSource> source =
        recording.path.empty() ? ownedSource(recording.source)
                               : tools::openInput(recording.path, recording.input, work.job());
    return std::make_shared<const LabelledCloud>(
        tools::liftAll(*withClasses(*source, work.job().options), work.job(), voxel_m));
  });
  work.takeNotes();
  return py::make_tuple(pointsOf(cloud), labelsOf(cloud));
}

void saveRecording(const Recording& recording, const py::object& folder, int threads) {
  const std::string path = pathText(folder);
  released([&] {
    io::writeRecording(path, *recording.source, recording.truth, threads,
                       [](std::size_t, std::size_t) { checkSignals(); });
    return 0;
  });
}

}  // namespace

void bindRecording(py::module_& module) {
  py::class_<Recording>(module, "Recording",
                        "Frames of a file or folder, or of a simulated drive, in order. Frames are "
                        "read when they are asked for.")
      .def("__len__", [](const Recording& r) { return r.source->size(); })
      .def("__getitem__", &sliceOf, py::arg("frames"),
           "The frames of a slice as a recording of their own; nothing is read.")
      .def("__getitem__", &frameOf, py::arg("frame"),
           "One frame as a recording; `for frame in recording` has them all in order.")
      .def("__repr__",
           [](const Recording& r) {
             return fmt::format("<xview.Recording {}: {} frames>", r.source->name(),
                                r.source->size());
           })
      .def_property_readonly(
          "name", [](const Recording& r) { return r.source->name(); }, "The path as given.")
      .def_property_readonly(
          "sensor",
          [](const Recording& r) {
            const Sensor sensor = r.source->sensor();
            return sensor == Sensor::camera  ? "camera"
                   : sensor == Sensor::lidar ? "lidar"
                                             : "cloud";
          },
          "'camera' (depth and label images), 'lidar' (scans in the frame of the sensor) or "
          "'cloud' (clouds without a view-point).")
      .def_property_readonly(
          "classes", [](const Recording& r) { return namesOf(r.source->labels()); },
          "Class ids and names; empty if the recording has no labels.")
      .def_property_readonly(
          "notes",
          [](const Recording& r) {
            std::vector<std::string> notes = r.source->notes();
            if (const LeftOut left_out = r.source->leftOut(); left_out.any())
              notes.push_back(left_out.text());
            return notes;
          },
          "What the reader guessed or left out, and why.")
      .def_property_readonly(
          "poses", [](const Recording& r) { return arrayOf(posesOfFrames(r)); },
          "T_odom_sensor of all frames, float64 (N, 4, 4): p_odom = T @ p_sensor [m].")
      .def_property_readonly(
          "truth",
          [](const Recording& r) -> py::object {
            if (r.truth.empty()) return py::none();
            return arrayOf(r.truth);
          },
          "T_map_sensor of all frames of a simulated drive, float64 (N, 4, 4) [m], else None.")
      .def_property_readonly(
          "stamps",
          [](const Recording& r) {
            std::vector<double> stamps;
            for (std::size_t i = 0; i < r.source->size(); ++i) stamps.push_back(r.source->stamp(i));
            return py::array_t<double>(static_cast<py::ssize_t>(stamps.size()), stamps.data());
          },
          "Times of all frames, float64 (N,) [s].")
      .def(
          "points", [](const Recording& r, py::ssize_t i) { return pointsOf(cloudOf(r, i)); },
          py::arg("frame"),
          "Points of a frame, float32 (M, 3) in the frame of the sensor [m]; float64 if they are "
          "far from the origin.")
      .def(
          "labels", [](const Recording& r, py::ssize_t i) { return labelsOf(cloudOf(r, i)); },
          py::arg("frame"), "Class ids of the points of a frame, uint32 (M,).")
      .def(
          "depth", [](const Recording& r, py::ssize_t i) { return imageOf(readFrame(r, i).depth); },
          py::arg("frame"),
          "Depth image of a camera's frame, float32 (H, W), along the optical axis [m]; 0 = no "
          "measurement.")
      .def(
          "label_image",
          [](const Recording& r, py::ssize_t i) { return imageOf(readFrame(r, i).label); },
          py::arg("frame"), "Class ids of a camera's frame, uint16 (H, W).")
      .def("cloud", &wholeCloud, py::arg("voxel_m") = 0.1,
           "All frames as one cloud: points float32 (M, 3) in the odometry frame [m] and class ids "
           "uint32 (M,). One point per voxel and class; voxel_m = 0 keeps all.")
      .def("save", &saveRecording, py::arg("folder"), py::arg("threads") = 0,
           "Writes a sequence folder (camera) or a SemanticKITTI folder (scans), with "
           "groundtruth.txt if the truth is known. The folder appears whole or not at all.");
}

}  // namespace xview::python
