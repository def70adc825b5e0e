// SPDX-License-Identifier: BSD-3-Clause
// Tiny examples of the layouts of public data sets, written here as their descriptions say.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iomanip>
#include <sstream>

#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

using test::messageOf;
using test::pngBytes;
using test::writeText;

class Dataset : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& bytes) const {
    writeText(folder_ / name, bytes);
  }
  std::string message() const {
    return messageOf([&] { openRecording(folder_.path()); });
  }
  /// Axes of the image in the world.
  static void expectAxes(const Eigen::Isometry3d& T, const Eigen::Vector3d& right,
                         const Eigen::Vector3d& down, const Eigen::Vector3d& forward) {
    Eigen::Matrix3d expected;
    expected << right, down, forward;
    EXPECT_LT((T.linear() - expected).norm(), 1e-5) << T.matrix() << "\nexpected\n" << expected;
  }
  static void expectOptical(const Eigen::Isometry3d& T, const Eigen::Vector3d& forward,
                            const Eigen::Vector3d& down) {
    EXPECT_LT((T.linear() * Eigen::Vector3d::UnitZ() - forward).norm(), 1e-6) << T.matrix();
    EXPECT_LT((T.linear() * Eigen::Vector3d::UnitY() - down).norm(), 1e-6) << T.matrix();
    EXPECT_NEAR(T.linear().determinant(), 1, 1e-9);
  }

  test::TemporaryFolder folder_;
};

class Synthia : public Dataset {
 protected:
  Synthia() {
    for (const char* camera : {"Stereo_Left/Omni_B", "Stereo_Left/Omni_F"}) {
      const bool front = std::string(camera).back() == 'F';
      const std::string stem = std::string(camera) + "/000003";
      const std::uint16_t centimetres = front ? 250 : 1000;
      write("Depth/" + stem + ".png", pngBytes(2, 1, 1, 16, {centimetres, 0}));
      write("GT/LABELS/" + stem + ".png", pngBytes(2, 1, 3, 16, {7, 301, 0, 15, 0, 0}));
      // Columns of the matrix: x right is world x, y up is world y, z forward is world z
      // (left-handed, y up).
      write("CameraParams/" + stem + ".txt", "1 0 0 0 0 1 0 0 0 0 1 0 10 20 30 1\n");
    }
    write("CameraParams/intrinsics.txt", "500\n\n1\n\n0.5\n\n0.8\n");
  }
};

TEST_F(Synthia, TakesClassFromRedAndInstanceFromGreenAndCentimetres) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::synthia);
  InputOptions options;
  const auto source = openRecording(folder_ / "Depth/Stereo_Left/Omni_F", options);
  ASSERT_EQ(source->size(), 1u);
  EXPECT_EQ(source->labels().name(), "synthia");
  const Frame frame = source->read(0);
  EXPECT_EQ(frame.number, 3);
  EXPECT_EQ(frame.depth.pixels, (std::vector<float>{2.5f, 0}));
  EXPECT_EQ(frame.label.pixels, (std::vector<std::uint16_t>{7, 15}));
  EXPECT_EQ(frame.instance.pixels, (std::vector<std::uint16_t>{301, 0}));
  EXPECT_EQ(frame.camera.fx, 500);
  EXPECT_EQ(frame.camera.cy, 0.5);
  EXPECT_EQ(frame.camera.width, 2);
}

TEST_F(Synthia, TurnsPosesIntoAWorldWithZUp) {
  const Eigen::Isometry3d T = openRecording(folder_.path())->pose(0);
  EXPECT_EQ(T.translation(), Eigen::Vector3d(10, 30, 20));
  expectOptical(T, Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitZ());
}

