// SPDX-License-Identifier: BSD-3-Clause
#include "graph/label_regions.h"

#include <algorithm>
#include <cstring>

#include "graph/disjoint_sets.h"

namespace xview::graph {
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

}  // namespace

LabelRegions findLabelRegions(const LabelImage& labels, const LabelImage& instances) {
  return RegionFinder(labels, instances).find();
}

}  // namespace xview::graph
