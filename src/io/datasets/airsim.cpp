// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>

#include "base/pose.h"
#include "io/image_decoding.h"
#include "io/image_files.h"
#include "io/layouts.h"
#include "io/yaml_file.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

/// ImageType of AirSim, the number in the file names.
enum AirsimImage { kDepthPlanar = 1, kDepthPerspective = 2, kSegmentation = 5 };

/// Columns of a row, empty ones too: the name of the vehicle may be empty.
std::vector<std::string_view> splitTabs(std::string_view line, char separator = '\t') {
  std::vector<std::string_view> columns;
  for (;;) {
    const std::size_t end = line.find(separator);
    columns.push_back(line.substr(0, end));
    if (end == std::string_view::npos) return columns;
    line.remove_prefix(end + 1);
  }
}

/// img_<vehicle>_<camera>_<type>_<time>.<ending>
struct ImageName {
  std::string file;
  std::string camera;  ///< with its vehicle; either may have underscores of its own
  int type = -1;
};

std::optional<ImageName> parseImageName(std::string_view file) {
  const std::string stem = fs::path(file).stem().string();
  const std::vector<std::string_view> parts = splitTabs(stem, '_');
  if (parts.size() < 4) return std::nullopt;
  const std::string_view type = parts[parts.size() - 2];
  if (type.size() != 1 || type[0] < '0' || type[0] > '9') return std::nullopt;
  const auto camera_end = static_cast<std::size_t>(type.data() - stem.data());
  return ImageName{std::string(file), stem.substr(0, camera_end), type[0] - '0'};
}

/// Depth and segmentation of the same camera; the first camera with depth is taken.
struct ImagePair {
  ImageName depth, segmentation;
};

std::optional<ImagePair> findPair(std::string_view list) {
  std::vector<ImageName> names;
  for (const std::string_view file : splitTabs(list, ';')) {
    if (const auto name = parseImageName(file)) names.push_back(*name);
  }
  for (const ImageName& depth : names) {
    if (depth.type != kDepthPlanar && depth.type != kDepthPerspective) continue;
    for (const ImageName& other : names) {
      if (other.type == kSegmentation && other.camera == depth.camera)
        return ImagePair{depth, other};
    }
  }
  return std::nullopt;
}

