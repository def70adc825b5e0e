// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/frame.h"

namespace xview {

/// A recording that is another one but for what a derived class says differently.
class ForwardingSource : public FrameSource {
 public:
  std::size_t size() const override { return source_.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return source_.pose(index); }
  double stamp(std::size_t index) const override { return source_.stamp(index); }
  std::int64_t number(std::size_t index) const override { return source_.number(index); }
  Frame read(std::size_t index) const override { return source_.read(index); }
  Sensor sensor() const override { return source_.sensor(); }
  const LabelSet& labels() const override { return source_.labels(); }
  const std::string& name() const override { return source_.name(); }
  std::vector<std::string> notes() const override { return source_.notes(); }
  std::string describeUnknown(std::uint32_t label) const override {
    return source_.describeUnknown(label);
  }

 protected:
  /// The other recording must outlive this object.
  explicit ForwardingSource(const FrameSource& source) : source_(source) {}

 private:
  const FrameSource& source_;
};

}  // namespace xview