// A camera that has turned 30 degrees to the left, from x right and z ahead, in both handednesses
// in which its axes may be given: z ahead, and z back as in OpenGL.
TEST_F(Synthia, TakesColumnsOfTheMatrixOneAfterTheOtherForEitherHandOfTheCamera) {
  const double c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
  for (const int z_sign : {1, -1}) {
    std::ostringstream matrix;
    matrix << std::setprecision(17);
    matrix << c << " 0 " << s << " 0  0 1 0 0  " << -s * z_sign << " 0 " << c * z_sign
           << " 0  10 20 30 1\n";
    write("CameraParams/Stereo_Left/Omni_B/000003.txt", matrix.str());
    const Eigen::Isometry3d T = openRecording(folder_.path())->pose(0);
    expectAxes(T, {c, s, 0}, {0, 0, -1}, {-s, c, 0});
    EXPECT_EQ(T.translation(), Eigen::Vector3d(10, 30, 20));
  }
}

TEST_F(Synthia, KnowsThePublishedCameraAndItsFiveFramesPerSecond) {
  const Camera own = openRecording(folder_.path())->read(0).camera;
  EXPECT_EQ(own.fy, 500);
  EXPECT_EQ(own.cx, 1);
  EXPECT_FALSE(own.depth_is_range);
  std::filesystem::remove(folder_ / "CameraParams/intrinsics.txt");
  const auto source = openRecording(folder_.path());
  const Camera camera = source->read(0).camera;
  EXPECT_EQ(camera.fx, 532.740352);
  EXPECT_EQ(camera.fy, 532.740352);
  EXPECT_EQ(camera.cx, 640);
  EXPECT_EQ(camera.cy, 380);
  EXPECT_DOUBLE_EQ(source->stamp(0), 0.6);
}

TEST_F(Synthia, TakesTheFirstCameraUnlessOneIsNamed) {
  EXPECT_EQ(openRecording(folder_.path())->read(0).depth.at(0, 0), 10);
}

TEST_F(Synthia, ThatIsDamagedSaysWhere) {
  const std::string pose = folder_ / "CameraParams/Stereo_Left/Omni_B/000003.txt";
  write("CameraParams/Stereo_Left/Omni_B/000003.txt", "1 0 0 0 0 1 0 0\n");
  EXPECT_EQ(message(), pose + ": expected a 4x4 matrix, found 8 numbers");
  write("CameraParams/Stereo_Left/Omni_B/000003.txt", "2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
  EXPECT_EQ(message(), pose + ": the 4x4 matrix is not a rigid transform");
}

class Airsim : public Dataset {
 protected:
  Airsim() {
    write("classes.yaml",
          "- {id: 3, name: road, color: [10, 20, 30]}\n- {id: 9, name: tree, color: [1, 2, 3]}\n");
    write("airsim_rec.txt",
          "VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"
          "\t1500\t1\t2\t-3\t1\t0\t0\t0\timg__0_0_7.png;img__0_1_7.pfm;img__0_5_7.png\n"
          "\t1600\t1\t2\t-3\t1\t0\t0\t0\timg__0_0_8.png\n");
    // Its recorder writes the upper row first; pfmBytes, as the format says, the last one given.
    write("images/img__0_1_7.pfm", test::pfmBytes(2, 2, {6, 7, 4, 5}, true));
    write("images/img__0_5_7.png",
          pngBytes(2, 2, 3, 8, {10, 20, 30, 9, 9, 9, 1, 2, 3, 30, 20, 10}));
  }
  /// One row with this position, orientation and list of images.
  void writeRow(const std::string& pose, const std::string& images) const {
    write("airsim_rec.txt",
          "VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"
          "\t1500\t" +
              pose + "\t" + images + "\n");
  }
};

TEST_F(Airsim, TakesRowsWithDepthAndSegmentation) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::airsim);
  const auto source = openRecording(folder_.path());
  ASSERT_EQ(source->size(), 1u);
  const Frame frame = source->read(0);
  EXPECT_EQ(frame.stamp_s, 1.5);
  EXPECT_EQ(frame.depth.pixels, (std::vector<float>{4, 5, 6, 7}));
  EXPECT_EQ(frame.label.pixels, (std::vector<std::uint16_t>{3, 0, 9, 0}));
  EXPECT_EQ(frame.camera.fx, 1);  // 90 degrees
  EXPECT_EQ(frame.camera.cx, 0.5);
  EXPECT_FALSE(frame.camera.depth_is_range);
}

