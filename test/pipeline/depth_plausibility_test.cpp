// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/depth_plausibility.h"

#include <gtest/gtest.h>

#include "pipeline/simulated_drive.h"
#include "xview/types/error.h"

namespace xview {
namespace {

using test::simulatedDrive;

/// The forward drive, its depths times a factor.
class ScaledRecording : public FrameSource {
 public:
  explicit ScaledRecording(float factor, bool stands = false) : factor_(factor), stands_(stands) {}
  std::size_t size() const override { return 8; }
  Eigen::Isometry3d pose(std::size_t i) const override { return drive().pose(stands_ ? 0 : i); }
  double stamp(std::size_t i) const override { return drive().stamp(i); }
  std::int64_t number(std::size_t i) const override { return drive().number(i); }
  Frame read(std::size_t i) const override {
    Frame frame = drive().read(stands_ ? 0 : i);
    for (float& z : frame.depth.pixels) z *= factor_;
    return frame;
  }
  Sensor sensor() const override { return Sensor::camera; }
  const LabelSet& labels() const override { return drive().labels(); }
  const std::string& name() const override { return name_; }

 private:
  static const FrameSource& drive() { return *simulatedDrive().sessions.at("forward"); }
  float factor_;
  bool stands_;
  std::string name_ = "scaled";
};

std::string complaintAbout(const FrameSource& source) {
  try {
    digestRecording(source, {});
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(DepthPlausibility, DepthsAHundredOrAThousandTimesOffAreNamed) {
  for (const float factor : {0.001f, 0.01f, 100.f, 1000.f}) {
    const std::string complaint = complaintAbout(ScaledRecording(factor));
    EXPECT_EQ(complaint.rfind("scaled: ", 0), 0u) << factor << ": " << complaint;
    EXPECT_NE(complaint.find("depth_scale"), std::string::npos) << factor << ": " << complaint;
    EXPECT_EQ(complaint.find('\n'), std::string::npos);
  }
}

TEST(DepthPlausibility, DepthsTenTimesTooSmallContradictTheMotion) {
  const std::string complaint = complaintAbout(ScaledRecording(0.1f));
  EXPECT_NE(complaint.find("10 times"), std::string::npos) << complaint;
}

TEST(DepthPlausibility, MapsAreNotMadeOfWrongDepths) {
  const ScaledRecording wrong(0.001f);
  EXPECT_THROW(buildMap({&wrong}, {}), Error);
}

TEST(DepthPlausibility, RightDepthsPass) { EXPECT_EQ(complaintAbout(ScaledRecording(1)), ""); }

TEST(DepthPlausibility, ASmallRoomSeenByACameraThatMovesAsMuchPasses) {
  // The whole world ten times smaller: depths are small and poses agree with them.
  struct Model : ScaledRecording {
    Model() : ScaledRecording(0.1f) {}
    Eigen::Isometry3d pose(std::size_t i) const override { return shrunk(ScaledRecording::pose(i)); }
    Frame read(std::size_t i) const override {
      Frame frame = ScaledRecording::read(i);
      frame.T_odom_sensor = shrunk(frame.T_odom_sensor);
      return frame;
    }
    static Eigen::Isometry3d shrunk(Eigen::Isometry3d T) {
      T.translation() *= 0.1;
      return T;
    }
  } model;
  Options options;
  options.lift.min_range_m = 0.03;
  EXPECT_NO_THROW(digestRecording(model, options));
}

TEST(DepthPlausibility, ACameraThatStandsStillTellsNothing) {
  EXPECT_NO_THROW(digestRecording(ScaledRecording(0.1f, true), {}));
}

TEST(DepthPlausibility, FramesAgreeMostAtTheRightScale) {
  const auto& forward = *simulatedDrive().sessions.at("forward");
  const Frame a = forward.read(10), b = forward.read(11);
  const DepthAgreement right = agreementOfDepths(a, b, 1);
  EXPECT_GT(right.agreeing, 0.9);
  EXPECT_GT(right.visible, 0.2);
  for (const double wrong : {0.01, 0.1, 10.0, 100.0}) EXPECT_LT(agreementOfDepths(a, b, wrong).agreeing, right.agreeing - 0.1) << wrong;
  EXPECT_GT(agreementOfDepths(a, a, 1).agreeing, 0.99);
}

}  // namespace
}  // namespace xview
