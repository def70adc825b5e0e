// SPDX-License-Identifier: BSD-3-Clause
// What was added to a map is kept in it as a database of its own: the input, in a map that is sound
// otherwise. A visit that is read is kept in that map once more and read again.
#include <sqlite3.h>

#include "fuzz.h"
#include "xview/map/semantic_map.h"

namespace {

using namespace xview;

/// A map with one change, whose visit is replaced by every input.
std::string mapWithVisit() {
  const std::string path = fuzz::scratch() + "/visited.xvm";
  std::filesystem::remove(path);
  map::SemanticMap map;
  map::saveMap(path, map);
  map.sources = {"visit"};
  const map::Visit visit{map, 0.5};
  map::saveRevision(path, map, "added", &visit);
  return path;
}

void setVisit(const std::string& path, const std::uint8_t* data, std::size_t size) {
  sqlite3* database = nullptr;
  sqlite3_stmt* update = nullptr;
  fuzz::require(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
  sqlite3_exec(database, "PRAGMA synchronous = OFF", nullptr, nullptr, nullptr);
  sqlite3_prepare_v2(database, "UPDATE undo_visits SET data = ? WHERE step = 1", -1, &update,
                     nullptr);
  sqlite3_bind_blob64(update, 1, data, size, SQLITE_STATIC);
  fuzz::require(sqlite3_step(update) == SQLITE_DONE);
  sqlite3_finalize(update);
  sqlite3_close(database);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = mapWithVisit();
  setVisit(path, data, size);
  map::Visit visit;
  if (!fuzz::isDone([&] { visit = map::loadVisit(path, 0); })) return 0;
  fuzz::isDone([&] {
    map::saveRevision(path, map::SemanticMap(), "again", &visit);
    const map::Visit again = map::loadVisit(path, 1);
    fuzz::require(again.place.graph.size() == visit.place.graph.size() &&
                  again.place.cloud.size() == visit.place.cloud.size() &&
                  again.sigma_m == visit.sigma_m);
  });
  while (map::readRevisions(path).size() > 1) fuzz::require(map::undoRevision(path));
  return 0;
}