TEST_F(Airsim, DepthOfTypeTwoIsAlongTheRayWhateverTheCameraFileSays) {
  write("images/img__0_2_7.pfm", test::pfmBytes(2, 2, {6, 7, 4, 5}, true));
  writeRow("0\t0\t0\t1\t0\t0\t0", "img__0_2_7.pfm;img__0_5_7.png");
  EXPECT_TRUE(openRecording(folder_.path())->read(0).camera.depth_is_range);
  write("camera.yaml", "width: 2\nheight: 2\nfx: 3\nfy: 3\ncx: 1\ncy: 1\ndepth_scale: 0.01\n");
  const Camera camera = openRecording(folder_.path())->read(0).camera;
  EXPECT_TRUE(camera.depth_is_range);
  EXPECT_EQ(camera.fx, 3);
}

TEST_F(Airsim, DepthInAPngHasTheScaleOfTheCameraFileAndItsRowsFromTheTop) {
  write("images/img__0_1_7.png", pngBytes(2, 2, 1, 16, {100, 200, 300, 400}));
  writeRow("0\t0\t0\t1\t0\t0\t0", "img__0_1_7.png;img__0_5_7.png");
  EXPECT_EQ(message(), (folder_ / "camera.yaml") +
                           ": needed for depth that is not .pfm: width, height, fx, fy, cx, cy, "
                           "depth_scale");
  write("camera.yaml", "width: 2\nheight: 2\nfx: 3\nfy: 3\ncx: 1\ncy: 1\ndepth_scale: 0.01\n");
  EXPECT_EQ(openRecording(folder_.path())->read(0).depth.pixels, (std::vector<float>{1, 2, 3, 4}));
}

// North-east-down: yaw 90 degrees turns to the east, pitch 30 degrees lifts the nose.
TEST_F(Airsim, TurnsAndClimbsAsItsQuaternionSays) {
  const double half = std::sqrt(0.5), c = std::cos(M_PI / 12), s = std::sin(M_PI / 12);
  const auto text = [](double w, double x, double y, double z) {
    std::ostringstream words;
    words << std::setprecision(17) << "0\t0\t0\t" << w << "\t" << x << "\t" << y << "\t" << z;
    return words.str();
  };
  writeRow(text(half, 0, 0, half), "img__0_1_7.pfm;img__0_5_7.png");
  expectAxes(openRecording(folder_.path())->pose(0), {-1, 0, 0}, {0, 0, -1}, {0, -1, 0});
  writeRow(text(c, 0, s, 0), "img__0_1_7.pfm;img__0_5_7.png");
  const double cos30 = std::cos(M_PI / 6);
  expectAxes(openRecording(folder_.path())->pose(0), {0, -1, 0}, {0.5, 0, -cos30}, {cos30, 0, 0.5});
  // Rolled to the right by 30 degrees: what is right in the image lies lower.
  writeRow(text(c, s, 0, 0), "img__0_1_7.pfm;img__0_5_7.png");
  expectAxes(openRecording(folder_.path())->pose(0), {0, -cos30, -0.5}, {0, 0.5, -cos30},
             {1, 0, 0});
}

TEST_F(Airsim, DepthAndSegmentationAreOfOneCamera) {
  writeRow("0\t0\t0\t1\t0\t0\t0", "img_drone_front_center_1_7.pfm;img_drone_back_center_5_7.png");
  EXPECT_EQ(message(), (folder_ / "airsim_rec.txt") +
                           ": no row has images of depth and segmentation of one camera");
}

TEST_F(Airsim, RowsWithDepthOfTwoTypesAreRefused) {
  write("airsim_rec.txt",
        "TimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"
        "1\t0\t0\t0\t1\t0\t0\t0\timg__0_1_7.pfm;img__0_5_7.png\n"
        "2\t0\t0\t0\t1\t0\t0\t0\timg__0_2_7.pfm;img__0_5_7.png\n");
  EXPECT_EQ(message(),
            (folder_ / "airsim_rec.txt") +
                ":3: depth of type 2 after depth of type 1; expected one type (1: planar, "
                "2: along the ray) in all rows");
}

