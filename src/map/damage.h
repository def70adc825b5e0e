// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace xview {

/// The bytes of a map file contradict themselves. Becomes an Error with the path at the border of
/// the folder.
class Damage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace xview
