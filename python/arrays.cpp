// SPDX-License-Identifier: BSD-3-Clause
#include "arrays.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "base/pose.h"
#include "base/stray_points.h"
#include "io/layouts.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"
#include "xview/io/recording.h"

namespace xview::python {
namespace {

/// Coordinates beyond this are kept relative to an origin: float32 has steps of 1 mm there.
constexpr double kFar_m = 8192;

std::string shapeText(const py::array& array) {
  std::string text;
  for (py::ssize_t i = 0; i < array.ndim(); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return "(" + text + (array.ndim() == 1 ? ",)" : ")");
}

/// Rows of memory that is read again and again (stride 0) cost nothing to ask for.
void requireFewRows(const py::array& array, const std::string& name) {
  constexpr py::ssize_t kMostRows = 1000000000;
  if (array.ndim() > 0 && array.shape(0) > kMostRows)
    throw UsageError(
        fmt::format("{} has {} rows, expected {} at most", name, array.shape(0), kMostRows));
}

py::array asArray(const py::handle& object, const std::string& name) {
  py::array array = py::array::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw UsageError(name + " is no array of numbers");
  }
  requireFewRows(array, name);
  return array;
}

/// A finite number, of any type that Python takes for one.
double numberOf(const py::handle& object, const std::string& name) {
  const double number = PyFloat_AsDouble(object.ptr());
  const bool is_none = PyErr_Occurred() != nullptr;
  PyErr_Clear();
  if (is_none || !std::isfinite(number)) throw UsageError(name + " is no finite number");
  return number;
}

/// The text of a string of Python; some hold halves of characters, which no text has.
std::string utf8Of(const py::handle& object, const std::string& name) {
  if (!py::isinstance<py::str>(object)) throw UsageError(name + " is no text");
  py::ssize_t bytes = 0;
  const char* text = PyUnicode_AsUTF8AndSize(object.ptr(), &bytes);
  if (text != nullptr) return {text, static_cast<std::size_t>(bytes)};
  PyErr_Clear();
  throw UsageError(name + " holds a character that cannot be written (a lone surrogate)");
}

std::uint32_t classIdOf(const py::handle& object) {
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
  const unsigned long long id = index ? PyLong_AsUnsignedLongLong(index.ptr()) : 0;
  const bool is_none = PyErr_Occurred() != nullptr;
  PyErr_Clear();
  if (is_none || id > 0xFFFFFFFFu) {
    const py::str shown = py::repr(object);
    throw UsageError("classes: " + utf8Of(shown, "a class id") +
                     " is no class id, expected an integer in [0, 4294967295]");
  }
  return static_cast<std::uint32_t>(id);
}

/// Numbers of any type in memory that somebody else keeps.
class Column {
 public:
  Column() = default;
  Column(const char* data, py::ssize_t stride, char kind, py::ssize_t bytes)
      : data_(data), stride_(stride), kind_(kind), bytes_(bytes) {}

  template <class Target>
  Target at(std::size_t row) const {
    const char* p = data_ + static_cast<py::ssize_t>(row) * stride_;
    if (kind_ == 'f') return bytes_ == 4 ? as<Target, float>(p) : as<Target, double>(p);
    const bool is_signed = kind_ == 'i';
    switch (bytes_) {
      case 1:
        return is_signed ? as<Target, std::int8_t>(p) : as<Target, std::uint8_t>(p);
      case 2:
        return is_signed ? as<Target, std::int16_t>(p) : as<Target, std::uint16_t>(p);
      case 4:
        return is_signed ? as<Target, std::int32_t>(p) : as<Target, std::uint32_t>(p);
      default:
        return is_signed ? as<Target, std::int64_t>(p) : as<Target, std::uint64_t>(p);
    }
  }

 private:
  template <class Target, class Source>
  static Target as(const char* p) {
    Source value;
    std::memcpy(&value, p, sizeof value);  // strides need not be aligned
    return static_cast<Target>(value);
  }