/// x y z of a camera on its vehicle, x forward, y right, z down [m], and roll, pitch, yaw [deg],
/// which turn about z first.
Eigen::Isometry3d mountOf(const std::array<double, 6>& m) {
  constexpr double kDegree = M_PI / 180;
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(kDegree * m[5], Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(kDegree * m[4], Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(kDegree * m[3], Eigen::Vector3d::UnitX());
  return poseOf(turn.toRotationMatrix(), {m[0], m[1], m[2]});
}

/// Body x forward, y right, z down in a world of north, east, down; to the optical frame in a world
/// with z up. The camera looks along x of the body that it is mounted as.
Eigen::Isometry3d opticalPose(const Eigen::Isometry3d& T_ned_body) {
  Eigen::Matrix3d R_up_ned, R_body_optical;
  R_up_ned << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  R_body_optical << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return poseOf(R_up_ned * T_ned_body.linear() * R_body_optical,
                R_up_ned * T_ned_body.translation());
}

/// The rows of airsim_rec.txt that have depth and segmentation.
class RecordingTable {
 public:
  explicit RecordingTable(const fs::path& folder)
      : folder_(folder), file_((folder / "airsim_rec.txt").string()) {
    std::string_view line;
    if (!file_.readLine(line)) file_.fail("the file is empty, expected a line of column names");
    for (const std::string_view name : splitTabs(line)) columns_.emplace_back(name);
    for (const char* name : kPoseColumns) pose_columns_.push_back(indexOf(name));
    time_column_ = indexOf("TimeStamp");
    image_column_ = indexOf("ImageFile");
  }

  std::vector<ListedFrame> readFrames() {
    std::vector<ListedFrame> frames;
    std::string_view line;
    for (std::int64_t row = 0; file_.readLine(line); ++row) {
      if (line.empty()) continue;
      const std::vector<std::string_view> cells = splitTabs(line);
      if (cells.size() != columns_.size()) {
        file_.failAtLine("expected {} columns, found {}", columns_.size(), cells.size());
      }
      ++rows_;
      if (const auto pair = findPair(cells[image_column_])) {
        if (depth_type_ >= 0 && depth_type_ != pair->depth.type) {
          file_.failAtLine(
              "depth of type {} after depth of type {}; expected one type (1: planar, 2: along the "
              "ray) in all rows",
              pair->depth.type, depth_type_);
        }
        file_.requireFileName(pair->depth.file);
        file_.requireFileName(pair->segmentation.file);
        depth_type_ = pair->depth.type;
        camera_ = pair->depth.camera;
        frames.push_back(frameOf(row, cells, *pair));
      }
    }
    if (frames.empty()) file_.fail("no row has images of depth and segmentation of one camera");
    return frames;
  }

  bool depthIsRange() const { return depth_type_ == kDepthPerspective; }
  int depthType() const { return depth_type_; }
  std::size_t rows() const { return rows_; }
  const std::string& camera() const { return camera_; }  ///< "img_<vehicle>_<camera>_"

 private:
  static constexpr const char* kPoseColumns[] = {"POS_X", "POS_Y", "POS_Z", "Q_X",
                                                 "Q_Y",   "Q_Z",   "Q_W"};

  std::size_t indexOf(const std::string& name) const {
    const auto found = std::find(columns_.begin(), columns_.end(), name);
    if (found == columns_.end()) file_.failAtLine("no column {}", name);
    return static_cast<std::size_t>(found - columns_.begin());
  }

  ListedFrame frameOf(std::int64_t row, const std::vector<std::string_view>& cells,
                      const ImagePair& pair) const {
    std::vector<std::string_view> words{cells[time_column_]};
    for (const std::size_t column : pose_columns_) words.push_back(cells[column]);
    const std::vector<double> numbers = file_.numbersOf(words);
    ListedFrame frame;
    frame.number = row;
    frame.stamp_s = 1e-3 * numbers[0];                             // milliseconds
    frame.T_odom_sensor = poseFromTum(numbers.data() + 1, file_);  // of the vehicle
    frame.measurement = (folder_ / "images" / pair.depth.file).string();
    frame.label = (folder_ / "images" / pair.segmentation.file).string();
    return frame;
  }

  fs::path folder_;
  InputFile file_;
  std::vector<std::string> columns_;
  std::vector<std::size_t> pose_columns_;
  std::size_t time_column_ = 0, image_column_ = 0;
  std::string camera_;
  std::size_t rows_ = 0;
  int depth_type_ = -1;
};

// ---- how the camera is mounted

/// What AirSim's own settings.json says of the camera of the recording.
struct CameraSettings {
  std::array<double, 6> mount{};  ///< as mountOf() takes it
  bool is_mounted = false;
  double fov_deg = 90;
};

/// The settings of the images of a type, in a list of CaptureSettings.
void readFieldOfView(const YamlFile& file, const YAML::Node& captures, int type, double& fov_deg) {
  if (!captures || !captures.IsSequence()) return;
  for (const YAML::Node& capture : captures) {
    if (!capture.IsMap() || !capture["FOV_Degrees"]) continue;
    const bool same =
        capture["ImageType"] && file.integer(capture["ImageType"], "ImageType", 0, 100) == type;
    if (same) fov_deg = file.number(capture["FOV_Degrees"], "FOV_Degrees");
  }
}

/// Whether the file names of a camera "img_<vehicle>_<camera>_" are of the camera called so.
bool isCalled(const std::string& images_of, const std::string& camera) {
  const std::string end = "_" + camera + "_";
  return images_of.size() > end.size() &&
         images_of.compare(images_of.size() - end.size(), end.size(), end) == 0;
}

CameraSettings readSettings(const std::string& path, const RecordingTable& table) {
  const YamlFile file = YamlFile::read(path);  // JSON is YAML, too
  CameraSettings settings;
  const YAML::Node root = file.root();
  if (!root.IsMap()) file.fail(root, "expected AirSim's settings");
  if (root["CameraDefaults"])
    readFieldOfView(file, root["CameraDefaults"]["CaptureSettings"], table.depthType(),
                    settings.fov_deg);
  if (!root["Vehicles"] || !root["Vehicles"].IsMap()) return settings;
  for (const auto& vehicle : root["Vehicles"]) {
    const YAML::Node cameras = vehicle.second["Cameras"];
    if (!cameras || !cameras.IsMap()) continue;
    for (const auto& camera : cameras) {
      if (!isCalled(table.camera(), camera.first.as<std::string>()) && cameras.size() > 1) continue;
      constexpr const char* kKeys[] = {"X", "Y", "Z", "Roll", "Pitch", "Yaw"};
      for (std::size_t i = 0; i < 6; ++i) {
        if (camera.second[kKeys[i]])
          settings.mount[i] = file.number(camera.second[kKeys[i]], kKeys[i]);
      }
      settings.is_mounted = true;
      readFieldOfView(file, camera.second["CaptureSettings"], table.depthType(), settings.fov_deg);
    }
  }
  return settings;
}

std::array<double, 6> parseMount(const std::string& text) {
  std::array<double, 6> mount{};
  const std::vector<std::string_view> words = splitTabs(text, ',');
  for (std::size_t i = 0; i < words.size() && words.size() == 6; ++i) {
    const auto number = numberFrom<double>(words[i]);
    if (!number || !std::isfinite(*number)) break;
    mount[i] = *number;
    if (i == 5) return mount;
  }
  throw UsageError("--mount " + text +
                   ": expected six numbers x,y,z,roll,pitch,yaw, metres and degrees, as "
                   "0,0,0,0,-90,0 for a camera that looks down");
}

/// --mount, else settings.json beside the recording, else what the name of the camera says, which
/// is a guess.
CameraSettings settingsOf(const fs::path& folder, const RecordingTable& table,
                          const InputOptions& options, std::vector<std::string>& notes) {
  CameraSettings settings;
  for (const fs::path& place : {folder, folder.parent_path()}) {
    const fs::path path = place / "settings.json";
    if (settings.is_mounted || !fs::exists(path)) continue;
    settings = readSettings(path.string(), table);
  }
  if (!options.mount.empty()) {
    settings.mount = parseMount(options.mount);
  } else if (!settings.is_mounted) {
    if (isCalled(table.camera(), "bottom_center")) settings.mount[4] = -90;
    if (isCalled(table.camera(), "back_center")) settings.mount[5] = 180;
    notes.push_back(
        fmt::format("no settings.json tells how its camera is mounted; taken to look {}; --mount "
                    "says otherwise",
                    settings.mount[4] != 0   ? "down, by its name"
                    : settings.mount[5] != 0 ? "back, by its name"
                                             : "forward"));
  }
  return settings;
}

bool isPfm(const std::string& path) { return fs::path(path).extension() == ".pfm"; }

/// camera.yaml, else the field of view of the settings; the latter only for depth in metres.
/// Whether depth is planar is said by the type of the images.
Camera cameraOf(const fs::path& folder, const ListedFrame& first, double fov_deg,
                bool depth_is_range) {
  const std::string path = (folder / "camera.yaml").string();
  Camera camera;
  if (fs::exists(path)) {
    camera = readCamera(path);
  } else if (isPfm(first.measurement)) {
    const Image<float> depth = readPfm(first.measurement);
    camera.width = depth.width;
    camera.height = depth.height;
    camera.fx = camera.fy =
        fov_deg == 90 ? 0.5 * depth.width : 0.5 * depth.width / std::tan(fov_deg * M_PI / 360);
    camera.cx = 0.5 * (depth.width - 1);
    camera.cy = 0.5 * (depth.height - 1);
  } else {
    throw Error(path,
                "needed for depth that is not .pfm: width, height, fx, fy, cx, cy, depth_scale");
  }
  camera.depth_is_range = depth_is_range;
  return camera;
}

/// AirSim writes the rows of its .pfm files from the top down, unlike the format.
DepthImage readAirsimDepth(const std::string& path, const Camera& camera) {
  DepthImage depth = readDepth(path, camera);
  if (!isPfm(path)) return depth;
  for (int y = 0; y < depth.height / 2; ++y) {
    std::swap_ranges(&depth.at(0, y), &depth.at(0, y) + depth.width,
                     &depth.at(0, depth.height - 1 - y));
  }
  return depth;
}

}  // namespace

RecordingListing listAirsim(const std::string& folder, const InputOptions& options) {
  RecordingTable table(folder);
  RecordingListing listing;
  listing.frames = table.readFrames();
  if (listing.frames.size() < table.rows()) {
    listing.notes.push_back(
        fmt::format("{} of {} rows are left out: no depth and segmentation of one camera",
                    table.rows() - listing.frames.size(), table.rows()));
  }
  const CameraSettings settings = settingsOf(folder, table, options, listing.notes);
  for (ListedFrame& frame : listing.frames)
    frame.T_odom_sensor = opticalPose(frame.T_odom_sensor * mountOf(settings.mount));
  const Camera camera = cameraOf(folder, listing.frames[0], settings.fov_deg, table.depthIsRange());
  const ColorTable colors =
      colorTable(namedLabels(options, folder).value_or(shippedLabelSet("airsim")));
  listing.read = [camera, colors](const ListedFrame& listed, Frame& frame) {
    frame.camera = camera;
    frame.depth = readAirsimDepth(listed.measurement, camera);
    const auto check = asLargeAsDepth(listed.label, listed, frame);
    frame.label = labelsOfColors(decodeImage(listed.label, check), colors, listed.label);
  };
  nameClasses(listing, options, folder);
  return listing;
}

}  // namespace xview::io
