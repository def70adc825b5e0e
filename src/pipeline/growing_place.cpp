// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/growing_place.h"

#include <utility>

#include "pipeline/gravity.h"

namespace xview {
namespace {

constexpr std::size_t kFramesForGravity = 16;  ///< that say together which way is up

}  // namespace

GrowingPlace::GrowingPlace(const LabelSet& labels, const Options& options)
    : labels_(labels),
      gravity_(options.gravity),
      graph_(labels, options),
      plan_(labels, options.plan) {}

void GrowingPlace::add(FrameDigest frame) {
  if (upright_) return addUpright(frame);
  waiting_.push_back(std::move(frame));
  if (waiting_.size() == kFramesForGravity) settleUpright();
}

void GrowingPlace::endRecording() {
  if (!upright_) settleUpright();
}

GrowingPlace::Place GrowingPlace::finish() const {
  Place place;
  place.plan = plan_.build();
  place.plan.upright = upright_->upright;
  place.gravity = *upright_;
  place.graph = graph_.finish(place.plan);
  return place;
}

void GrowingPlace::settleUpright() {
  upright_ = gravityOf(waiting_.data(), waiting_.data() + waiting_.size(), labels_, gravity_);
  for (const FrameDigest& frame : waiting_) addUpright(frame);
  waiting_ = {};
}

void GrowingPlace::addUpright(const FrameDigest& frame) {
  graph_.add(frame);
  if (upright_->known) {
    plan_.add(frame.cloud, frame.votes, frame.thin_trusted, Eigen::Isometry3d(upright_->upright),
              frame.aerial);
  }
}

}  // namespace xview