  const char* data_ = nullptr;
  py::ssize_t stride_ = 0;
  char kind_ = 'f';
  py::ssize_t bytes_ = 4;
};

struct CloudInArrays {
  std::size_t size = 0;
  bool is_double = false, has_labels = false;
  Column x, y, z, label;
};

Column columnOf(const py::array& array, py::ssize_t first_byte) {
  return {static_cast<const char*>(array.data()) + first_byte, array.strides(0),
          array.dtype().kind(), array.dtype().itemsize()};
}

void takePoints(const py::array& array, const std::string& name, CloudInArrays& cloud) {
  const char kind = array.dtype().kind();
  const py::ssize_t bytes = array.dtype().itemsize();
  const bool is_native = py::bool_(array.dtype().attr("isnative"));
  if (kind != 'f' || (bytes != 4 && bytes != 8) || !is_native)
    throw UsageError(name + " has numbers of type " + std::string(py::str(array.dtype())) +
                     ", expected float32 or float64 [m]; whole numbers may be steps of a file");
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw UsageError(name + " has the shape " + shapeText(array) + ", expected (N, 3)");
  cloud.size = static_cast<std::size_t>(array.shape(0));
  cloud.is_double = bytes == 8;
  cloud.x = columnOf(array, 0);
  cloud.y = columnOf(array, array.strides(1));
  cloud.z = columnOf(array, 2 * array.strides(1));
}

void requireLabels(const py::array& array, const std::string& name) {
  const char kind = array.dtype().kind();
  if ((kind != 'i' && kind != 'u') || !py::bool_(array.dtype().attr("isnative")))
    throw UsageError(name + " has numbers of type " + std::string(py::str(array.dtype())) +
                     ", expected integers: class ids");
}

void takeLabels(const py::array& array, const std::string& name, CloudInArrays& cloud) {
  requireLabels(array, name);
  if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != cloud.size)
    throw UsageError(fmt::format("{} has the shape {}, expected ({},): one class id per point",
                                 name, shapeText(array), cloud.size));
  cloud.has_labels = true;
  cloud.label = columnOf(array, 0);
}

LabelledCloud cloudOf(const CloudInArrays& cloud) {
  CloudBuilder builder(cloud.is_double ? kFar_m : std::numeric_limits<double>::infinity());
  builder.reserve(cloud.size);
  for (std::size_t i = 0; i < cloud.size; ++i) {
    const Eigen::Vector3d p(cloud.x.at<double>(i), cloud.y.at<double>(i), cloud.z.at<double>(i));
    if (!p.allFinite()) continue;
    const auto label = cloud.has_labels ? cloud.label.at<std::int64_t>(i) : 0;
    builder.add(p, Point(0, 0, 0, static_cast<std::uint32_t>(label < 0 ? 0 : label)));
  }
  return builder.finish(kArrays);
}

/// May be let go of by threads that do not hold the interpreter.
std::shared_ptr<py::list> keptArrays() {
  return {new py::list(), [](py::list* list) {
            const py::gil_scoped_acquire gil;
            delete list;
          }};
}

bool isListOfClouds(const py::object& points) {
  if (py::isinstance<py::array>(points)) return false;
  if (!py::isinstance<py::sequence>(points) || py::isinstance<py::str>(points))
    throw UsageError("points is a " + std::string(py::str(py::type::of(points).attr("__name__"))) +
                     ", expected an array (N, 3), or a list of them; xview.read opens a file");
  return true;
}

/// Counted before they are taken: there may be more than fit into memory.
void requireCount(const py::object& items, std::size_t clouds, const char* name, const char* what) {
  const py::ssize_t count = PyObject_Size(items.ptr());
  PyErr_Clear();
  if (count != static_cast<py::ssize_t>(clouds))
    throw UsageError(
        fmt::format("{} has {} {}, expected {}: one per cloud", name, count, what, clouds));
}

/// One item per cloud of what may be given for one cloud or for several.
std::vector<py::object> perCloud(const py::object& given, bool is_list, std::size_t clouds,
                                 const char* name) {
  if (!is_list) return {given};
  if (!py::isinstance<py::sequence>(given) && !py::isinstance<py::array>(given))
    throw UsageError(std::string(name) + " is not a list, but there is a list of points");
  requireCount(given, clouds, name, "items");
  std::vector<py::object> items;
  for (const py::handle item : given) items.push_back(py::reinterpret_borrow<py::object>(item));
  return items;
}

}  // namespace

