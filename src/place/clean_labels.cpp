// SPDX-License-Identifier: BSD-3-Clause
#include "place/clean_labels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "base/cells.h"
#include "xview/base/error.h"

namespace xview {
namespace {

/// First pixel at or after x that differs from `value`; four pixels at a time.
int endOfRun(const std::uint16_t* row, int x, int width, std::uint16_t value) {
  const std::uint64_t four_values = value * 0x0001000100010001ull;
  while (x + 4 <= width) {
    std::uint64_t four;
    std::memcpy(&four, row + x, sizeof four);
    if (four != four_values) break;
    x += 4;
  }
  while (x < width && row[x] == value) ++x;
  return x;
}

class RegionFinder {
 public:
  RegionFinder(const LabelImage& labels, const LabelImage& instances)
      : labels_(labels), instances_(instances) {}

  LabelRegions find() {
    std::size_t above = 0, here = 0;  // first runs of the last row and of this one
    for (int y = 0; y < labels_.height; ++y) {
      appendRuns(y);
      connectRows(above, here);
      above = here;
      here = runs_.size();
    }
    return gather();
  }

 private:
  void appendRuns(int y) {
    const std::uint16_t* label_row = &labels_.at(0, y);
    const std::uint16_t* instance_row = instances_.empty() ? nullptr : &instances_.at(0, y);
    for (int x = 0; x < labels_.width;) {
      int end = endOfRun(label_row, x, labels_.width, label_row[x]);
      if (instance_row) end = endOfRun(instance_row, x, end, instance_row[x]);
      sets_.add();
      runs_.push_back({y, x, end, 0});
      x = end;
    }
  }

  bool isSame(const LabelRun& a, const LabelRun& b) const {
    return labels_.at(a.begin, a.row) == labels_.at(b.begin, b.row) &&
           (instances_.empty() || instances_.at(a.begin, a.row) == instances_.at(b.begin, b.row));
  }

  /// Joins the runs [above, here) of one row with those from `here` on of the next; they touch also
  /// across corners.
  void connectRows(std::size_t above, std::size_t here) {
    std::size_t first = above;
    for (std::size_t i = here; i < runs_.size(); ++i) {
      while (first < here && runs_[first].end < runs_[i].begin) ++first;
      for (std::size_t j = first; j < here && runs_[j].begin <= runs_[i].end; ++j) {
        if (isSame(runs_[i], runs_[j])) {
          sets_.unite(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
        }
      }
    }
  }

  LabelRegions gather() {
    LabelRegions result;
    std::vector<std::uint32_t> region_of_root(runs_.size());
    for (std::uint32_t i = 0; i < runs_.size(); ++i) {
      LabelRun& run = runs_[i];
      const std::uint32_t root = sets_.find(i);
      if (root == i) {
        region_of_root[i] = static_cast<std::uint32_t>(result.regions.size());
        result.regions.push_back(
            {labels_.at(run.begin, run.row),
             instances_.empty() ? std::uint16_t{0} : instances_.at(run.begin, run.row), 0,
             run.begin, run.row, run.end - 1, run.row});
      }
      run.region = region_of_root[root];
      LabelRegion& region = result.regions[run.region];
      region.pixels += run.end - run.begin;
      region.min_x = std::min(region.min_x, run.begin);
      region.max_x = std::max(region.max_x, run.end - 1);
      region.max_y = run.row;
    }
    result.runs = std::move(runs_);
    return result;
  }

  const LabelImage& labels_;
  const LabelImage& instances_;
  std::vector<LabelRun> runs_;
  DisjointSets sets_;  ///< of runs; named by the first run of a region
};

// Half size of the dilate/erode element that fills what specks leave (paper: 4 px).
constexpr int kClosing_px = 4;
constexpr double kPaperWidth_px = 1280;  ///< of the images that boundary_px speaks of
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
  constexpr std::uint32_t kIds = 1 << 16;  // that a label image can hold
  for (std::uint32_t i = 0; i < kIds; ++i) {
    const auto id = static_cast<std::uint16_t>(kIds - i);  // 0, 65535, 65534, ...
    if (set.role(id) == Role::ignored) return id;
  }
  throw Error("label set '" + set.name() + "'",
              "all 65536 ids that a label image can hold are classes, expected one of them to be "
              "unused or of role ignored, for pixels without a class; or leave labels as they are "
              "(--clean.enabled false)");
}

}  // namespace

LabelRegions findLabelRegions(const LabelImage& labels, const LabelImage& instances) {
  return RegionFinder(labels, instances).find();
}

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
    const int reach_px = std::max(
        1, static_cast<int>(std::lround(options.boundary_px * labels.width / kPaperWidth_px)));
    for (const ClassArea& area : order) closeClass(before, area, reach_px, cv::Mat(), after);
  }
  return result;
}

}  // namespace xview
