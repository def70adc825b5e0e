// SPDX-License-Identifier: BSD-3-Clause
#include "place/recordings_in_one_set.h"

#include <numeric>

#include "place/measure_size.h"
#include "place/raw_recording.h"
#include "xview/base/error.h"
#include "xview/place_builder.h"

namespace xview {
namespace {

/// The recording in the classes of a map.
std::unique_ptr<const FrameSource> inClassesOf(const LabelSet& labels, const FrameSource& source) {
  return std::make_unique<TranslatedRecording>(
      source, requireCommonClasses(source.labels(), source.name(), labels));
}

}  // namespace

LabelMatch requireCommonClasses(const LabelSet& addition, const std::string& name,
                                const LabelSet& map) {
  LabelMatch match(addition, map);
  if (!match.isHopeless()) return match;
  throw Error(name, "none of its classes (label set '" + addition.name() +
                        "') is among those of the map ('" + map.name() +
                        "'); name them with a label set");
}

RecordingsInOneSet::RecordingsInOneSet(const std::vector<const FrameSource*>& sources,
                                       const Options& given)
    : options_(given) {
  if (sources.empty()) throw UsageError("a map needs at least one recording");
  std::vector<const FrameSource*> classified;
  for (const FrameSource* source : sources) {
    if (source == nullptr) throw UsageError("a recording of a map is null");
    classified_.push_back(withClasses(*source, given));
    classified.push_back(classified_.back().get());
  }
  options_.size = sizeText(sizeFor(given, classified));
  for (const FrameSource* source : classified) {
    in_one_set_.push_back(inClassesOf(classified[0]->labels(), *source));
    requireGraphSpace(options_, source->sensor(), source->name());
  }
}

std::size_t RecordingsInOneSet::frames() const {
  return std::accumulate(in_one_set_.begin(), in_one_set_.end(), std::size_t{0},
                         [](std::size_t sum, const auto& source) { return sum + source->size(); });
}

}  // namespace xview
