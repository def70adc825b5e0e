// SPDX-License-Identifier: BSD-3-Clause
// make_seeds FOLDER: inputs of binary formats to begin with, in FOLDER/TARGET. Those of text
// formats are in the source tree.
#include <sqlite3.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "io/image_files.h"
#include "support/bags.h"
#include "support/e57.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"
#include "xview/map/semantic_map.h"

namespace {

namespace fs = std::filesystem;
using namespace xview;

std::string bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

LabelledCloud someCloud() {
  LabelledCloud cloud;
  for (int i = 0; i < 20; ++i) {
    const auto x = static_cast<float>(i);
    cloud.points.emplace_back(x, 0.5F * x, 0.1F * x, static_cast<std::uint32_t>(i % 3));
    cloud.points.back().instance = static_cast<std::uint32_t>(i / 4);
  }
  return cloud;
}

map::SemanticMap someMap() {
  map::SemanticMap map;
  map.labels = LabelSet("seed");
  map.labels.add({1, "pole", {200, 0, 0}, Role::object, Kind::pole});
  map.cloud = someCloud();
  for (int i = 0; i < 5; ++i) {
    Vertex vertex;
    vertex.label = 1;
    vertex.position = Eigen::Vector3d(3 * i, i % 2, 0);
    map.graph.vertices.push_back(vertex);
  }
  map.graph.setEdges({{0, 1}, {1, 2}, {3, 4}});
  map.bev.samples[0].push_back({1, 2, 0});
  map.bev.known.push_back({0, 0, 0.0F, true});
  map.sources = {"seed"};
  map.addKeyframe(Eigen::Isometry3d::Identity(), 0, 0, 0);
  return map;
}

void makeImages(const std::string& folder) {
  fs::create_directories(folder);
  const cv::Mat depth(6, 8, CV_16U, cv::Scalar(500)), label(6, 8, CV_8U, cv::Scalar(3)),
      metres(6, 8, CV_32F, cv::Scalar(2.5)), color(6, 8, CV_8UC3, cv::Scalar(1, 90, 200));
  cv::imwrite(folder + "/depth.png", depth);
  cv::imwrite(folder + "/label.png", label);
  cv::imwrite(folder + "/color.png", color);
  cv::imwrite(folder + "/color.jpg", color);
  cv::imwrite(folder + "/metres.tiff", metres);
  cv::imwrite(folder + "/metres.exr", metres);
  cv::imwrite(folder + "/label.tiff", label);
}

/// Every kind of message that is read.
std::vector<test::BagMessage> someMessages(test::Wire wire) {
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  std::vector<test::BagMessage> messages = {
      {"/tf_static", "tf2_msgs/TFMessage", 1, test::transformsMessage(wire, {{0, "base", "l", T}})},
      {"/camera_info", "sensor_msgs/CameraInfo", 1, test::cameraInfoMessage(wire, "c", 2, 1, 5)}};
  for (int i = 0; i < 3; ++i) {
    const std::int64_t log_ns = i;
    test::MessageWriter image(wire), pose(wire);
    image.header(1 + i, "c").number(1U).number(2U).text("16UC1").number(std::uint8_t{0});
    image.number(4U).number(4U).raw("abcd");
    pose.header(1 + i, "odom").pose(T);
    messages.push_back(
        {"/o", "nav_msgs/Odometry", log_ns, test::odometryMessage(wire, 1 + i, "odom", "base", T)});
    messages.push_back({"/pose", "geometry_msgs/PoseStamped", log_ns, pose.bytes()});
    messages.push_back({"/tf", "tf2_msgs/TFMessage", log_ns,
                        test::transformsMessage(wire, {{1.0 + i, "odom", "base", T}})});
    messages.push_back(
        {"/points", "sensor_msgs/PointCloud2", log_ns,
         test::labelledCloudMessage(wire, 1 + i, "l", {{1, 2, 3, 4}, {5, 6, 7, 8}})});
    messages.push_back({"/livox", "livox_ros_driver2/CustomMsg", log_ns,
                        test::livoxMessage(wire, 1 + i, "l", {{1, 2, 3}})});
    messages.push_back({"/image", "sensor_msgs/Image", log_ns, image.bytes()});
  }
  return messages;
}

/// Changes a byte of every record that begins with these bytes.
std::string withByte(std::string log, const std::string& begin, std::size_t at, char value) {
  for (auto found = log.find(begin); found != std::string::npos; found = log.find(begin, found + 1))
    if (found + at < log.size()) log[found + at] = value;
  return log;
}

/// Indices that name messages of other channels, or one message twice, and databases that define
/// what computes.
void makeLyingBags(const std::string& root) {
  const auto messages = someMessages(test::Wire::cdr_little);
  const std::string one_entry = std::string("\7\x16\0\0\0\0\0\0\0", 9);
  const std::string mcap = test::mcapBytes(messages, {});
  std::ofstream(root + "/mcap/channels.mcap", std::ios::binary) << withByte(mcap, one_entry, 9, 5);
  std::ofstream(root + "/mcap/twice.mcap", std::ios::binary) << withByte(mcap, one_entry, 23, 0);
  std::ofstream(root + "/rosbag/channels.bag", std::ios::binary)
      << withByte(test::rosBagBytes(someMessages(test::Wire::ros1), {}), "conn=", 5, 3);
  const std::pair<const char*, const char*> schemas[] = {
      {"view",
       "DROP TABLE topics; CREATE VIEW Topics AS SELECT 1 AS id, 'p' AS name, 'x' AS type, "
       "'cdr' AS serialization_format"},
      {"both",
       "PRAGMA writable_schema = ON; INSERT INTO sqlite_master(rowid, type, name, tbl_name, "
       "rootpage, sql) VALUES(-5, 'table', 'MESSAGES', 'MESSAGES', 0, 'CREATE VIEW MESSAGES "
       "AS SELECT 1 AS topic_id, 1 AS timestamp')"},
      {"computed", "ALTER TABLE messages ADD COLUMN size INTEGER AS (length(data))"},
      {"trigger", "CREATE TRIGGER t AFTER INSERT ON topics BEGIN SELECT 1; END"}};
  for (const auto& [name, sql] : schemas) {
    const std::string path = root + "/db3/" + name + ".db3";
    test::writeDatabase(path, messages);
    sqlite3* database = nullptr;
    sqlite3_open(path.c_str(), &database);
    sqlite3_exec(database, sql, nullptr, nullptr, nullptr);
    sqlite3_close(database);
  }
}

void makeBags(const std::string& root) {
  using test::Wire;
  const auto little = someMessages(Wire::cdr_little), big = someMessages(Wire::cdr_big);
  for (const char* compression : {"", "zstd", "lz4", "bz2"}) {
    test::LogShape shape;
    shape.compression = compression;
    const std::string name = std::string(compression) + "_seed";
    test::writeBag(root + "/mcap/" + name + ".mcap", *compression ? big : little, shape);
    test::writeBag(root + "/rosbag/" + name + ".bag", someMessages(Wire::ros1), shape);
    // One kind of message each, for the readers behind the containers.
    for (const test::BagMessage& message : little)
      test::writeBag(root + "/mcap" + message.topic + ".mcap", {message, message}, {});
  }
  fs::create_directories(root + "/db3");
  test::writeDatabase(root + "/db3/seed.db3", little);
  makeLyingBags(root);
}

/// Scans without sums, as the target `e57` takes them.
void makeE57(const std::string& folder) {
  test::E57Points packed, angles;
  packed.columns = {test::e57Whole("cartesianX", -500, 500, "scale=\"0.01\""),
                    test::e57Real("cartesianY", 32), test::e57Real("cartesianZ", 64),
                    test::e57Whole("label", 0, 20), test::e57Whole("cartesianInvalidState", 0, 2)};
  angles.columns = {test::e57Real("sphericalRange", 32), test::e57Real("sphericalAzimuth", 32),
                    test::e57Real("sphericalElevation", 32), test::e57Whole("label", 3, 3)};
  for (int i = 0; i < 20; ++i) {
    packed.rows.push_back({10.0 * i, 0.5 * i, 1, 1.0 * i, i == 7 ? 1.0 : 0.0});
    angles.rows.push_back({1.0 * i, 0.1 * i, 0.2, 3});
  }
  packed.packets = 3;
  packed.has_index = true;
  angles.pose = "<pose><rotation><w>1</w></rotation><translation><x>1</x></translation></pose>\n";
  std::ofstream(folder + "/packed.e57", std::ios::binary) << test::e57Content({packed});
  std::string attributes = "<any";
  for (int i = 0; i < 200; ++i) attributes += " b" + std::to_string(i) + "=\">\"";
  std::ofstream(folder + "/attributes.e57", std::ios::binary)
      << test::e57Content({packed}, "<data3D", attributes + "/><data3D");
  std::ofstream(folder + "/two.e57", std::ios::binary) << test::e57Content({packed, angles});
}

/// The files of a folder in the form of the targets `layouts` and `tiles`.
void pack(const std::string& folder, const std::string& seed) {
  std::string all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    all += (all.empty() ? "@@ " : "\n@@ ") + fs::relative(entry.path(), folder).string() + "\n" +
           bytesOf(entry.path().string());
  }
  std::ofstream(seed, std::ios::binary) << all;
}

