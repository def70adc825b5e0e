// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

namespace xview {

/// Calls body(i) for i in [0, count) on at most `threads` threads (0 = all cores). Results must not
/// depend on the order of the calls; an exception of any call is rethrown here.
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Calls make(i) for i in [0, count) on at most `threads` threads (0 = all cores), the caller's
/// among them, and take(i) in order on the caller's thread once make(i) is done, while later ones
/// are being made. At most `ahead` (>= 1) are made and not yet taken: i + ahead is not begun before
/// take(i) has returned. An exception of make(i) is rethrown where take(i) would have been called;
/// nothing is running any more when this returns or throws.
void makeInOrder(std::size_t count, int threads, std::size_t ahead,
                 const std::function<void(std::size_t)>& make,
                 const std::function<void(std::size_t)>& take);

}  // namespace xview