TEST_F(Airsim, TurnsNorthEastDownIntoZUp) {
  const Eigen::Isometry3d T = openRecording(folder_.path())->pose(0);
  EXPECT_EQ(T.translation(), Eigen::Vector3d(1, -2, 3));
  expectOptical(T, Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ());
}

TEST_F(Airsim, ACameraIsMountedAsTheUserOrTheSettingsSay) {
  const std::string images = "img_drone_0_1_7.pfm;img_drone_0_5_7.png";
  for (const char* name : {"img_drone_0_1_7.pfm", "img_drone_0_5_7.png"})
    std::filesystem::copy(folder_ / (std::string("images/img__") + (name + 10)),
                          folder_ / (std::string("images/") + name));
  writeRow("0\t0\t-5\t1\t0\t0\t0", images);
  InputOptions options;
  options.mount = "0.5,0,0.1,0,-90,0";
  const Eigen::Isometry3d T = openRecording(folder_.path(), options)->pose(0);
  // Looks down; the upper edge of the image is ahead.
  expectAxes(T, {0, -1, 0}, {-1, 0, 0}, {0, 0, -1});
  EXPECT_LT((T.translation() - Eigen::Vector3d(0.5, 0, 4.9)).norm(), 1e-9);

  EXPECT_FALSE(openRecording(folder_.path())->notes().empty()) << "that it looks ahead is a guess";
  write("settings.json",
        "{\"SettingsVersion\": 1.2, \"Vehicles\": {\"drone\": {\"Cameras\": {\n"
        "  \"1\": {\"X\": 9, \"Yaw\": 180},\n"
        "  \"0\": {\"X\": 0.5, \"Y\": 0, \"Z\": 0.1, \"Pitch\": -90, \"Roll\": 0, \"Yaw\": 0,\n"
        "  \"CaptureSettings\": [{\"ImageType\": 1, \"FOV_Degrees\": 53.13010235}]}}}}}\n");
  const auto source = openRecording(folder_.path());
  EXPECT_LT((source->pose(0).matrix() - T.matrix()).norm(), 1e-9);
  EXPECT_TRUE(source->notes().empty());
  EXPECT_NEAR(source->read(0).camera.fx, 2, 1e-6) << "half a width of one over a half";
  options.mount = "0,0,0,0,0,0";
  EXPECT_EQ(openRecording(folder_.path(), options)->pose(0).translation().z(), 5);
  options.mount = "0,0,0";
  EXPECT_THROW(openRecording(folder_.path(), options), UsageError);
}

TEST_F(Airsim, WithoutClassesTheColoursOfItsPaletteAreNamelessIds) {
  std::filesystem::remove(folder_ / "classes.yaml");
  write("images/img__0_5_7.png",
        pngBytes(2, 2, 3, 8, {153, 108, 6, 43, 47, 206, 1, 2, 3, 153, 108, 6}));
  const auto source = openRecording(folder_.path());
  EXPECT_TRUE(source->labels().isGeneric());
  EXPECT_EQ(source->read(0).label.pixels, (std::vector<std::uint16_t>{1, 255, 0, 1}));
}

TEST_F(Airsim, ThatIsDamagedSaysWhere) {
  const std::string path = folder_ / "airsim_rec.txt";
  write("airsim_rec.txt", "VehicleName\tTimeStamp\n");
  EXPECT_EQ(message(), path + ":1: no column POS_X");
  write("airsim_rec.txt", "TimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n1\t2\n");
  EXPECT_EQ(message(), path + ":2: expected 9 columns, found 2");
}

