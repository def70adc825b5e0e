// SPDX-License-Identifier: BSD-3-Clause
#include "match/wide_query.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace xview {
namespace {

struct Square {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double samples = 0;
};

/// Means of the samples in squares of `side_m`, row by row.
std::vector<Eigen::Vector2d> meansOfSquares(const std::vector<PlanQuery::Sample>& samples,
                                            double side_m) {
  std::map<std::pair<int, int>, Square> squares;
  for (const PlanQuery::Sample& s : samples) {
    Square& square = squares[{static_cast<int>(std::floor(s.y / side_m)),
                              static_cast<int>(std::floor(s.x / side_m))}];
    square.sum += Eigen::Vector2d(s.x, s.y);
    square.samples += 1;
  }
  std::vector<Eigen::Vector2d> means;
  for (const auto& [place, square] : squares) means.push_back(square.sum / square.samples);
  return means;
}

bool isWithin(const PlanQuery::Sample& s, const Eigen::Vector2d& centre, double radius_m) {
  return (Eigen::Vector2d(s.x, s.y) - centre).squaredNorm() <= radius_m * radius_m;
}

}  // namespace

QueryPart partAround(const std::vector<PlanQuery::Sample>& samples, const Eigen::Vector2d& centre,
                     double radius_m) {
  QueryPart part{centre, {}};
  for (PlanQuery::Sample s : samples) {
    if (!isWithin(s, centre, radius_m)) continue;
    s.x -= static_cast<float>(centre.x());
    s.y -= static_cast<float>(centre.y());
    part.samples.push_back(s);
  }
  return part;
}

QueryPart densestPart(const std::vector<PlanQuery::Sample>& samples, double radius_m) {
  Eigen::Vector2d best = Eigen::Vector2d::Zero();
  std::ptrdiff_t most = -1;
  for (const Eigen::Vector2d& mean : meansOfSquares(samples, radius_m / 2)) {
    const auto count = std::count_if(samples.begin(), samples.end(),
                                     [&](const auto& s) { return isWithin(s, mean, radius_m); });
    if (count <= most) continue;
    most = count;
    best = mean;
  }
  return partAround(samples, best, radius_m);
}

PlacePrior priorOfPart(PlacePrior prior, const QueryPart& part) {
  if (prior.near) prior.near->radius += part.offset.norm();
  return prior;
}

}  // namespace xview
