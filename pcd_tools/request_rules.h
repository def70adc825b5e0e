// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "connection.h"
#include "listening.h"

namespace xview::tools {

constexpr const char* kTrackRoute = R"(/track/([A-Za-z0-9_.-]{1,64}))";  ///< with the robot

/// What the head of a request tells: that it is for this server, from nobody who was lured to it by
/// a page of somebody else, for a route, and of a body that can be taken. Throws Refusal. Who
/// reaches a Unix socket is no browser.
void requireAnswerable(const httplib::Request& request, const Listening& where,
                       std::size_t most_body);

/// "GET", "POST" or "POST, DELETE", as of the header Allow; empty if there is no such route.
std::string methodsOf(const std::string& path);

/// The description of all routes as of OpenAPI 3.
const char* openApi();

}  // namespace xview::tools
