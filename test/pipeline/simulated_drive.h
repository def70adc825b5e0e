// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "xview/localizer.h"
#include "xview/mapper.h"
#include "xview/sim/recordings.h"

namespace xview::test {

/// A short drive through a seeded town, made once for all tests of the process: its map, and what
/// other sessions saw.
struct SimulatedDrive {
  std::map<std::string, std::unique_ptr<SimulatedRecording>>
      sessions;  ///< forward, rear, elsewhere
  std::map<std::string, std::vector<FrameDigest>> frames;
  SemanticMap map;  ///< of forward
  LabelSet labels;

  Query query(const std::string& session, std::size_t first, std::size_t last,
              const Options& options = {}) const;
};

const SimulatedDrive& simulatedDrive();

/// A recording whose odometry begins somewhere else: T_odom_sensor becomes T_new_old *
/// T_odom_sensor.
class MovedRecording : public FrameSource {
 public:
  MovedRecording(const FrameSource& source, const Eigen::Isometry3d& T_new_old)
      : source_(source), T_new_old_(T_new_old) {}
  std::size_t size() const override { return source_.size(); }
  Eigen::Isometry3d pose(std::size_t i) const override { return T_new_old_ * source_.pose(i); }
  double stamp(std::size_t i) const override { return source_.stamp(i); }
  std::int64_t number(std::size_t i) const override { return source_.number(i); }
  Frame read(std::size_t i) const override {
    Frame frame = source_.read(i);
    frame.T_odom_sensor = T_new_old_ * frame.T_odom_sensor;
    return frame;
  }
  Sensor sensor() const override { return source_.sensor(); }
  const LabelSet& labels() const override { return source_.labels(); }
  const std::string& name() const override { return source_.name(); }

 private:
  const FrameSource& source_;
  Eigen::Isometry3d T_new_old_;
};

inline std::vector<FrameDigest> movedFrames(const FrameSource& source,
                                            const Eigen::Isometry3d& T_new_old) {
  return digestRecording(MovedRecording(source, T_new_old), {});
}

}  // namespace xview::test
