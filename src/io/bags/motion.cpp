// SPDX-License-Identifier: BSD-3-Clause
#include "motion.h"

#include "base/user_text.h"

namespace xview::io {
namespace {

void sortByTime(std::vector<StampedPose>& poses) {
  std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_s < b.stamp_s;
  });
}

}  // namespace

Motion::Motion(const Bag& bag, const Topic& measurements, const Topic* odometry, bool by_recorder)
    : bag_(bag), measurements_(measurements), odometry_(odometry), by_recorder_(by_recorder) {
  if (isOfTransforms()) findWanted();
  readMessages();
  std::stable_sort(measured_.begin(), measured_.end(),
                   [](const Measured& a, const Measured& b) { return a.stamp_s < b.stamp_s; });
  sortByTime(moved_.poses);
  for (auto& [child, link] : links_) sortByTime(link.poses);
  if (isOfTransforms())
    makeChainOfTransforms();
  else if (!moved_.poses.empty())
    makeChain();
  if (invalid_ > 0) note("{} poses are no rotations and are left out", invalid_);
  if (without_stamp_ > 0)
    note("{} messages have no stamp; the time of the recorder is taken", without_stamp_);
}

std::optional<Eigen::Isometry3d> Motion::at(double stamp_s) const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (const Link* link : chain_) {
    const auto pose = link->is_static ? link->poses.front().T_frame_sensor
                                      : poseAt(link->poses, stamp_s, kLongestGap_s);
    if (!pose) return std::nullopt;
    T = *pose * T;
  }
  return T;
}

bool Motion::meets() const {
  return std::any_of(measured_.begin(), measured_.end(),
                     [&](const Measured& one) { return at(one.stamp_s).has_value(); });
}

std::string Motion::span() const {
  for (const Link* link : chain_) {
    if (!link->is_static)
      return fmt::format("{:.3f} to {:.3f} s", link->poses.front().stamp_s,
                         link->poses.back().stamp_s);
  }
  return "no time";
}

// ---- reading

bool Motion::isOfTransforms() const {
  return odometry_ && odometry_->content == Content::transforms;
}

double Motion::stampOf(const MessageHeader& header, const MessageAt& message) {
  if (header.stamp_s > 0 && !by_recorder_) return header.stamp_s;
  without_stamp_ += !by_recorder_;
  return 1e-9 * static_cast<double>(message.log_ns);
}

std::vector<const Topic*> Motion::poseTopics() const {
  std::vector<const Topic*> topics;
  if (odometry_) topics.push_back(odometry_);
  for (const Topic& topic : bag_.topics()) {
    const bool may_mount = topic.content == Content::transforms && !isOfTransforms();
    if (topic.isStatic() || (may_mount && &topic != odometry_)) topics.push_back(&topic);
  }
  return topics;
}

/// A robot with many joints has more transforms than memory should hold.
void Motion::findWanted() {
  const std::string sensor_frame =
      bag_.read(measurements_, measurements_.messages.front(), kHeadBytes,
                [](Cursor& cursor) { return readHeader(cursor).frame; });
  Links links;
  for (const auto& [topic, message] : inFileOrder(poseTopics())) {
    bag_.read(*topic, *message, kWhole, [&](Cursor& cursor) {
      for (const StampedTransform& transform : readTransforms(cursor, Content::transforms))
        links[transform.child].parent = transform.header.frame;
    });
  }
  wanted_ = wayUp(links, sensor_frame);
}

void Motion::readMessages() {
  std::vector<const Topic*> topics = poseTopics();
  topics.push_back(&measurements_);
  for (const TopicAndMessage& at : inFileOrder(topics)) {
    const bool is_transforms = at.topic->content == Content::transforms;
    bag_.read(*at.topic, *at.message, is_transforms ? kWhole : kHeadBytes, [&](Cursor& cursor) {
      if (is_transforms) return takeTransforms(cursor, at.topic->isStatic(), *at.message);
      if (at.topic == odometry_) return takePose(cursor, *at.message);
      const MessageHeader header = readHeader(cursor);
      if (measured_.empty()) sensor_frame_ = header.frame;
      measured_.push_back({stampOf(header, *at.message), at.message});
    });
  }
}

void Motion::takePose(Cursor& cursor, const MessageAt& message) {
  const auto poses = readTransforms(cursor, odometry_->content);
  if (poses.empty()) ++invalid_;
  for (const StampedTransform& pose : poses) {
    moved_.parent = pose.header.frame;
    base_frame_ = pose.child;
    moved_.poses.push_back({stampOf(pose.header, message), pose.T_frame_child});
  }
}

