// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/semantic_place.h"

#include <cmath>

#include "base/user_text.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr double kTownSpacing_m = 4;  ///< between neighbouring things of a town
constexpr double kLeastSpacing_m = 0.01, kMostSpacing_m = 1000;

struct NamedSize {
  const char* name;
  double size;
};
constexpr NamedSize kSizes[] = {{"town", kTownScale}, {"room", kRoomScale}, {"desk", kDeskScale}};

}  // namespace

std::optional<double> parseSize(const std::string& text) {
  if (text.empty() || text == "auto") return std::nullopt;
  for (const NamedSize& known : kSizes) {
    if (text == known.name) return known.size;
  }
  const double spacing_m = numberFrom<double>(text).value_or(0);
  if (!(spacing_m >= kLeastSpacing_m && spacing_m <= kMostSpacing_m)) {
    throw UsageError("size = " + text +
                     ", must be auto, town, room, desk, or the typical spacing of neighbouring "
                     "things in [0.01, 1000] m");
  }
  return std::exp2(std::round(std::log2(spacing_m / kTownSpacing_m)));
}

std::string sizeText(double size) {
  for (const NamedSize& known : kSizes) {
    if (size == known.size) return known.name;
  }
  return numberText(size * kTownSpacing_m);
}

void requireSize(const std::string&, const std::string& text) { parseSize(text); }

void scaleLengths(double factor, SemanticGraph& graph) {
  for (Vertex& v : graph.vertices) {
    v.position *= factor;
    v.extent *= factor;
    v.sigma_m *= factor;
  }
  graph.edge_radius_m *= factor;
}

void scaleLengths(double factor, LabelledCloud& cloud) {
  const auto f = static_cast<float>(factor);
  cloud.origin *= factor;
  for (Point& p : cloud.points) {
    p.getVector3fMap() *= f;
    p.sigma *= f;
  }
}

void scaleLengths(double factor, BevGrid& bev) {
  if (factor == 1) return;
  const auto f = static_cast<float>(factor);
  for (double* length : {&bev.cell_m, &bev.origin_x, &bev.origin_y, &bev.origin_z})
    *length *= factor;
  for (auto& channel : bev.samples) {
    for (BevSample& s : channel) s = {f * s.x, f * s.y, f * s.z};
  }
  for (GroundCell& cell : bev.known) cell.z *= f;
}

void scaleLengths(double factor, Eigen::Isometry3d& T) { T.translation() *= factor; }

void scaleLengths(double factor, Place& place) {
  scaleLengths(factor, place.graph);
  scaleLengths(factor, place.bev);
  scaleLengths(factor, place.cloud);
  for (Eigen::Isometry3d& T : place.poses) scaleLengths(factor, T);
}

void scaleLengths(double factor, Frame& frame) {
  const auto f = static_cast<float>(factor);
  scaleLengths(factor, frame.T_odom_sensor);
  for (float& depth : frame.depth.pixels) depth *= f;
  scaleLengths(factor, frame.cloud);
}

void scaleLengths(double factor, Localization& answer) {
  scaleLengths(factor, answer.T_map_query);
  scaleLengths(factor, answer.T_map_sensor);
  answer.covariance.topRows<3>() *= factor;
  answer.covariance.leftCols<3>() *= factor;
  for (Hypothesis& h : answer.hypotheses) scaleLengths(factor, h.T_map_query);
  for (Eigen::Isometry3d& T : answer.trajectory) scaleLengths(factor, T);
}

}  // namespace xview