class TumRgbd : public Dataset {
 protected:
  TumRgbd() {
    write("depth.txt", "# depth maps\n10.00 depth/10.00.png\n10.10 depth/10.10.png\n");
    write("rgb.txt", "10.01 rgb/10.01.png\n10.11 rgb/10.11.png\n");
    write("groundtruth.txt", "9.975 0 0 0 0 0 0 1\n10.05 3 0 0 0 0 0 1\n10.15 5 0 0 0 0 0 1\n");
    write("camera.yaml", "width: 1\nheight: 1\nfx: 1\nfy: 1\ncx: 0\ncy: 0\ndepth_scale: 0.0002\n");
    for (const char* stem : {"10.00", "10.10"}) {
      write(std::string("depth/") + stem + ".png", pngBytes(1, 1, 1, 16, {5000}));
    }
    write("label/10.01.png", pngBytes(1, 1, 1, 8, {4}));
    write("label/10.10.png", pngBytes(1, 1, 1, 8, {6}));
  }
};

TEST_F(TumRgbd, FindsLabelsByEitherNameAndPosesBetweenTheirStamps) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::tum_rgbd);
  const auto source = openRecording(folder_.path());
  ASSERT_EQ(source->size(), 2u);
  EXPECT_NEAR(source->pose(0).translation().x(), 1, 1e-9);
  EXPECT_NEAR(source->pose(1).translation().x(), 4, 1e-9);
  EXPECT_EQ(source->stamp(1), 10.10);
  EXPECT_EQ(source->read(0).label.at(0, 0), 4);
  EXPECT_EQ(source->read(1).label.at(0, 0), 6);
  EXPECT_FLOAT_EQ(source->read(1).depth.at(0, 0), 1);
  EXPECT_EQ(source->labels().name(), "generic");
}

TEST_F(TumRgbd, HasTheKinectOfThePublishedSequencesUnlessTheFolderSaysOtherwise) {
  std::filesystem::remove(folder_ / "camera.yaml");
  std::filesystem::remove(folder_ / "label/10.10.png");
  write("depth/10.00.png", pngBytes(640, 480, 1, 16, std::vector<std::uint16_t>(640 * 480, 2500)));
  write("label/10.01.png", pngBytes(640, 480, 1, 8, std::vector<std::uint16_t>(640 * 480, 4)));
  const Frame frame = openRecording(folder_.path())->read(0);
  EXPECT_EQ(frame.depth.at(7, 7), 0.5f);
  EXPECT_EQ(frame.camera.fx, 525);
  EXPECT_EQ(frame.camera.fy, 525);
  EXPECT_EQ(frame.camera.cx, 319.5);
  EXPECT_EQ(frame.camera.cy, 239.5);
  EXPECT_FALSE(frame.camera.depth_is_range);
}

// Position and orientation of the camera in the world, the quaternion with its real part last.
TEST_F(TumRgbd, PosesAreThoseOfTheCameraInTheWorld) {
  write("groundtruth.txt",
        "9.95 1 2 3 0 0 0.70710678118 0.70710678118\n10.05 1 2 3 0 0 0.70710678118 "
        "0.70710678118\n10.20 1 2 3 0 0 1 0\n");
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->pose(0).translation(), Eigen::Vector3d(1, 2, 3));
  expectAxes(source->pose(0), {0, 1, 0}, {-1, 0, 0}, {0, 0, 1});
  const double sine = std::sin(M_PI / 3);  // a third of the way from 90 to 180 degrees
  expectAxes(source->pose(1), {-0.5, sine, 0}, {-sine, -0.5, 0}, {0, 0, 1});
}

TEST_F(TumRgbd, LabelsOfAnotherTimeAndPosesFarApartAreNotUsed) {
  write("rgb.txt", "10.03 rgb/10.01.png\n10.13 rgb/10.11.png\n");
  EXPECT_EQ(openRecording(folder_.path())->size(), 1u);  // the one with a label of its own name
  write("groundtruth.txt", "9.95 0 0 0 0 0 0 1\n10.16 3 0 0 0 0 0 1\n");
  EXPECT_NE(message().find("have no pose within 0.2 s"), std::string::npos);
}

TEST_F(TumRgbd, LeavesOutFramesWithoutLabelOrPose) {
  std::filesystem::remove(folder_ / "label/10.01.png");
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->size(), 1u);
  EXPECT_EQ(source->notes().at(0).find("1 of 2 depth images are left out; 1 have no label image"),
            0u)
      << source->notes().at(0);
  write("groundtruth.txt", "9.95 0 0 0 0 0 0 1\n");
  const std::string found = message();
  EXPECT_EQ(
      found.find((folder_ / "depth.txt") +
                 ": no usable frame: 2 of 2 depth images are left out; 1 have no label image"),
      0u)
      << found;
  EXPECT_NE(found.find("; 1 have no pose within 0.2 s"), std::string::npos) << found;
}

