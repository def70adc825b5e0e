// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/forwarding_source.h"

namespace xview::tools {

/// The frames of a recording from one position on.
class RecordingPart final : public ForwardingSource {
 public:
  /// The recording must outlive this object; first <= its size.
  RecordingPart(const FrameSource& recording, std::size_t first)
      : ForwardingSource(recording), first_(first) {}

  std::size_t size() const override { return ForwardingSource::size() - first_; }
  Eigen::Isometry3d pose(std::size_t index) const override {
    return ForwardingSource::pose(first_ + index);
  }
  double stamp(std::size_t index) const override { return ForwardingSource::stamp(first_ + index); }
  std::int64_t number(std::size_t index) const override {
    return ForwardingSource::number(first_ + index);
  }
  Frame read(std::size_t index) const override { return ForwardingSource::read(first_ + index); }

 private:
  std::size_t first_;
};

}  // namespace xview::tools
