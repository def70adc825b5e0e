// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

// Files and folders that are being written under a name of their own, NAME.partial-PID-N, beside
// the one that they will have.

/// A name beside the path that no other object of this process and no other process has. Long
/// names are cut, so that there is room for the ending.
std::string partialNameFor(const std::string& path);

/// Removes what runs that were killed left beside this path. Only processes of this machine are
/// known: what a living one writes stays. A folder is looked through once per process.
void removeAbandoned(const std::string& path);

/// An interrupt from now on removes the path.
void addUnfinished(const std::string& path);
/// An interrupt from now on gives it the name of its target instead.
void keepUnfinished(const std::string& path, const std::string& target);
void dropUnfinished(const std::string& path);

}  // namespace xview
