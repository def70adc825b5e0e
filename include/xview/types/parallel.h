// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

namespace xview {

/// Calls body(i) for i in [0, count) on at most `threads` threads (0 = all cores). Results must not depend on the order
/// of the calls; an exception of any call is rethrown here.
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

}  // namespace xview
