// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "listed_recording.h"

namespace xview {

// One function per layout: what frames there are and how each is read. All throw Error with path
// and place.

RecordingListing listSequence(const std::string& folder, const InputOptions& options);
/// A sequence folder, or one .bin file.
RecordingListing listSemanticKitti(const std::string& path, const InputOptions& options);
RecordingListing listCloud(const std::string& path, const InputOptions& options);
RecordingListing listCloudFolder(const std::string& folder, const InputOptions& options);

}  // namespace xview
