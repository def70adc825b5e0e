// SPDX-License-Identifier: BSD-3-Clause
#include "classes.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <map>

#include "xview/io/label_files.h"
#include "xview/place_builder.h"

namespace xview::tools {
namespace {

/// "surface: road, wall, fence and 4 others; object: pole": what classes were taken for, in order.
class ClassSummary {
 public:
  void add(const char* taken_for, const std::string& name) { names_[taken_for].push_back(name); }
  std::string text() const {
    constexpr std::size_t kListed = 6;
    std::string text;
    for (const auto& [taken_for, names] : names_) {
      const std::size_t listed = names.size() <= kListed + 1 ? names.size() : kListed;
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", taken_for,
                          fmt::join(names.begin(), names.begin() + listed, ", "));
      if (listed < names.size()) text += fmt::format(" and {} others", names.size() - listed);
    }
    return text;
  }
  bool empty() const { return names_.empty(); }

 private:
  std::map<std::string, std::vector<std::string>> names_;
};

void logShapes(const std::string& path, const LabelSet& unnamed, const Narrative& narrate) {
  ClassSummary shapes;
  for (const auto& [id, info] : unnamed.classes()) {
    if (info.kind != Kind::none && info.kind != Kind::other_object)
      shapes.add(toString(info.kind), std::to_string(id));
  }
  narrate.note(path + ": " +
               (shapes.empty()
                    ? "the classes have no names, so each counts as an object, the ground too; "
                      "--labels names them"
                    : "the classes have no names and were judged by their shapes (" +
                          shapes.text() + "); --labels names them"));
}

bool isNameless(const LabelMatch& match) {
  return match.from().isGeneric() != match.to().isGeneric();
}

}  // namespace

void logGuesses(const std::string& path, const LabelSet& labels, const Narrative& narrate) {
  if (labels.isGeneric()) return logShapes(path, labels, narrate);
  ClassSummary guessed;
  for (const auto& [id, info] : labels.classes()) {
    if (info.guessed) guessed.add(toString(info.role), info.name);
  }
  if (!guessed.empty())
    narrate.note(fmt::format("{} gives no roles; guessed: {}", labels.name(), guessed.text()));
}

void tellHowClassesMeet(const std::string& path, const LabelSet& labels,
                        const io::InputOptions& options, const Narrative& narrate) {
  if (!options.map_labels) return;
  const LabelMatch match(labels, *options.map_labels, options.class_names);
  if (match.changesNothing()) return;
  for (const auto& [id, partner] : match.partners()) {
    narrate.detail(fmt::format("{}: {} is {} in the map (by {})", path, labels.className(id),
                               match.to().className(partner.id), toString(partner.by)));
  }
  for (const std::uint32_t id : match.alone())
    narrate.detail(fmt::format("{}: {} is nothing in the map", path, labels.className(id)));
  if (isNameless(match) && !match.isHopeless()) {
    narrate.note(
        fmt::format("{}: its classes meet those of the map by the shapes of their points "
                    "only, as those of the {} have no names; {}",
                    path, labels.isGeneric() ? "query" : "map",
                    labels.isGeneric() ? "--labels names them, and --labels shapes leaves them "
                                         "aside, which tells more where labels are poor"
                                       : "--map-labels names them"));
  }
}

void tellHowClassesMeet(const std::string& path, const Place& place,
                        const io::InputOptions& options, const Narrative& narrate) {
  tellHowClassesMeet(path, place.labels, options, narrate);
  const LabelMatch match(place.labels, *options.map_labels, options.class_names);
  if (match.changesNothing() || match.isHopeless()) return;
  std::map<std::uint32_t, std::size_t> alone;
  for (const Vertex& vertex : place.graph.vertices) {
    const bool has_partner = match.partners().count(vertex.label) > 0;
    if (!has_partner && place.labels.role(vertex.label) != Role::ignored) ++alone[vertex.label];
  }
  ClassSummary left_out;
  for (const auto& [id, count] : alone)
    left_out.add("they count for nothing", fmt::format("{} {}", count, place.labels.className(id)));
  if (!left_out.empty())
    narrate.note(path + ": vertices without a partner among the classes of the map; " +
                 left_out.text());
}

std::unique_ptr<FrameSource> inClassesOfMap(std::unique_ptr<FrameSource> source,
                                            const io::InputOptions& options) {
  if (!options.map_labels || knowsShapesOnly(source->labels())) return source;
  LabelMatch match(source->labels(), *options.map_labels, options.class_names);
  if (match.changesNothing() || match.isHopeless()) return source;
  return std::make_unique<TranslatedRecording>(std::move(source), std::move(match));
}

Place inClassesOfMap(Place place, const io::InputOptions& options) {
  if (knowsShapesOnly(place.labels)) return place;
  const LabelMatch match(place.labels, *options.map_labels, options.class_names);
  if (match.changesNothing() || match.isHopeless()) return place;
  return translated(std::move(place), match);
}

LabelSet labelsOfGraph(const std::string& path, const SemanticGraph& graph,
                       const std::optional<LabelSet>& own, const io::InputOptions& options,
                       const Narrative& narrate) {
  constexpr double kKnownShare = 0.9;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (const auto named = io::namedLabels(options, folder, own)) return *named;
  std::map<std::uint32_t, std::size_t> counts;
  std::size_t known = 0;
  for (const Vertex& vertex : graph.vertices) {
    ++counts[vertex.label];
    known += options.map_labels && options.map_labels->find(vertex.label) ? 1 : 0;
  }
  if (options.map_labels &&
      static_cast<double>(known) >= kKnownShare * static_cast<double>(graph.size())) {
    narrate.note(path + " names no classes; its ids are taken as those of the map" +
                 (options.map_labels->isGeneric() ? ", which names none either"
                                                  : "; --labels names others"));
    return *options.map_labels;
  }
  std::vector<std::uint32_t> ids;
  for (const auto& [id, count] : counts) ids.push_back(id);
  return genericLabelSet(ids);
}

}  // namespace xview::tools
