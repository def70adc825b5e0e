// SPDX-License-Identifier: BSD-3-Clause
#include "listed_recording.h"

#include <algorithm>

#include "xview/types/error.h"

namespace xview {
namespace {

Frame readListed(const RecordingListing& listing, const ListedFrame& listed) {
  Frame frame;
  frame.number = listed.number;
  frame.stamp_s = listed.stamp_s;
  frame.sensor = listing.sensor;
  frame.T_odom_sensor = listed.T_odom_sensor;
  listing.read(listed, frame);
  return frame;
}

class ListedRecording : public FrameSource {
 public:
  ListedRecording(std::string name, RecordingListing listing)
      : name_(std::move(name)), listing_(std::move(listing)) {}

  std::size_t size() const override { return listing_.frames.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return at(index).T_odom_sensor; }
  double stamp(std::size_t index) const override { return at(index).stamp_s; }
  std::int64_t number(std::size_t index) const override { return at(index).number; }
  Frame read(std::size_t index) const override { return readListed(listing_, at(index)); }
  Sensor sensor() const override { return listing_.sensor; }
  const LabelSet& labels() const override { return listing_.labels; }
  const std::string& name() const override { return name_; }

 private:
  const ListedFrame& at(std::size_t index) const { return listing_.frames.at(index); }

  std::string name_;
  RecordingListing listing_;
};

}  // namespace

std::unique_ptr<FrameSource> makeRecording(const std::string& name, RecordingListing listing,
                                           const FrameRange& range) {
  const std::size_t count = listing.frames.size();
  const std::size_t end = std::min(range.end.value_or(count), count);
  if (range.begin >= end) {
    throw UsageError("--frames " + std::to_string(range.begin) + ":" +
                     (range.end ? std::to_string(*range.end) : "") + " has no frames: " + name +
                     " has " + std::to_string(count));
  }
  std::vector<ListedFrame> chosen;
  for (std::size_t i = range.begin; i < end; i += std::min(range.step, end - i)) {
    chosen.push_back(std::move(listing.frames[i]));
  }
  listing.frames = std::move(chosen);
  return std::make_unique<ListedRecording>(name, std::move(listing));
}

LabelCounts countLabels(const RecordingListing& listing, std::size_t max_frames) {
  LabelCounts counts;
  const std::size_t count = listing.frames.size();
  const std::size_t samples = std::min(count, max_frames);
  for (std::size_t i = 0; i < samples; ++i) {
    const Frame frame = readListed(listing, listing.frames[i * count / samples]);
    for (const std::uint16_t label : frame.label.pixels) ++counts[label];
    for (const auto& point : frame.cloud.points) ++counts[point.label];
  }
  return counts;
}

void requireSameSize(const std::string& path, int width, int height, const std::string& other_path,
                     int other_width, int other_height) {
  if (width == other_width && height == other_height) return;
  throw Error(path, std::to_string(width) + " x " + std::to_string(height) + " pixels, but " +
                        other_path + " has " + std::to_string(other_width) + " x " +
                        std::to_string(other_height));
}

}  // namespace xview
