// SPDX-License-Identifier: BSD-3-Clause
#include "place/shared_frames.h"

#include "process/message.h"

namespace xview {

template <class Message>
void visit(LabelledCloud& cloud, Message& message) {
  message(cloud.origin, cloud.points.points, cloud.points.width, cloud.points.height,
          cloud.points.is_dense);
}

template <class Message>
void visit(LiftCounts& counts, Message& message) {
  message(counts.lifted, counts.no_depth, counts.out_of_range, counts.ignored_class,
          counts.unknown);
}

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

std::string frameRequest(std::size_t recording, std::size_t frame) {
  MessageWriter request;
  request(HelperTask::frame, recording, frame);
  return request.take();
}

std::string answerFrameRequest(const std::string& text, const RecordingsInOneSet& recordings) {
  MessageReader request(text);
  if (request.next<HelperTask>() != HelperTask::frame) request.fail();
  const auto recording = request.next<std::size_t>(), frame = request.next<std::size_t>();
  request.end();
  if (recording >= recordings.size() || frame >= recordings[recording].size()) request.fail();
  MessageWriter answer;
  answer(readAndPreprocess(recordings[recording], frame, recordings.options()));
  return answer.take();
}

PreprocessedFrame preprocessedFrameOf(const std::string& text) {
  MessageReader answer(text);
  auto frame = answer.next<PreprocessedFrame>();
  answer.end();
  return frame;
}

}  // namespace xview
