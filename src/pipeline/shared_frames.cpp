// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/shared_frames.h"

#include <vector>

#include "types/conversation.h"
#include "types/message.h"
#include "xview/types/option_field.h"

namespace xview {

template <class T, class Message>
void visit(Image<T>& image, Message& message) {
  message(image.width, image.height, image.pixels);
}

template <class Message>
void visit(LabelledCloud& cloud, Message& message) {
  message(cloud.origin, cloud.points.points);
  cloud.points.width = static_cast<std::uint32_t>(cloud.points.size());
  cloud.points.height = 1;
}

template <class Message>
void visit(Frame& frame, Message& message) {
  message(frame.number, frame.stamp_s, frame.sensor, frame.T_odom_sensor, frame.up_sensor,
          frame.camera, frame.depth, frame.label, frame.instance, frame.cloud);
}

template <class Message>
void visit(ClassInfo& info, Message& message) {
  message(info.id, info.name, info.color, info.role, info.kind, info.guessed, info.unknown);
}

namespace graph {

template <class Message>
void visit(LiftCounts& counts, Message& message) {
  message(counts.lifted, counts.no_depth, counts.out_of_range, counts.ignored_class,
          counts.unknown);
}

}  // namespace graph

template <class Message>
void visit(Blob& blob, Message& message) {
  message(blob.label, blob.instance, blob.position, blob.covariance, blob.min, blob.max,
          blob.points, blob.first_frame, blob.last_frame);
}

template <class Message>
void visit(PreprocessedFrame& frame, Message& message) {
  message(frame.size, frame.number, frame.stamp_s, frame.sensor, frame.T_odom_sensor,
          frame.up_sensor, frame.cloud, frame.weights, frame.resolves_thin, frame.aerial,
          frame.blobs, frame.blob_edges, frame.counts, frame.timing_ms);
}

namespace {

std::vector<std::string> valuesOf(Options options) {
  std::vector<std::string> values;
  for (const OptionField& field : fieldsOf(options)) values.push_back(valueText(field));
  return values;
}

Options optionsOf(const std::vector<std::string>& values) {
  Options options;
  const std::vector<OptionField> fields = fieldsOf(options);
  if (values.size() != fields.size()) MessageReader::fail();
  for (std::size_t i = 0; i < fields.size(); ++i) assign(fields[i], values[i]);
  return options;
}

}  // namespace

std::string frameRequest(const Frame& frame, const LabelSet& labels, const Options& options) {
  MessageWriter request;
  request(HelperTask::frame, frame, labels.name(), labels.classes(), valuesOf(options));
  return request.take();
}

std::string answerFrameRequest(const std::string& text) {
  MessageReader request(text);
  if (request.next<HelperTask>() != HelperTask::frame) request.fail();
  auto frame = request.next<Frame>();
  LabelSet labels(request.next<std::string>());
  for (const auto& [id, info] : request.next<std::map<std::uint32_t, ClassInfo>>())
    labels.add(info);
  const Options options = optionsOf(request.next<std::vector<std::string>>());
  request.end();
  MessageWriter answer;
  answer(preprocessFrame(std::move(frame), labels, options));
  return answer.take();
}

PreprocessedFrame preprocessedFrameOf(const std::string& text) {
  MessageReader answer(text);
  auto frame = answer.next<PreprocessedFrame>();
  answer.end();
  return frame;
}

}  // namespace xview
