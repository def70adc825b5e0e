// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/clean_labels.h"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <vector>

#include "graph/label_regions.h"

namespace xview::graph {
namespace {

// Half size of the dilate/erode element that fills what specks leave (paper: 4 px).
constexpr int kClosing_px = 4;
// Smaller connected regions are specks [px]: a network's errors, not things.
constexpr int kMinSpeck_px = 12;

/// A class in the image: how much of it, and where.
struct ClassArea {
  std::uint16_t label = 0;
  int pixels = 0;
  int min_x = 0, min_y = 0, max_x = 0, max_y = 0;  ///< bounding box, inclusive
};

bool isSpeck(const LabelRegion& region, const LabelSet& set) {
  // A lamp post far away is small and still the best thing to see.
  const int limit = isPoleLike(set.kind(region.label)) ? kMinSpeck_px / 4 : kMinSpeck_px;
  return region.pixels < limit;
}

/// The classes of the regions that are no specks, surfaces before objects and large before small:
/// what comes later wins.
std::vector<ClassArea> closingOrder(const std::vector<LabelRegion>& regions,
                                    const std::vector<bool>& is_speck, const LabelSet& set) {
  std::map<std::uint16_t, ClassArea> areas;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const LabelRegion& r = regions[i];
    if (is_speck[i]) continue;
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

/// The image as OpenCV sees it, without a copy.
cv::Mat matrixOf(const LabelImage& image) {
  return {image.height, image.width, CV_16UC1, const_cast<std::uint16_t*>(image.pixels.data())};
}

/// Closes one class of `before`; where `allowed` (empty: everywhere) it is written to `after`.
void closeClass(const cv::Mat& before, const ClassArea& area, int half_px, const cv::Mat& allowed,
                cv::Mat& after) {
  // The dilated class reaches half_px beyond its bounding box; the erosion has to see where it
  // ends, because it takes what is outside for set. At the border of the image that is wanted.
  const int reach = half_px + 1;
  const cv::Rect box = cv::Rect(cv::Point(area.min_x - reach, area.min_y - reach),
                                cv::Point(area.max_x + reach + 1, area.max_y + reach + 1)) &
                       cv::Rect(cv::Point(), before.size());
  const cv::Size element(2 * half_px + 1, 2 * half_px + 1);
  cv::Mat mask = before(box) == area.label;
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, element));
  if (!allowed.empty()) mask &= allowed(box);
  after(box).setTo(area.label, mask);
}

/// 0, unless the set uses that id for a class that matters: then the highest unused one.
std::uint16_t unlabelledId(const LabelSet& set) {
  std::uint16_t id = 0;
  while (set.role(id) != Role::ignored) --id;
  return id;
}

}  // namespace

LabelImage cleanLabels(const LabelImage& labels, const LabelSet& set, const CleanOptions& options) {
  if (!options.enabled || labels.empty()) return labels;
  const LabelRegions found = findLabelRegions(labels);
  std::vector<bool> is_speck;
  for (const LabelRegion& region : found.regions) is_speck.push_back(isSpeck(region, set));

  LabelImage result = labels;
  cv::Mat after = matrixOf(result);
  cv::Mat specks = cv::Mat::zeros(after.size(), CV_8UC1);
  const std::uint16_t unlabelled = unlabelledId(set);
  for (const LabelRun& run : found.runs) {
    if (!is_speck[run.region]) continue;
    const cv::Rect pixels(run.begin, run.row, run.end - run.begin, 1);
    after(pixels).setTo(unlabelled);
    specks(pixels).setTo(255);
  }

  const std::vector<ClassArea> order = closingOrder(found.regions, is_speck, set);
  const bool has_specks = std::find(is_speck.begin(), is_speck.end(), true) != is_speck.end();
  if (has_specks) {
    const cv::Mat before = after.clone();
    for (const ClassArea& area : order) closeClass(before, area, kClosing_px, specks, after);
  }
  if (options.boundary_px > 0) {
    const cv::Mat before = after.clone();
    for (const ClassArea& area : order) {
      closeClass(before, area, options.boundary_px, cv::Mat(), after);
    }
  }
  return result;
}

}  // namespace xview::graph