std::shared_ptr<FrameSource> recordingOf(const py::object& points, const py::object& labels,
                                         const py::object& poses, const py::object& stamps,
                                         const LabelSet& classes) {
  const bool is_list = isListOfClouds(points);
  const auto arrays = keptArrays();
  const auto keep = [&](const py::handle& object, const std::string& name) {
    const py::array array = asArray(object, name);
    arrays->append(array);
    return array;
  };
  std::vector<CloudInArrays> clouds;
  const auto indexed = [&](const char* name, std::size_t i) {
    return is_list ? fmt::format("{}[{}]", name, i) : std::string(name);
  };
  const auto take = [&](const py::handle& item) {
    const std::string name = indexed("points", clouds.size());
    takePoints(keep(item, name), name, clouds.emplace_back());
  };
  if (is_list) {
    for (const py::handle item : points) take(item);
  } else {
    take(points);
  }
  if (clouds.empty()) throw UsageError("points is an empty list, expected clouds");
  io::RecordingListing listing;
  listing.sensor = poses.is_none() ? Sensor::cloud : Sensor::lidar;
  listing.labels = classes;
  listing.frames.resize(clouds.size());
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    listing.frames[i].number = static_cast<std::int64_t>(i);
    listing.frames[i].measurement = kArrays;
  }
  if (!labels.is_none()) {
    const auto of_clouds = perCloud(labels, is_list, clouds.size(), "labels");
    for (std::size_t i = 0; i < clouds.size(); ++i)
      takeLabels(keep(of_clouds[i], indexed("labels", i)), indexed("labels", i), clouds[i]);
  }
  if (!poses.is_none()) {
    if (is_list) requireCount(poses, clouds.size(), "poses", "poses");
    const auto T =
        is_list ? posesOf(poses, "poses") : std::vector<Eigen::Isometry3d>{poseOf(poses, "poses")};
    for (std::size_t i = 0; i < clouds.size(); ++i) listing.frames[i].T_odom_sensor = T[i];
  }
  if (!stamps.is_none()) {
    const auto of_clouds = perCloud(stamps, is_list, clouds.size(), "stamps");
    for (std::size_t i = 0; i < clouds.size(); ++i)
      listing.frames[i].stamp_s = numberOf(of_clouds[i], indexed("stamps", i));
  }
  listing.read = [clouds = std::move(clouds), arrays](const io::ListedFrame& listed, Frame& frame) {
    frame.cloud = cloudOf(clouds[static_cast<std::size_t>(listed.number)]);
  };
  return io::makeRecording(kArrays, std::move(listing));
}

double stampOf(const py::handle& stamp) { return numberOf(stamp, "stamp"); }

std::string pathText(const py::object& path, const char* name) {
  const auto bytes = py::reinterpret_steal<py::object>([&]() -> PyObject* {
    PyObject* encoded = nullptr;  // as the operating system has it, whatever characters it holds
    return PyUnicode_FSConverter(path.ptr(), &encoded) != 0 ? encoded : nullptr;
  }());
  if (bytes) return std::string(py::reinterpret_borrow<py::bytes>(bytes));
  PyErr_Clear();
  throw UsageError(std::string(name) + " is no path: expected a text without null characters");
}

std::vector<std::uint32_t> idsIn(const py::object& labels) {
  if (!py::isinstance<py::array>(labels) && py::isinstance<py::sequence>(labels)) {
    std::set<std::uint32_t> ids;
    for (const py::handle item : labels) {
      const auto found = idsIn(asArray(item, "labels"));
      ids.insert(found.begin(), found.end());
    }
    return {ids.begin(), ids.end()};
  }
  const py::array array = asArray(labels, "labels");
  requireLabels(array, "labels");
  if (array.ndim() != 1)
    throw UsageError("labels has the shape " + shapeText(array) + ", expected (N,)");
  const Column column = columnOf(array, 0);
  std::set<std::uint32_t> ids;
  for (std::size_t i = 0; i < static_cast<std::size_t>(array.shape(0)); ++i)
    ids.insert(static_cast<std::uint32_t>(std::max<std::int64_t>(0, column.at<std::int64_t>(i))));
  return {ids.begin(), ids.end()};
}

