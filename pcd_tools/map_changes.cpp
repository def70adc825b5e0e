// SPDX-License-Identifier: BSD-3-Clause
#include "map_changes.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "inputs.h"
#include "xview/mapper.h"
#include "xview/types/error.h"
#include "xview/types/user_text.h"

namespace xview::tools {
namespace {

bool isAmong(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void copyTo(const AtomicFile& copy, const std::string& path) {
  std::filesystem::copy_file(path, copy.temporaryPath(),
                             std::filesystem::copy_options::overwrite_existing);
}

/// A visit and the change that added it.
struct Addition {
  map::Revision revision;
  map::Visit visit;
};

/// The additions from that of the source on. Throws Error if the source cannot be taken out.
std::vector<Addition> additionsSince(const std::string& path, const std::string& source) {
  const std::vector<map::Revision> revisions = map::readRevisions(path);
  std::vector<Addition> later;
  for (std::size_t i = revisions.size(); i-- > 0;) {
    if (!revisions[i].is_visit)
      throw Error(path, "was changed after " + source + " was added, or has no such addition: " +
                            revisions[i].note + "; take that back first, with --undo");
    later.insert(later.begin(), {revisions[i], map::loadVisit(path, i)});
    if (isAmong(later.front().visit.place.sources, source)) return later;
  }
  const std::vector<std::string> sources = map::openMap(path).sources;
  if (isAmong(sources, source))
    throw Error(path,
                source + " is one of those that the map was begun with; make it again without it");
  throw Error(path, "nothing of " + source + " is in it; xview info lists its sources");
}

}  // namespace

MapDraft::MapDraft(const std::string& path, const map::SemanticMap& begin)
    : path_(path), copy_(path) {
  map::saveMap(copy_.temporaryPath(), begin);
}

MapDraft::MapDraft(const std::string& path, const std::string& from) : path_(path), copy_(path) {
  if (std::filesystem::path(path).extension() != ".xvm" ||
      (std::filesystem::exists(path) && !map::isMapFile(path)))
    throw UsageError(path + ": a map ends with .xvm, and only a map is written over");
  map::requireChangeable(from);
  copyTo(copy_, from);
}

void MapDraft::add(const map::SemanticMap& map, const std::string& note, const map::Visit& visit) {
  map::saveRevision(copy_.temporaryPath(), map, note, &visit);
}

void MapDraft::change(const map::SemanticMap& map, const std::string& note) {
  map::saveRevision(copy_.temporaryPath(), map, note);
}

void MapDraft::commit() {
  // In place, because others may hold the lock of the file that is there.
  if (std::filesystem::exists(path_))
    map::replaceMap(path_, copy_.temporaryPath());
  else
    copy_.commit();
}

ExitCode undoLast(const std::string& path) {
  const map::MapLock lock(path);
  const std::vector<map::Revision> revisions = map::readRevisions(path);
  if (!map::undoRevision(path)) throw Error(path, "nothing to undo: no change of it is on record");
  fmt::print("{}: taken back: {}; {} vertices\n", path, printable(revisions.back().note),
             map::openMap(path).graph.size());
  return kDone;
}

ExitCode takeOut(const std::string& path, const std::string& source, const Job& job) {
  requireWritable(path);
  const map::MapLock lock(path);
  const std::vector<Addition> later = additionsSince(path, source);
  MapDraft draft(path, path);
  for (std::size_t i = 0; i < later.size(); ++i) map::undoRevision(draft.path());
  map::SemanticMap map = map::openMap(draft.path());
  const Options options = inMap(job, map).options;
  for (std::size_t i = 1; i < later.size(); ++i) {
    appendToMap(map, later[i].visit.place, options);
    draft.add(map, later[i].revision.note, later[i].visit);
  }
  draft.commit();
  fmt::print("{}: without {}, {} vertices\n", path, printable(source), map.graph.size());
  return kDone;
}

}  // namespace xview::tools
