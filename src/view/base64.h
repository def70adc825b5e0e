// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace xview {

/// RFC 4648 with padding.
std::string base64(const void* data, std::size_t size);

}  // namespace xview
