// SPDX-License-Identifier: BSD-3-Clause
// LAS files as the ASPRS specifies them (LAS 1.4 R15); see las_header.cpp.
#include "las_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "point_table.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

constexpr std::size_t kHeaderBytes = 375, kClassesHead = 54;  ///< bytes of version 1.4
constexpr std::uint8_t kFormat = 7;
constexpr std::uint16_t kRecord = 36;
constexpr double kStep_m = 1e-3;

template <class T>
void put(std::string& bytes, std::size_t position, T value) {
  std::memcpy(bytes.data() + position, &value, sizeof(T));
}
template <class T>
T get(const std::string& bytes, std::size_t position) {
  T value;
  std::memcpy(&value, bytes.data() + position, sizeof(T));
  return value;
}
void putText(std::string& bytes, std::size_t position, const char* text) {
  std::memcpy(bytes.data() + position, text, std::strlen(text));
}

/// Integers that a scale and an offset make lengths of `unit_m`, those of the file.
class Steps {
 public:
  Steps(std::string path, const Eigen::AlignedBox3d& box, const Eigen::Array3d& step_m,
        const Eigen::Array3d& unit_m = Eigen::Array3d::Ones())
      : path_(std::move(path)), step_m_(step_m), unit_m_(unit_m) {
    if (!box.isEmpty()) offset_m_ = box.center().array().floor();
  }

  void write(std::string& header, const Eigen::AlignedBox3d& box) const {
    for (int axis = 0; axis < 3; ++axis) {
      const auto place = static_cast<std::size_t>(axis) * sizeof(double);
      const double unit_m = unit_m_[axis];
      put(header, 131 + place, step_m_[axis] / unit_m);
      put(header, 155 + place, offset_m_[axis] / unit_m);
      put(header, 179 + 2 * place, box.isEmpty() ? 0 : box.max()[axis] / unit_m);
      put(header, 187 + 2 * place, box.isEmpty() ? 0 : box.min()[axis] / unit_m);
    }
  }
  void write(std::string& row, const Eigen::Vector3d& position) const {
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = std::round((position[axis] - offset_m_[axis]) / step_m_[axis]);
      if (!(std::abs(steps) <= std::numeric_limits<std::int32_t>::max()))
        throw Error(path_,
                    "cannot be written: its points are too far apart for the integers of "
                    "LAS; write .ply");
      put(row, static_cast<std::size_t>(axis) * 4, static_cast<std::int32_t>(steps));
    }
  }

 private:
  std::string path_;
  Eigen::Array3d step_m_, unit_m_, offset_m_ = Eigen::Array3d::Zero();
};

/// A variable record with the lines that name classes.
std::string recordOf(const std::string& classes) {
  std::string record(kClassesHead, '\0');
  putText(record, 2, kLasUser);
  put(record, 18, kLasClasses);
  put(record, 20, static_cast<std::uint16_t>(classes.size()));
  putText(record, 22, "names of classes");
  return record + classes;
}

}  // namespace

void writeLas(const std::string& path, const LasPoints& points, const std::string& classes) {
  if (classes.size() > std::numeric_limits<std::uint16_t>::max())
    throw Error(path, "cannot be written: the names of its classes take more than 65535 bytes");
  Eigen::AlignedBox3d box;
  std::uint64_t count = 0;
  std::array<std::uint64_t, 15> of_return{};
  points([&](const LasPoint& p) {
    if (!p.position.allFinite()) return;
    if (p.label > 255)
      throw Error(path, "cannot be written: LAS has classes from 0 to 255, found " +
                            std::to_string(p.label) + "; write .ply");
    box.extend(p.position);
    ++of_return[std::clamp<std::size_t>(p.return_number, 1, 15) - 1];
    ++count;
  });

  const std::string records = classes.empty() ? std::string() : recordOf(classes);
  std::string header(kHeaderBytes, '\0');
  putText(header, 0, "LASF");
  put<std::uint16_t>(header, 6, 16);  // a coordinate system would be text
  put<std::uint8_t>(header, 24, 1);
  put<std::uint8_t>(header, 25, 4);
  putText(header, 26, "OTHER");
  putText(header, 58, "xview");
  put(header, 94, static_cast<std::uint16_t>(kHeaderBytes));
  put(header, 96, static_cast<std::uint32_t>(kHeaderBytes + records.size()));
  put<std::uint32_t>(header, 100, records.empty() ? 0 : 1);
  put(header, 104, kFormat);
  put(header, 105, kRecord);
  const Steps steps(path, box, Eigen::Array3d::Constant(kStep_m));
  steps.write(header, box);
  put(header, 247, count);
  put(header, 255, of_return);

  AtomicFile file(path);
  file.write(header + records);
  std::string row(kRecord, '\0');
  points([&](const LasPoint& p) {
    if (!p.position.allFinite()) return;
    steps.write(row, p.position);
    put(row, 12, p.intensity);
    put(row, 14, static_cast<std::uint8_t>((p.return_number & 15) | p.returns << 4));
    put(row, 16, static_cast<std::uint8_t>(p.label));
    put(row, 20, p.source);
    put(row, 22, p.gps_time);
    put(row, 30, p.color);
    file.write(row);
  });
  file.commit();
}

void copyLas(const std::string& from, const std::string& to, const Eigen::Affine3d& moved) {
  InputFile file(from);
  const FileLayout layout = readLasHeader(file);
  checkSize(file, layout);
  const Element& points = layout.elements.front();
  std::string header(static_cast<std::size_t>(file.position()), '\0'),
      row(static_cast<std::size_t>(points.rowBytes()), '\0');
  const std::uint64_t begin = file.position();
  const auto forRows = [&](const auto& visit) {
    file.seek(begin);
    for (std::uint64_t i = 0; i < points.rows; ++i) {
      file.readBytes(row.data(), row.size());
      const Eigen::Array3d at(get<std::int32_t>(row, 0), get<std::int32_t>(row, 4),
                              get<std::int32_t>(row, 8));
      visit(moved * (at * layout.scale + layout.offset).matrix());
    }
  };
  Eigen::AlignedBox3d box;
  forRows([&](const Eigen::Vector3d& position) { box.extend(position); });
  file.seek(0);
  file.readBytes(header.data(), header.size());
  // Axes may be turned into one another, and lengths into metres.
  const double scale = std::cbrt(moved.linear().determinant());
  Eigen::Array3d step_m = layout.scale * (std::abs(scale - 1) < 1e-9 ? 1 : scale);
  if (!moved.linear().isDiagonal()) step_m.setConstant(step_m.minCoeff());
  const Steps steps(to, box, step_m, layout.unit_m);
  steps.write(header, box);

  AtomicFile copy(to);
  copy.write(header);
  forRows([&](const Eigen::Vector3d& position) {
    steps.write(row, position);
    copy.write(row);
  });
  for (std::string rest; file.remaining() > 0; copy.write(rest)) {  // waveforms, records
    rest.resize(static_cast<std::size_t>(std::min<std::uint64_t>(file.remaining(), 1 << 20)));
    file.readBytes(rest.data(), rest.size());
  }
  copy.commit();
}

}  // namespace xview::io