TEST_F(TumRgbd, ANameThatNoFileCanHaveIsRefusedInAShortLine) {
  for (const std::string& name : {std::string(300, 'x'), "depth/" + std::string(100000, 'x')}) {
    write("depth.txt", "10.00 depth/10.00.png\n10.10 " + name + "\n");
    const std::string found = message();
    EXPECT_EQ(found.find((folder_ / "depth.txt") + ":2: expected the name of a file"), 0u)
        << found.substr(0, 200);
    EXPECT_LT(found.size(), folder_.path().size() + 150);
  }
}

class VirtualKitti : public Dataset {
 protected:
  VirtualKitti() {
    write("colors.txt", "Category r g b\nTerrain 210 0 200\nPole 255 130 0\n");
    write("intrinsic.txt",
          "frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n0 0 725 725 1 0\n0 1 1 1 1 1\n");
    write("extrinsic.txt",
          "frame cameraID r1,1 …\n"
          "0 0 1 0 0 0 0 1 0 0 0 0 1 -5 0 0 0 1\n"
          "0 1 1 0 0 9 0 1 0 9 0 0 1 9 0 0 0 1\n");
    write("frames/depth/Camera_0/depth_00000.png", pngBytes(2, 1, 1, 16, {1234, 65535}));
    write("frames/classSegmentation/Camera_0/classgt_00000.png",
          pngBytes(2, 1, 3, 8, {255, 130, 0, 210, 0, 200}));
  }
};

TEST_F(VirtualKitti, ReadsColoursCentimetresAndCameraZero) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::virtual_kitti);
  const auto source = openRecording(folder_.path());
  ASSERT_EQ(source->size(), 1u);
  const Frame frame = source->read(0);
  EXPECT_EQ(frame.depth.pixels, (std::vector<float>{12.34f, 0}));
  EXPECT_EQ(source->labels().kind(frame.label.at(0, 0)), Kind::pole);
  EXPECT_EQ(source->labels().kind(frame.label.at(1, 0)), Kind::terrain);
  EXPECT_EQ(frame.camera.fx, 725);
}

TEST_F(VirtualKitti, TurnsPosesIntoAWorldWithZUp) {
  const Eigen::Isometry3d T = openRecording(folder_.path())->pose(0);
  EXPECT_LT((T.translation() - Eigen::Vector3d(5, 0, 0)).norm(), 1e-9);
  expectOptical(T, Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ());
}

// The table takes points of the world (x right, y down, z ahead at the start) to the camera. This
// camera stands at world (2, 0, 7) and looks to the right.
TEST_F(VirtualKitti, PosesAreTheInverseOfWorldToCameraRowByRow) {
  write("extrinsic.txt", "frame cameraID r1,1 …\n0 0 0 0 -1 7 0 1 0 0 1 0 0 -2 0 0 0 1\n");
  const auto source = openRecording(folder_.path());
  const Eigen::Isometry3d T = source->pose(0);
  // In the world with z up: ahead is x, right is -y.
  EXPECT_LT((T.translation() - Eigen::Vector3d(7, -2, 0)).norm(), 1e-9) << T.translation();
  expectAxes(T, {-1, 0, 0}, {0, 0, -1}, {0, -1, 0});
  EXPECT_EQ(source->stamp(0), 0);
}

TEST_F(VirtualKitti, HasTheCameraOfTheFirstRowOfCameraZero) {
  write("intrinsic.txt",
        "frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n0 1 1 1 1 1\n0 0 725 726 620 187\n");
  const Camera camera = openRecording(folder_.path())->read(0).camera;
  EXPECT_EQ(camera.fx, 725);
  EXPECT_EQ(camera.fy, 726);
  EXPECT_EQ(camera.cx, 620);
  EXPECT_EQ(camera.cy, 187);
  EXPECT_EQ(camera.width, 2);
  EXPECT_EQ(camera.height, 1);
  EXPECT_FALSE(camera.depth_is_range);
}