void write(const std::string& path, const std::string& bytes) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

constexpr const char* kCamera =
    "width: 8\nheight: 6\nfx: 8\nfy: 8\ncx: 3.5\ncy: 2.5\ndepth_scale: 0.01\n";
constexpr const char* kTwoPoses = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n";
constexpr const char* kTwoRows = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";

void makeRecordings(const std::string& images, const std::string& work, const std::string& out) {
  const std::string depth = bytesOf(images + "/depth.png"), label = bytesOf(images + "/label.png"),
                    color = bytesOf(images + "/color.png");
  const auto layout = [&](const char* name, auto&& fill) {
    fill(work + "/" + name + "/");
    pack(work + "/" + name, out + "/" + name);
  };
  layout("sequence", [&](const std::string& f) {
    write(f + "camera.yaml", kCamera);
    write(f + "classes.yaml", "- {id: 3, name: pole}\n");
    write(f + "poses.txt", kTwoPoses);
    for (const char* n : {"0.png", "1.png"}) {
      write(f + "depth/" + n, depth);
      write(f + "label/" + n, label);
    }
  });
  layout("carla", [&](const std::string& f) {
    write(f + "camera.yaml", kCamera);
    write(f + "poses.txt", kTwoPoses);
    for (const char* n : {"0.png", "1.png"}) {
      write(f + "depth/" + n, color);
      write(f + "semantic/" + n, color);
    }
  });
  layout("kitti", [&](const std::string& f) {
    write(f + "calib.txt", "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
    write(f + "poses.txt", kTwoRows);
    write(f + "times.txt", "0\n0.1\n");
    for (const char* n : {"0", "1"}) {
      write(f + "velodyne/" + n + ".bin", std::string(64, '\x41'));
      write(f + "labels/" + n + ".label",
            std::string("\x28\0\0\0\x50\0\1\0\x28\0\0\0\x32\0\0\0", 16));
    }
  });
  layout("tum", [&](const std::string& f) {
    write(f + "camera.yaml", kCamera);
    write(f + "depth.txt", "# list\n1.0 depth/1.0.png\n2.0 depth/2.0.png\n");
    write(f + "groundtruth.txt", "1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n");
    for (const char* n : {"1.0.png", "2.0.png"}) {
      write(f + "depth/" + n, depth);
      write(f + "label/" + n, label);
    }
  });
  layout("synthia", [&](const std::string& f) {
    const cv::Mat wide(6, 8, CV_16UC3, cv::Scalar(3, 2, 1));
    cv::imwrite(work + "/wide.png", wide);
    for (const char* part : {"Depth", "GT/LABELS"})
      write(f + part + "/Stereo_Left/Omni_F/000000.png", bytesOf(work + "/wide.png"));
    write(f + "CameraParams/Stereo_Left/Omni_F/000000.txt", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
    write(f + "CameraParams/intrinsics.txt", "532.7\n\n640\n\n380\n\n0\n");
  });
  layout("virtual_kitti", [&](const std::string& f) {
    write(f + "intrinsic.txt", "frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n0 0 8 8 3.5 2.5\n");
    write(f + "extrinsic.txt",
          "frame cameraID r11 r12 r13 t1 r21 r22 r23 t2 r31 r32 r33 t3 0 0 0 1\n"
          "0 0 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
    write(f + "frames/depth/Camera_0/depth_00000.png", depth);
    write(f + "frames/classSegmentation/Camera_0/classgt_00000.png", color);
  });
  layout("airsim", [&](const std::string& f) {
    write(f + "camera.yaml", kCamera);
    write(f + "airsim_rec.txt",
          "VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"
          "car\t1000\t0\t0\t0\t1\t0\t0\t0\timg_car_0_1_1.png;img_car_0_5_1.png\n");
    write(f + "images/img_car_0_1_1.png", depth);
    write(f + "images/img_car_0_5_1.png", color);
  });
  layout("clouds", [&](const std::string& f) {
    fs::create_directories(f);
    io::writePcd(f + "0.pcd", someCloud(), nullptr);
    io::writePly(f + "1.ply", someCloud(), nullptr);
    write(f + "poses.txt", kTwoRows);
  });
}

void makeTiles(const std::string& work, const std::string& out) {
  io::writeTiles(work + "/tiles", someCloud(), 10, nullptr);
  pack(work + "/tiles", out + "/written");
  LabelSet labels("seed");
  labels.add({1, "pole", {200, 0, 0}, Role::object, Kind::pole});
  const std::string flat = work + "/flat/";
  fs::create_directories(flat);
  io::writePcd(flat + "a.pcd", someCloud(), &labels);
  write(flat + "pointcloud_map_metadata.yaml",
        "x_resolution: 30.5\ny_resolution: 20.0\na.pcd: [-1, -2.5]\n");
  pack(flat, out + "/flat");
}

/// The database that a map keeps of a visit.
void makeVisit(const std::string& path, const std::string& seed) {
  const map::Visit visit{someMap(), 0.25};
  map::saveMap(path, someMap());
  map::saveRevision(path, someMap(), "added", &visit);
  sqlite3* database = nullptr;
  sqlite3_stmt* row = nullptr;
  sqlite3_open(path.c_str(), &database);
  sqlite3_prepare_v2(database, "SELECT data FROM undo_visits", -1, &row, nullptr);
  sqlite3_step(row);
  write(seed, std::string(static_cast<const char*>(sqlite3_column_blob(row, 0)),
                          static_cast<std::size_t>(sqlite3_column_bytes(row, 0))));
  sqlite3_finalize(row);
  sqlite3_close(database);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  const std::string root = arguments[1];
  makeImages(root + "/image");
  for (const char* target : {"cloud", "e57", "map", "layouts", "tiles", "visit"})
    fs::create_directories(root + "/" + target);
  io::writePcd(root + "/cloud/binary.pcd", someCloud(), nullptr);
  io::writePly(root + "/cloud/binary.ply", someCloud(), nullptr);
  map::SemanticMap map = someMap();
  map::saveMap(root + "/map/one.xvm", map);
  map.addKeyframe(Eigen::Isometry3d::Identity(), 1, 1, 0);
  map::saveMap(root + "/map/two.xvm", someMap());
  map::saveRevision(root + "/map/two.xvm", map, "added");
  map.graph.neighbours.clear();
  map.graph.edge_radius_m = 5;  // whose vertices stay packed
  map::saveMap(root + "/map/radius.xvm", map);
  makeBags(root);
  makeE57(root + "/e57");
  const std::string work = root + "/work";
  fs::create_directories(work);
  makeRecordings(root + "/image", work, root + "/layouts");
  makeTiles(work, root + "/tiles");
  makeVisit(root + "/map/visit.xvm", root + "/visit/database");
  fs::remove_all(work);
  return 0;
}
