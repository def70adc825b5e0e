// SPDX-License-Identifier: BSD-3-Clause
#include "map_changes.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "base/user_text.h"
#include "inputs.h"
#include "map/contents.h"
#include "xview/base/error.h"
#include "xview/mapper.h"

namespace xview::tools {
namespace {

bool isAmong(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::unique_ptr<AtomicFile> copyOf(const std::string& from, const std::string& path) {
  auto copy = std::make_unique<AtomicFile>(path);
  std::filesystem::copy_file(from, copy->temporaryPath(),
                             std::filesystem::copy_options::overwrite_existing);
  return copy;
}

std::unique_ptr<AtomicFile> savedFor(const std::string& path, const map::SemanticMap& begin) {
  auto copy = std::make_unique<AtomicFile>(path);
  map::saveMap(copy->temporaryPath(), begin);
  return copy;
}

/// In place, because others may hold the lock of the file that is there.
void putInPlace(AtomicFile& copy, const std::string& path) {
  if (std::filesystem::exists(path))
    map::replaceMap(path, copy.temporaryPath());
  else
    copy.commit();
}

bool isSameFile(const std::string& path, const std::string& other) {
  return std::filesystem::exists(path) && std::filesystem::equivalent(path, other);
}

/// Null if the file itself is to change. Throws Error or UsageError.
std::unique_ptr<AtomicFile> draftOf(const std::string& path, const std::string& from) {
  if (std::filesystem::path(path).extension() != ".xvm" ||
      (std::filesystem::exists(path) && !map::isMapFile(path)))
    throw UsageError(path + ": a map ends with .xvm, and only a map is written over");
  return isSameFile(path, from) ? nullptr : copyOf(from, path);
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
    : path_(path), copy_(savedFor(path, begin)), changes_(copy_->temporaryPath()) {}

MapDraft::MapDraft(const std::string& path, const std::string& from)
    : path_(path), copy_(draftOf(path, from)), changes_(copy_ ? copy_->temporaryPath() : path) {}

void MapDraft::add(const map::SemanticMap& map, const std::string& note, const map::Visit& visit) {
  changes_.add(map, note, &visit);
}

void MapDraft::change(const map::SemanticMap& map, const std::string& note) {
  changes_.add(map, note);
}

void MapDraft::commit() {
  changes_.commit();
  if (copy_) putInPlace(*copy_, path_);
}

ExitCode undoLast(const std::string& path) {
  const map::MapLock lock(path);
  const std::vector<map::Revision> revisions = map::readRevisions(path);
  if (!map::undoRevision(path)) throw Error(path, "nothing to undo: no change of it is on record");
  fmt::print("{}: taken back: {}; {} vertices\n", path, printable(revisions.back().note),
             map::countsOf(map::openMap(path)).vertices);
  return kDone;
}

ExitCode takeOut(const std::string& path, const std::string& source, const Job& job) {
  requireWritable(path);
  const map::MapLock lock(path);
  const std::vector<Addition> later = additionsSince(path, source);
  const auto copy = copyOf(path, path);
  const std::string& without = copy->temporaryPath();
  for (std::size_t i = 0; i < later.size(); ++i) map::undoRevision(without);
  map::SemanticMap map = map::openMap(without);
  map::MapChanges changes(without);
  const Options options = inMap(job, map).options;
  for (std::size_t i = 1; i < later.size(); ++i) {
    appendToMap(map, later[i].visit.place, options);
    changes.add(map, later[i].revision.note, &later[i].visit);
  }
  changes.commit();
  putInPlace(*copy, path);
  fmt::print("{}: without {}, {} vertices\n", path, printable(source), map::countsOf(map).vertices);
  return kDone;
}

}  // namespace xview::tools
