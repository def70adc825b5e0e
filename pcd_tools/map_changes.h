// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "process/atomic_file.h"
#include "tool.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// Changes of a map file, or a new one: every change on record, all of them or none. Whoever makes
/// one holds the lock of the map.
class MapDraft {
 public:
  /// It begins with this map. Throws Error or UsageError if it could not be written.
  MapDraft(const std::string& path, const map::SemanticMap& begin);
  /// It begins with what a file holds, the same one or another.
  MapDraft(const std::string& path, const std::string& from);

  /// `map` has the visit in it already. Throws Error.
  void add(const map::SemanticMap& map, const std::string& note, const map::Visit& visit);
  void change(const map::SemanticMap& map, const std::string& note);
  void commit();  ///< throws Error; the file is then as before

 private:
  std::string path_;
  std::unique_ptr<AtomicFile> copy_;  ///< unless it is that file which changes
  map::MapChanges changes_;
};

/// Takes the last change of a map file back and says what is left. Throws Error if there is none.
ExitCode undoLast(const std::string& path);

/// Takes what one source has added out of a map file: later additions are made once more without
/// it. Throws Error; the file is then as before.
ExitCode takeOut(const std::string& path, const std::string& source, const Job& job);

}  // namespace xview::tools
