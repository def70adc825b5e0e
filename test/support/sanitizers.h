// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace xview::test {

/// Whether this is a build with AddressSanitizer or ThreadSanitizer. Such a program has terabytes of
/// address space, several times the memory and many times the time of another one.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

}  // namespace xview::test