TEST_F(VirtualKitti, ThatIsDamagedSaysWhere) {
  write("extrinsic.txt", "frame\n7 0 1 0 0 0 0 1 0 0 0 0 1 -5 0 0 0 1\n");
  EXPECT_EQ(message(), (folder_ / "extrinsic.txt") + ": no row for frame 0 of camera 0");
  write("colors.txt", "Category r g b\nLamp 1 2 3\n");
  write("extrinsic.txt", "0 0 1 0 0 0 0 1 0 0 0 0 1 -5 0 0 0 1\n");
  EXPECT_EQ(message(), (folder_ / "colors.txt") + ":2: unknown category 'Lamp'");
}

class Carla : public Dataset {
 protected:
  Carla() {
    write("camera.yaml", "width: 2\nheight: 1\nfx: 1\nfy: 1\ncx: 0\ncy: 0\ndepth_scale: 1\n");
    write("poses.txt", "0 1 2 3 0 0 0 1\n");
    write("depth/0001.png", pngBytes(2, 1, 4, 8, {1, 2, 3, 255, 255, 255, 255, 255}));
    writeTags(7, 12);
  }
  void writeTags(std::uint16_t a, std::uint16_t b) const {
    write("semantic/0001.png", pngBytes(2, 1, 4, 8, {a, 0, 0, 255, b, 0, 0, 255}));
  }
};

TEST_F(Carla, DecodesDepthAndTags) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::carla);
  const Frame frame = openRecording(folder_.path())->read(0);
  EXPECT_NEAR(frame.depth.at(0, 0), 1000.0 * (1 + 2 * 256 + 3 * 65536) / 16777215, 1e-4);
  EXPECT_EQ(frame.depth.at(1, 0), 0);
  EXPECT_EQ(frame.label.pixels, (std::vector<std::uint16_t>{7, 12}));
  EXPECT_EQ(frame.T_odom_sensor.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST_F(Carla, DepthIsAShareOfAKilometreAlongTheAxis) {
  write("depth/0001.png", pngBytes(2, 1, 3, 8, {0, 0, 128, 255, 255, 254}));
  write("semantic/0001.png", pngBytes(2, 1, 3, 8, {7, 0, 0, 7, 0, 0}));
  const Frame frame = openRecording(folder_.path())->read(0);
  EXPECT_NEAR(frame.depth.at(0, 0), 500.00003, 1e-4);
  EXPECT_NEAR(frame.depth.at(1, 0), 996.09, 1e-2);
  EXPECT_FALSE(frame.camera.depth_is_range);
}

TEST_F(Carla, PosesAreThoseOfTheOpticalFrame) {
  write("poses.txt", "0.5 1 2 3 0 0 0.70710678118 0.70710678118\n");
  const auto source = openRecording(folder_.path());
  EXPECT_EQ(source->stamp(0), 0.5);
  expectAxes(source->pose(0), {0, 1, 0}, {-1, 0, 0}, {0, 0, 1});
}

TEST_F(Carla, TellsTheTwoNumberingsApart) {
  EXPECT_EQ(openRecording(folder_.path())->labels().name(), "carla");
  writeTags(1, 3);
  EXPECT_EQ(openRecording(folder_.path())->labels().name(), "carla_0_9_14");
  writeTags(7, 24);
  EXPECT_EQ(openRecording(folder_.path())->labels().name(), "carla_0_9_14");
}

TEST_F(Carla, WithDepthInOneChannelSaysWhatIsExpected) {
  write("depth/0001.png", pngBytes(2, 1, 1, 16, {1, 2}));
  const std::string found = messageOf([&] { openRecording(folder_.path())->read(0); });
  EXPECT_EQ(found, (folder_ / "depth/0001.png") +
                       ": expected depth coded in 8-bit colours, found 16-bit unsigned, 1 channel");
}

}  // namespace
}  // namespace xview::io
