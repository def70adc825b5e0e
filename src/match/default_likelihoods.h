// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace xview {

/// Contents of config/likelihoods.txt, compiled in.
extern const char* const kDefaultLikelihoods;

}  // namespace xview
