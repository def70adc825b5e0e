// SPDX-License-Identifier: BSD-3-Clause
#include "xview/unnamed_classes.h"

#include <algorithm>
#include <vector>

#include "xview/graph/blobs.h"
#include "xview/graph/class_shapes.h"
#include "xview/graph/lift.h"
#include "xview/types/forwarding_source.h"
#include "xview/types/parallel.h"

namespace xview {
namespace {

/// The same frames under other classes.
class Reclassified final : public ForwardingSource {
 public:
  Reclassified(std::unique_ptr<FrameSource> source, LabelSet labels)
      : ForwardingSource(*source), source_(std::move(source)), labels_(std::move(labels)) {}

  const LabelSet& labels() const override { return labels_; }

 private:
  std::unique_ptr<FrameSource> source_;
  LabelSet labels_;
};

std::vector<LabelledCloud> cloudsOver(const FrameSource& source, const Options& options) {
  constexpr std::size_t kFrames = 60;
  constexpr double kVoxel_m = 0.25;
  std::vector<LabelledCloud> clouds(std::min(kFrames, source.size()));
  parallelFor(clouds.size(), options.threads, [&](std::size_t i) {
    const Frame frame = source.read(i * source.size() / clouds.size());
    clouds[i] = thinByVoxel(lift(frame, source.labels(), options.lift), kVoxel_m);
  });
  return clouds;
}

}  // namespace

std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const Options& options) {
  if (!source->labels().isGeneric()) return source;
  LabelSet labels = rolesByShape(source->labels(), cloudsOver(*source, options));
  return std::make_unique<Reclassified>(std::move(source), std::move(labels));
}

}  // namespace xview
