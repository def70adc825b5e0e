// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/frame.h"

namespace xview::tools {

/// The frames of a recording from one position on.
class RecordingPart final : public FrameSource {
 public:
  /// The recording must outlive this object; first <= its size.
  RecordingPart(const FrameSource& recording, std::size_t first)
      : recording_(recording), first_(first) {}

  std::size_t size() const override { return recording_.size() - first_; }
  Eigen::Isometry3d pose(std::size_t index) const override {
    return recording_.pose(first_ + index);
  }
  double stamp(std::size_t index) const override { return recording_.stamp(first_ + index); }
  std::int64_t number(std::size_t index) const override {
    return recording_.number(first_ + index);
  }
  Frame read(std::size_t index) const override { return recording_.read(first_ + index); }
  Sensor sensor() const override { return recording_.sensor(); }
  const LabelSet& labels() const override { return recording_.labels(); }
  const std::string& name() const override { return recording_.name(); }

 private:
  const FrameSource& recording_;
  std::size_t first_;
};

}  // namespace xview::tools
