// SPDX-License-Identifier: BSD-3-Clause
// Whether a .ply holds things or samples of surfaces.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "base/median.h"
#include "layouts.h"
#include "point_table.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

/// Things of a town are farther apart than the first, samples of any sensor closer than the last;
/// things of a desk lie between [m].
constexpr double kObjects_m = 1.0, kSamples_m = 0.1;
/// Vertices that lie less than kObjects_m apart and are more than this are samples.
constexpr std::size_t kMostCrowded = 20000;
constexpr std::size_t kFirstVertices = 4096;  ///< probes are chosen among them, spread evenly
constexpr std::size_t kProbes = 256;

struct Probe {
  Eigen::Vector3d position;
  std::uint32_t label = 0;
  std::size_t number = 0;         ///< of the vertex, from 1
  double nearest_m = kObjects_m;  ///< other vertex; at most this far
  bool among_its_like = false;    ///< that one is of the same class
};

/// Thrown out of the reader when enough is known.
struct KnownEnough {};

/// Finds the nearest neighbours of a few vertices while all of them pass by, with no more of them
/// in memory than the first.
class Neighbourhoods {
 public:
  void add(const Eigen::Vector3d& p, std::uint32_t label, std::uint32_t instance) {
    const Probe vertex{p, label, ++count_};
    if (count_ > kFirstVertices) return meet(vertex);
    if (instance != 0) instances_.insert(instance);
    first_.push_back(vertex);
    if (count_ == kFirstVertices) chooseProbes();
  }

  void end() {
    if (probes_.empty()) chooseProbes();
  }

  /// Nearly every vertex is an instance of its own.
  bool areInstances() const {
    return static_cast<double>(instances_.size()) >=
           0.95 * static_cast<double>(std::min(count_, kFirstVertices));
  }
  double spacing_m() const {
    std::vector<double> nearest;
    for (const Probe& probe : probes_) nearest.push_back(probe.nearest_m);
    return nearest.empty() ? 0 : medianOf(std::move(nearest));
  }
  double shareAmongTheirLike() const {
    const auto alike = std::count_if(probes_.begin(), probes_.end(),
                                     [](const Probe& p) { return p.among_its_like; });
    return static_cast<double>(alike) /
           static_cast<double>(std::max<std::size_t>(1, probes_.size()));
  }
  std::size_t count() const { return count_; }

 private:
  /// Strays are far from everything, and tell nothing of the others.
  void leaveOutStrays() {
    constexpr double kNear_m = 1000, kApart = 60;  // times the distance of half of the vertices
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    std::vector<double> values;
    for (int axis = 0; axis < 3 && !first_.empty(); ++axis) {
      values.clear();
      for (const Probe& vertex : first_) values.push_back(vertex.position[axis]);
      middle[axis] = quantileOf(values, 0.5);
    }
    const auto away_m = [&](const Probe& p) { return (p.position - middle).cwiseAbs().maxCoeff(); };
    values.clear();
    for (const Probe& vertex : first_) values.push_back(away_m(vertex));
    const double most_m = values.empty() ? 0 : std::max(kNear_m, kApart * quantileOf(values, 0.5));
    first_.erase(std::remove_if(first_.begin(), first_.end(),
                                [&](const Probe& vertex) { return away_m(vertex) > most_m; }),
                 first_.end());
  }

  void chooseProbes() {
    leaveOutStrays();
    const std::size_t step = std::max<std::size_t>(1, first_.size() / kProbes);
    for (std::size_t i = 0; i < first_.size(); i += step) probes_.push_back(first_[i]);
    for (const Probe& vertex : first_) meet(vertex);
  }

  void meet(const Probe& vertex) {
    for (Probe& probe : probes_) {
      const double distance2 = (vertex.position - probe.position).squaredNorm();
      if (distance2 > kObjects_m * kObjects_m || probe.number == vertex.number) continue;
      const double distance_m = std::sqrt(distance2);
      if (!(distance_m < probe.nearest_m)) continue;
      close_ += probe.nearest_m > kSamples_m && distance_m <= kSamples_m;
      probe.nearest_m = distance_m;
      probe.among_its_like = vertex.label == probe.label;
    }
    // Neighbours only come closer, so these can be nothing but samples.
    if (4 * close_ > 3 * probes_.size() && count_ >= kFirstVertices && !areInstances())
      throw KnownEnough();
  }

  std::size_t count_ = 0, close_ = 0;
  std::unordered_set<std::uint32_t> instances_;  ///< of the first vertices
  std::vector<Probe> first_, probes_;
};

Neighbourhoods lookAt(InputFile& file, const FileLayout& layout, const Element& vertices,
                      const IdColumns& ids) {
  ChosenColumns columns(vertices, file);
  const auto label = columns.add(ids.label), instance = columns.add(ids.instance);
  Neighbourhoods found;
  try {
    readTable(
        file, layout, vertices, columns.all(), [&](const double* values, const RowPlace& place) {
          const Eigen::Vector3d p(values[0], values[1], values[2]);
          if (p.allFinite())
            found.add(p, columns.id(label, values, place), columns.id(instance, values, place));
        });
    found.end();
  } catch (const KnownEnough&) {
  }
  return found;
}

}  // namespace

bool holdsGraph(const std::string& path, const InputOptions& options, std::string* guess) {
  constexpr double kAmongTheirLike = 0.8;
  InputFile file(path);
  const FileLayout layout = readPlyHeader(file);
  const Element* vertices = layout.findElement("vertex");
  if (!vertices) throw Error(path, "no `element vertex` in the header");
  const auto has = [&](const char* name) {
    return std::any_of(vertices->columns.begin(), vertices->columns.end(),
                       [&](const Column& column) { return column.name == name; });
  };
  const Element* faces = layout.findElement("face");
  if (has("observations") || has("extent_x")) return true;
  if (!has("label") || (faces && faces->rows > 0)) return false;
  if (layout.findElement("edge")) return true;
  if (options.labels == "shapes") return false;  // its points are to tell their classes
  checkSize(file, layout);
  const Neighbourhoods around = lookAt(file, layout, *vertices, findIdColumns(*vertices, {}, file));
  if (around.count() < 2) return has("sigma");  // nothing else to go by
  const double spacing_m = around.spacing_m();
  const bool instances = around.areInstances();
  const bool crowded =
      spacing_m <= kSamples_m || (spacing_m < kObjects_m && around.count() > kMostCrowded);
  if (crowded && !instances) return false;
  const bool objects =
      spacing_m >= kObjects_m || instances || around.shareAmongTheirLike() < kAmongTheirLike;
  if (guess) {
    const std::string spacing = spacing_m >= kObjects_m
                                    ? "more than 1 m"
                                    : "about " + std::to_string(spacing_m).substr(0, 4) + " m";
    *guess = fmt::format("its vertices are {} apart{}", spacing,
                         objects ? ", so they are taken for things; --input-kind cloud reads them "
                                   "as samples of surfaces"
                                 : " among their like, so they are taken for samples of surfaces; "
                                   "--input-kind graph reads them as things");
  }
  return objects;
}

}  // namespace xview::io