void Motion::takeTransforms(Cursor& cursor, bool is_static, const MessageAt& message) {
  for (const StampedTransform& transform : readTransforms(cursor, Content::transforms)) {
    if (!isOfTransforms()) {
      takeMounting(transform);
      continue;
    }
    if (std::find(wanted_.begin(), wanted_.end(), transform.child) == wanted_.end()) continue;
    Link& link = links_[transform.child];
    if (is_static && !link.poses.empty()) continue;  // it is said again to who comes late
    if (link.is_static) link.poses.clear();
    link.parent = transform.header.frame;
    link.is_static = is_static;
    link.poses.push_back(
        {is_static ? 0 : stampOf(transform.header, message), transform.T_frame_child});
  }
}

/// What never changes is static, whatever the topic is called; what changes mounts nothing.
void Motion::takeMounting(const StampedTransform& transform) {
  const Eigen::Isometry3d& T = transform.T_frame_child;
  const auto [known, is_new] =
      links_.try_emplace(transform.child, Link{transform.header.frame, true, {{0, T}}});
  std::vector<StampedPose>& poses = known->second.poses;
  if (!is_new && !poses.empty() && !poses.front().T_frame_sensor.isApprox(T, 1e-6)) poses.clear();
}

// ---- frames

/// The frames above one, and itself, until it would go round or too far.
std::vector<std::string> Motion::wayUp(const Links& links, const std::string& frame) {
  constexpr std::size_t kMostFrames = 1000;
  std::vector<std::string> way = {frame};
  for (auto link = links.find(frame); link != links.end(); link = links.find(way.back())) {
    const std::string& parent = link->second.parent;
    if (std::find(way.begin(), way.end(), parent) != way.end() || way.size() == kMostFrames) break;
    way.push_back(parent);
  }
  return way;
}

/// T_above_frame of the first frame of a way up.
std::optional<Eigen::Isometry3d> Motion::staticPose(const std::vector<std::string>& way,
                                                    const std::string& above) const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (const std::string& frame : way) {
    if (frame == above) return T;
    const auto link = links_.find(frame);
    if (link == links_.end() || link->second.poses.empty()) return std::nullopt;
    T = link->second.poses.front().T_frame_sensor * T;
  }
  return std::nullopt;
}

/// T_base_sensor over static transforms; none if they do not connect the two.
std::optional<Eigen::Isometry3d> Motion::mounting() const {
  const auto from_base = wayUp(links_, base_frame_), from_sensor = wayUp(links_, sensor_frame_);
  for (const std::string& above : from_base) {
    const auto T_above_base = staticPose(from_base, above),
               T_above_sensor = staticPose(from_sensor, above);
    if (T_above_base && T_above_sensor) return T_above_base->inverse() * *T_above_sensor;
  }
  return std::nullopt;
}

std::optional<Eigen::Isometry3d> Motion::onBase() const {
  const bool is_apart = !isOfTransforms() && sensor_frame_ != base_frame_ && !mounted_.is_static;
  if (is_registered_ || is_apart) return std::nullopt;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (const Link* link : chain_) {
    if (!link->is_static) return T;
    T = link->poses.front().T_frame_sensor * T;
  }
  return std::nullopt;
}

void Motion::makeChain() {
  is_registered_ = sensor_frame_ == moved_.parent && sensor_frame_ != base_frame_;
  if (is_registered_) {
    note(
        "its clouds are in the frame {} of the odometry already; they are taken back to the sensor",
        io::inQuotes(sensor_frame_));
  } else if (sensor_frame_ != base_frame_) {
    const auto T_base_sensor = mounting();
    if (T_base_sensor)
      mounted_ = {base_frame_, true, {{0, *T_base_sensor}}};
    else
      note("no static transform from {} to {}: the poses are taken as those of the sensor",
           io::inQuotes(sensor_frame_),
           base_frame_.empty() ? "the body of the odometry" : io::inQuotes(base_frame_));
  }
  if (mounted_.is_static) chain_.push_back(&mounted_);
  chain_.push_back(&moved_);
}

/// From the sensor up to the odometry's frame; or to the last one, if none is called so. What is
/// above it, the frame of a map, jumps.
void Motion::makeChainOfTransforms() {
  bool moves = false;
  for (const std::string& frame : wayUp(links_, sensor_frame_)) {
    const auto link = links_.find(frame);
    const bool is_odom = frame.size() >= 4 && frame.compare(frame.size() - 4, 4, "odom") == 0;
    if (link == links_.end() || (is_odom && moves)) break;
    moves |= !link->second.is_static;
    chain_.push_back(&link->second);
  }
  if (moves) return;
  chain_.clear();
  note("no transform of {} moves the frame {}", printable(odometry_->topic),
       io::inQuotes(sensor_frame_));
}

}  // namespace xview::io
