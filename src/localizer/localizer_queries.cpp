// SPDX-License-Identifier: BSD-3-Clause
// How a localizer makes queries: in lengths of its map, and with classes that can meet its own.
#include "place/raw_recording.h"
#include "place/shapes.h"
#include "xview/localizer.h"

namespace xview {
namespace {

/// One frame as a recording.
class OneFrame final : public FrameSource {
 public:
  OneFrame(const Frame& frame, const LabelSet& labels) : frame_(frame), labels_(labels) {}
  std::size_t size() const override { return 1; }
  Eigen::Isometry3d pose(std::size_t) const override { return frame_.T_odom_sensor; }
  double stamp(std::size_t) const override { return frame_.stamp_s; }
  std::int64_t number(std::size_t) const override { return frame_.number; }
  Frame read(std::size_t) const override { return frame_; }
  Sensor sensor() const override { return frame_.sensor; }
  const LabelSet& labels() const override { return labels_; }
  const std::string& name() const override { return name_; }

 private:
  const Frame& frame_;
  const LabelSet& labels_;
  std::string name_ = "frame";
};

/// Whether classes come from shapes in such a map.
bool areFromShapes(const LabelSet& labels, const LabelSet& map_labels) {
  return labels.empty() || knowsShapesOnly(map_labels);
}

}  // namespace

Localization Localizer::localize(const FrameSource& recording) const {
  return withinBudget([&] { return localize(query(recording)); });
}

Query Localizer::query(const FrameSource& recording) const {
  return makeQuery(*withClasses(recording, options_, &labels()), options_);
}

Query Localizer::query(const std::vector<PreprocessedFrame>& frames, const LabelSet& given) const {
  return makeQuery(frames.data(), frames.data() + frames.size(),
                   areFromShapes(given, labels()) ? labelsOfShapes() : withRolesOf(labels(), given),
                   options_);
}

PreprocessedFrame Localizer::preprocess(const Frame& frame, const LabelSet& given) const {
  if (!areFromShapes(given, labels()))
    return preprocessFrame(frame, withRolesOf(labels(), given), options_);
  const OneFrame alone(frame, given);
  const LabelSet of_shapes = labelsOfShapes();
  const auto shapes = withClasses(alone, options_, &of_shapes);
  return preprocessFrame(shapes->read(0), shapes->labels(), options_);
}

}  // namespace xview
