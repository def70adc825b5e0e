// SPDX-License-Identifier: BSD-3-Clause
// Map files, whose checksums are not looked at in this build. A map that is read can be opened to
// localize; it is written to a file of its own and read again; an addition is taken back.
#include "fuzz.h"
#include "map/contents.h"
#include "xview/map/semantic_map.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzz::written("in.xvm", bytes);
  std::filesystem::remove(path + "-journal");
  map::SemanticMap map, opened;
  const bool is_opened = fuzz::isDone([&] { opened = map::openMap(path); });
  if (is_opened && opened.stored_vertices) {
    fuzz::isDone([&] { opened.stored_vertices->bounds(); });
    fuzz::isDone([&] { map::unpackVertices(opened); });
  }
  if (fuzz::isDone([&] { map = map::unpacked(map::openMap(path)); })) {
    fuzz::require(is_opened && map::countsOf(opened).vertices == map.graph.size());
    const std::string copy = fuzz::scratch() + "/out.xvm";
    std::filesystem::remove(copy);
    if (fuzz::isDone([&] { map::saveMap(copy, map); })) {
      const map::SemanticMap again = map::unpacked(map::openMap(copy));
      fuzz::require(again.graph.size() == map.graph.size() &&
                    again.cloud.size() == map.cloud.size() &&
                    again.poses.size() == map.poses.size());
      map::saveRevision(copy, map, "again");
      fuzz::require(map::undoRevision(copy));
    }
    fuzz::isDone([&] { map::saveRevision(path, map, "changed"); });
  }
  fuzz::isDone([&] { map::undoRevision(path); });
  return 0;
}
