// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/clean_labels.h"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <vector>

#include "label_regions.h"

namespace xview {
namespace {

/// A class in the image: where and how much.
struct ClassArea {
  std::uint16_t label = 0;
  int pixels = 0;
  int min_x = 0, min_y = 0, max_x = 0, max_y = 0;  ///< inclusive
};

int speckLimit(Kind kind, int min_speck_px) {
  // A lamp post far away is small and still the best thing to see.
  return isPoleLike(kind) ? min_speck_px / 4 : min_speck_px;
}

void dropSpecks(LabelImage& labels, LabelRegions& found, const LabelSet& set, int min_speck_px) {
  const auto is_speck = [&](const LabelRun& run) {
    const LabelRegion& region = found.regions[run.region];
    return region.pixels < speckLimit(set.kind(region.label), min_speck_px);
  };
  for (const LabelRun& run : found.runs) {
    if (!is_speck(run)) continue;
    std::fill(&labels.at(run.begin, run.row),
              &labels.at(run.begin, run.row) + (run.end - run.begin), std::uint16_t{0});
  }
  found.regions.erase(std::remove_if(found.regions.begin(), found.regions.end(),
                                     [&](const LabelRegion& region) {
                                       return region.pixels <
                                              speckLimit(set.kind(region.label), min_speck_px);
                                     }),
                      found.regions.end());
}

/// Surfaces before objects, large before small: what comes later wins.
std::vector<ClassArea> closingOrder(const std::vector<LabelRegion>& regions, const LabelSet& set) {
  std::map<std::uint16_t, ClassArea> areas;
  for (const LabelRegion& r : regions) {
    if (r.label == 0) continue;
    const auto [place, is_new] = areas.try_emplace(r.label);
    ClassArea& area = place->second;
    if (is_new) area = {r.label, 0, r.min_x, r.min_y, r.max_x, r.max_y};
    area.pixels += r.pixels;
    area.min_x = std::min(area.min_x, r.min_x);
    area.min_y = std::min(area.min_y, r.min_y);
    area.max_x = std::max(area.max_x, r.max_x);
    area.max_y = std::max(area.max_y, r.max_y);
  }
  std::vector<ClassArea> order;
  for (const auto& [label, area] : areas) order.push_back(area);
  const auto rank = [&](const ClassArea& area) {
    const Role role = set.role(area.label);
    const int priority = role == Role::ignored ? 0 : role == Role::surface ? 1 : 2;
    return std::make_tuple(priority, -area.pixels, area.label);
  };
  std::sort(order.begin(), order.end(),
            [&](const ClassArea& a, const ClassArea& b) { return rank(a) < rank(b); });
  return order;
}

/// Closes one class inside its bounding box.
void closeClass(const LabelImage& before, const ClassArea& area, int closing_px,
                LabelImage& after) {
  const cv::Rect image(0, 0, before.width, before.height);
  const cv::Rect box =
      cv::Rect(area.min_x, area.min_y, area.max_x - area.min_x + 1, area.max_y - area.min_y + 1);
  const cv::Mat in(before.height, before.width, CV_16UC1,
                   const_cast<std::uint16_t*>(before.pixels.data()));
  cv::Mat out(after.height, after.width, CV_16UC1, after.pixels.data());
  cv::Mat mask = in(box & image) == area.label;
  const int side = 2 * closing_px + 1;
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_RECT, cv::Size(side, side)));
  out(box & image).setTo(area.label, mask);
}

}  // namespace

LabelImage cleanLabels(const LabelImage& labels, const LabelSet& set, const CleanOptions& options) {
  if (!options.enabled || labels.empty()) return labels;
  LabelRegions found = findLabelRegions(labels);
  LabelImage dropped = labels;
  dropSpecks(dropped, found, set, options.min_speck_px);
  if (options.closing_px == 0) return dropped;
  LabelImage closed = dropped;
  for (const ClassArea& area : closingOrder(found.regions, set)) {
    closeClass(dropped, area, options.closing_px, closed);
  }
  return closed;
}

}  // namespace xview