LabelSet labelSetOf(const py::object& classes) {
  if (py::isinstance<py::dict>(classes)) {
    const ClassNames& names = ClassNames::shipped();
    LabelSet labels("python");
    for (const auto& [id, name] : classes.cast<py::dict>()) {
      ClassInfo info;
      info.id = classIdOf(id);
      info.name = utf8Of(name, fmt::format("classes[{}]", info.id));
      info.color = distinctColor(info.id);
      const ClassNames::Line* known = names.find(info.name);
      info.role = known ? known->role : Role::object;
      info.kind = known ? known->kind : Kind::other_object;
      info.guessed = true;
      info.unknown = known == nullptr;
      labels.add(info);
    }
    return labels;
  }
  io::InputOptions options;
  options.labels = pathText(classes, "classes");
  return *io::namedLabels(options, ".");
}

py::dict namesOf(const LabelSet& labels) {
  py::dict names;
  for (const auto& [id, info] : labels.classes()) names[py::int_(id)] = info.name;
  return names;
}

Eigen::Isometry3d poseOf(const py::handle& matrix, const std::string& name) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(matrix);
  if (!array) {
    PyErr_Clear();
    throw UsageError(name + " is no array of numbers");
  }
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4)
    throw UsageError(name + " has the shape " + shapeText(array) + ", expected (4, 4)");
  Eigen::Isometry3d T;
  T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(array.data());
  if (!isRigid(T.matrix())) throw UsageError(name + " is no rigid motion");
  return T;
}

std::vector<Eigen::Isometry3d> posesOf(const py::handle& matrices, const std::string& name) {
  if (!py::isinstance<py::sequence>(matrices) && !py::isinstance<py::array>(matrices))
    throw UsageError(name + " is no array (N, 4, 4)");
  if (py::isinstance<py::array>(matrices) &&
      py::reinterpret_borrow<py::array>(matrices).ndim() == 2)
    return {poseOf(matrices, name)};
  std::vector<Eigen::Isometry3d> poses;
  for (const py::handle matrix : py::reinterpret_borrow<py::object>(matrices))
    poses.push_back(poseOf(matrix, fmt::format("{}[{}]", name, poses.size())));
  return poses;
}

py::array_t<double> arrayOf(const std::vector<Eigen::Isometry3d>& poses) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  auto values = array.mutable_unchecked<3>();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column)
        values(static_cast<py::ssize_t>(i), row, column) = poses[i].matrix()(row, column);
    }
  }
  return array;
}

py::array pointsOf(std::shared_ptr<const LabelledCloud> cloud) {
  const auto count = static_cast<py::ssize_t>(cloud->size());
  if (cloud->origin.isZero(0)) {
    const float* first = count > 0 ? &cloud->points[0].x : nullptr;
    return viewOf(first, {count, 3}, {sizeof(Point), sizeof(float)}, std::move(cloud));
  }
  py::array_t<double> array({count, py::ssize_t{3}});
  auto values = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p = cloud->position(static_cast<std::size_t>(i));
    for (int axis = 0; axis < 3; ++axis) values(i, axis) = p[axis];
  }
  array.attr("flags").attr("writeable") = false;
  return std::move(array);
}

py::array labelsOf(std::shared_ptr<const LabelledCloud> cloud) {
  const auto count = static_cast<py::ssize_t>(cloud->size());
  const std::uint32_t* first = count > 0 ? &cloud->points[0].label : nullptr;
  return viewOf(first, {count}, {sizeof(Point)}, std::move(cloud));
}

py::array_t<std::uint32_t> pairsOf(const std::vector<Correspondence>& correspondences) {
  py::array_t<std::uint32_t> array(
      {static_cast<py::ssize_t>(correspondences.size()), py::ssize_t{2}});
  auto values = array.mutable_unchecked<2>();
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    values(static_cast<py::ssize_t>(i), 0) = correspondences[i].query;
    values(static_cast<py::ssize_t>(i), 1) = correspondences[i].map;
  }
  return array;
}

}  // namespace xview::python
