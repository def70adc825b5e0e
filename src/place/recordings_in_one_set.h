// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "base/label_match.h"
#include "xview/base/frame.h"
#include "xview/options.h"

namespace xview {

/// How classes of an addition are called in a map. Throws Error, with the name of the addition, if
/// none of them is there.
LabelMatch requireCommonClasses(const LabelSet& addition, const std::string& name,
                                const LabelSet& map);

/// The recordings of which a map is made, in the classes of the first, and the options for all.
class RecordingsInOneSet {
 public:
  /// Throws as buildMap() does. The sources must outlive this object.
  RecordingsInOneSet(const std::vector<const FrameSource*>& sources, const Options& given);

  std::size_t size() const { return in_one_set_.size(); }
  const FrameSource& operator[](std::size_t i) const { return *in_one_set_[i]; }
  const Options& options() const { return options_; }
  std::size_t frames() const;  ///< of all

 private:
  std::vector<std::unique_ptr<const FrameSource>> classified_, in_one_set_;
  Options options_;
};

}  // namespace xview
