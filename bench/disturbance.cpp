// SPDX-License-Identifier: BSD-3-Clause
#include "disturbance.h"

#include <cmath>

#include "xview/types/pose.h"

namespace xview::bench {
namespace {

/// Noise of a given spread that forgets what it was after `memory_m`.
class Wander {
 public:
  Wander(double sigma, double memory_m, Random& random)
      : sigma_(sigma), memory_m_(memory_m), random_(random), now_(sigma * random.normal()) {}
  double after(double way_m) {
    const double kept = std::exp(-way_m / memory_m_);
    now_ = kept * now_ + sigma_ * std::sqrt(1 - kept * kept) * random_.normal();
    return now_;
  }

 private:
  double sigma_, memory_m_;
  Random& random_;
  double now_;
};

void turnBox(const Eigen::Isometry3d& T, Eigen::Vector3d& low, Eigen::Vector3d& high) {
  const Eigen::Vector3d middle = T * (0.5 * (low + high)),
                        half = T.linear().cwiseAbs() * (0.5 * (high - low));
  low = middle - half;
  high = middle + half;
}

}  // namespace

FrameDigest movedFrame(FrameDigest frame, const Eigen::Isometry3d& T) {
  const Eigen::Matrix3f turn = T.linear().cast<float>();
  frame.T_odom_sensor = T * frame.T_odom_sensor;
  frame.cloud.origin = T * frame.cloud.origin;
  for (Point& p : frame.cloud.points) p.getVector3fMap() = turn * p.getVector3fMap();
  for (Blob& blob : frame.blobs) {
    blob.position = T * blob.position;
    blob.covariance = T.linear() * blob.covariance * T.linear().transpose();
    turnBox(T, blob.min, blob.max);
  }
  return frame;
}

FrameDigest scaledFrame(FrameDigest frame, double factor) {
  frame.T_odom_sensor.translation() *= factor;
  frame.cloud.origin *= factor;
  for (Point& p : frame.cloud.points) {
    p.getVector3fMap() *= static_cast<float>(factor);
    p.sigma *= static_cast<float>(factor);
  }
  for (Blob& blob : frame.blobs) {
    blob.position *= factor;
    blob.covariance *= factor * factor;
    blob.min *= factor;
    blob.max *= factor;
  }
  return frame;
}

Eigen::Quaterniond randomTurn(double angle_rad, Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(x, y, z).normalized()));
}

void addDrift(Session& session, double share, std::uint64_t seed) {
  constexpr double kMemory_m = 60;
  if (share <= 0 || session.frames.empty()) return;
  Random random(seed);
  Wander scale(share, kMemory_m, random);

  Eigen::Isometry3d before = session.frames[0].T_odom_sensor, drifted = before;
  for (std::size_t i = 1; i < session.frames.size(); ++i) {
    const Eigen::Isometry3d now = session.frames[i].T_odom_sensor;
    Eigen::Isometry3d step = before.inverse() * now;
    const double way = step.translation().norm();
    step.translation() *= 1 + scale.after(way);
    const double turn = share * std::sqrt(way / kMemory_m) * random.normal();
    drifted = drifted * step;
    drifted.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * drifted.linear();
    session.frames[i] = movedFrame(std::move(session.frames[i]), drifted * now.inverse());
    before = now;
  }
}

}  // namespace xview::bench
