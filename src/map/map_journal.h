// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview::map {

/// A change that was interrupted leaves `MAP-journal`, from which SQLite restores the map when the
/// map is opened next, and whatever else such a file tells it to do: delete a file that it names,
/// cut the map off. Throws Error unless what lies beside this map is what a change of it leaves:
/// a journal of this map that names no other file, and no write-ahead log, which maps never have.
/// Nothing is changed. Asked before SQLite opens the map.
void requireOwnJournal(const std::string& path);

/// The same for a map that is going to be made: a journal of an older one would change it.
void requireNoJournal(const std::string& path);

}  // namespace xview::map
