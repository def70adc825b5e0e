// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/base/labels.h"

namespace xview::test {

/// A class as a test states it; its colour does not matter.
struct StatedClass {
  std::uint32_t id;
  const char* name;
  Role role;
  Kind kind;
};

inline LabelSet labelSetOf(const std::string& name, const std::vector<StatedClass>& classes) {
  LabelSet labels(name);
  for (const StatedClass& stated : classes) {
    ClassInfo info;
    info.id = stated.id;
    info.name = stated.name;
    info.role = stated.role;
    info.kind = stated.kind;
    labels.add(info);
  }
  return labels;
}

}  // namespace xview::test
