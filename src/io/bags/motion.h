// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "bag.h"
#include "xview/io/pose_files.h"

namespace xview::io {

/// Poses farther apart are not interpolated.
constexpr double kLongestGap_s = 1;

/// A measurement and when it was made.
struct Measured {
  double stamp_s = 0;
  const MessageAt* message = nullptr;
};

/// Where the sensor of some measurements was: all that is read of a bag before them. Their stamps
/// are those of their headers, and of the recorder where those are 0.
class Motion {
 public:
  /// `odometry` are messages of isMotion(), or null. Both must outlive this object. `by_recorder`:
  /// all stamps are those of the recorder. Throws Error.
  Motion(const Bag& bag, const Topic& measurements, const Topic* odometry, bool by_recorder);

  const std::vector<Measured>& measured() const { return measured_; }  ///< by their stamps
  const std::vector<std::string>& notes() const { return notes_; }
  /// Whether its clouds have been brought to the frame of the odometry already.
  bool isRegistered() const { return is_registered_; }
  /// Whether anything is known about how the sensor moves.
  bool isKnown() const { return !chain_.empty(); }
  /// T_odom_sensor; none if the poses around that time are too far apart.
  std::optional<Eigen::Isometry3d> at(double stamp_s) const;
  /// T_base_sensor, the base being what moves: over static transforms; none if they do not lead
  /// there.
  std::optional<Eigen::Isometry3d> onBase() const;
  std::string span() const;  ///< of the poses, in words
  /// Whether there is a pose for any measurement.
  bool meets() const;

 private:
  /// Where a frame is in the one above it: poses in the order of time, or one for ever.
  struct Link {
    std::string parent;
    bool is_static = false;
    std::vector<StampedPose> poses;
  };
  using Links = std::map<std::string, Link>;  ///< by the frame below

  static std::vector<std::string> wayUp(const Links& links, const std::string& frame);
  std::optional<Eigen::Isometry3d> staticPose(const std::vector<std::string>& way,
                                              const std::string& above) const;
  std::optional<Eigen::Isometry3d> mounting() const;
  template <class... Values>
  void note(fmt::format_string<Values...> text, Values&&... values) {
    notes_.push_back(fmt::format(text, std::forward<Values>(values)...));
  }
  bool isOfTransforms() const;
  double stampOf(const MessageHeader& header, const MessageAt& message);
  std::vector<const Topic*> poseTopics() const;
  void findWanted();
  void readMessages();
  void takePose(Cursor& cursor, const MessageAt& message);
  void takeTransforms(Cursor& cursor, bool is_static, const MessageAt& message);
  void takeMounting(const StampedTransform& transform);
  void makeChain();
  void makeChainOfTransforms();

  const Bag& bag_;
  const Topic& measurements_;
  const Topic* odometry_;
  bool by_recorder_;
  std::vector<Measured> measured_;
  std::string sensor_frame_, base_frame_;  ///< the latter is what the odometry moves
  std::vector<std::string> wanted_;  ///< frames above the sensor, if the odometry are transforms
  Links links_;                      ///< of transforms
  Link moved_, mounted_;             ///< by the odometry, and the sensor on that
  std::vector<const Link*> chain_;   ///< from the sensor up
  bool is_registered_ = false;
  std::size_t without_stamp_ = 0, invalid_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace xview::io
