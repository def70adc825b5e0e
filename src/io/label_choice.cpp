// SPDX-License-Identifier: BSD-3-Clause
#include "label_choice.h"

#include <algorithm>

#include "xview/io/label_files.h"

namespace xview {
namespace {

/// A set fits if it knows this share of the points; networks and exporters add a few odd ids.
constexpr double kKnownShare = 0.9;

std::uint64_t pointsOf(const LabelCounts& counts, std::initializer_list<std::uint32_t> ids) {
  std::uint64_t points = 0;
  for (const std::uint32_t id : ids) {
    const auto found = counts.find(id);
    if (found != counts.end()) points += found->second;
  }
  return points;
}

/// Share of the points whose id the set knows.
double knownShare(const LabelCounts& counts, const LabelSet& labels) {
  std::uint64_t known = 0, all = 0;
  for (const auto& [id, points] : counts) {
    all += points;
    if (labels.find(id)) known += points;
  }
  return all > 0 ? static_cast<double>(known) / static_cast<double>(all) : 0;
}

/// The raw ids of SemanticKITTI leave gaps and go up to 259; no other usual data set has several of
/// those above 30 and none in the gaps.
bool areRawSemanticKitti(const LabelCounts& counts, const LabelSet& raw) {
  constexpr std::uint32_t kAboveOthers = 30;
  constexpr std::ptrdiff_t kSeveral = 5;
  const auto above = std::count_if(counts.begin(), counts.end(), [&](const auto& entry) {
    return entry.first > kAboveOthers && raw.find(entry.first);
  });
  return above >= kSeveral && knownShare(counts, raw) >= 0.999;
}

bool isSemanticKitti(const LabelSet& labels) {
  return labels.name().rfind("semantic_kitti", 0) == 0;
}

}  // namespace

LabelSet labelsOfIds(const LabelCounts& counts, const InputOptions& options) {
  if (options.unnamed && knownShare(counts, *options.unnamed) >= kKnownShare)
    return *options.unnamed;
  LabelSet semantic_kitti = shippedLabelSet("semantic_kitti");
  if (areRawSemanticKitti(counts, semantic_kitti)) return semantic_kitti;
  std::vector<std::uint32_t> ids;
  for (const auto& [id, points] : counts) ids.push_back(id);
  return genericLabelSet(ids);
}

LabelSet semanticKittiLabels(const LabelCounts& counts, const InputOptions& options) {
  const bool training_ids = std::all_of(counts.begin(), counts.end(), [](const auto& entry) {
    return entry.first <= 19 || entry.first == 255;
  });
  if (!training_ids) {
    LabelSet raw = shippedLabelSet("semantic_kitti");
    return knownShare(counts, raw) >= kKnownShare ? raw : labelsOfIds(counts, options);
  }
  if (options.unnamed && !isSemanticKitti(*options.unnamed) &&
      knownShare(counts, *options.unnamed) >= kKnownShare)
    return *options.unnamed;
  if (counts.count(19) > 0) return shippedLabelSet("semantic_kitti_train_1");
  if (counts.count(255) > 0) return shippedLabelSet("semantic_kitti_train_0");
  // Road, sidewalk, building and vegetation in either counting.
  const std::uint64_t from_1 = pointsOf(counts, {9, 11, 13, 15});
  const std::uint64_t from_0 = pointsOf(counts, {8, 10, 12, 14});
  return shippedLabelSet(from_1 >= from_0 ? "semantic_kitti_train_1" : "semantic_kitti_train_0");
}

}  // namespace xview
