// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <optional>

#include "io/image_decoding.h"
#include "io/layouts.h"
#include "xview/io/image_files.h"
#include "xview/io/label_files.h"
#include "xview/types/error.h"

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

/// Body x forward, y right, z down in a world of north, east, down; to the optical frame in a world
/// with z up. The camera is taken to sit at the origin of the vehicle and to look forward.
Eigen::Isometry3d opticalPose(const Eigen::Isometry3d& T_ned_body) {
  Eigen::Matrix3d R_up_ned, R_body_optical;
  R_up_ned << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  R_body_optical << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R_up_ned * T_ned_body.linear() * R_body_optical;
  T.translation() = R_up_ned * T_ned_body.translation();
  return T;
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
        file_.failAtLine("expected " + std::to_string(columns_.size()) + " columns, found " +
                         std::to_string(cells.size()));
      }
      if (const auto pair = findPair(cells[image_column_])) {
        if (depth_type_ >= 0 && depth_type_ != pair->depth.type) {
          file_.failAtLine("depth of type " + std::to_string(pair->depth.type) +
                           " after depth of type " + std::to_string(depth_type_) +
                           "; expected one type (1: planar, 2: along the ray) in all rows");
        }
        depth_type_ = pair->depth.type;
        frames.push_back(frameOf(row, cells, *pair));
      }
    }
    if (frames.empty()) file_.fail("no row has images of depth and segmentation of one camera");
    return frames;
  }

  bool depthIsRange() const { return depth_type_ == kDepthPerspective; }

 private:
  static constexpr const char* kPoseColumns[] = {"POS_X", "POS_Y", "POS_Z", "Q_X",
                                                 "Q_Y",   "Q_Z",   "Q_W"};

  std::size_t indexOf(const std::string& name) const {
    const auto found = std::find(columns_.begin(), columns_.end(), name);
    if (found == columns_.end()) file_.failAtLine("no column " + name);
    return static_cast<std::size_t>(found - columns_.begin());
  }

  ListedFrame frameOf(std::int64_t row, const std::vector<std::string_view>& cells,
                      const ImagePair& pair) const {
    std::vector<std::string_view> words{cells[time_column_]};
    for (const std::size_t column : pose_columns_) words.push_back(cells[column]);
    const std::vector<double> numbers = file_.numbersOf(words);
    ListedFrame frame;
    frame.number = row;
    frame.stamp_s = 1e-3 * numbers[0];  // milliseconds
    frame.T_odom_sensor = opticalPose(poseFromTum(numbers.data() + 1, file_));
    frame.measurement = (folder_ / "images" / pair.depth.file).string();
    frame.label = (folder_ / "images" / pair.segmentation.file).string();
    return frame;
  }

  fs::path folder_;
  InputFile file_;
  std::vector<std::string> columns_;
  std::vector<std::size_t> pose_columns_;
  std::size_t time_column_ = 0, image_column_ = 0;
  int depth_type_ = -1;
};

bool isPfm(const std::string& path) { return fs::path(path).extension() == ".pfm"; }

/// camera.yaml, else AirSim's default field of view of 90 degrees; the latter only for depth in
/// metres. Whether depth is planar is said by the type of the images.
Camera cameraOf(const fs::path& folder, const ListedFrame& first, bool depth_is_range) {
  const std::string path = (folder / "camera.yaml").string();
  Camera camera;
  if (fs::exists(path)) {
    camera = readCamera(path);
  } else if (isPfm(first.measurement)) {
    const Image<float> depth = readPfm(first.measurement);
    camera.width = depth.width;
    camera.height = depth.height;
    camera.fx = camera.fy = 0.5 * depth.width;
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
  const auto named = namedLabels(options.labels, folder);
  if (!named) {
    throw Error((fs::path(folder) / "classes.yaml").string(),
                "needed to tell the classes by the colours of the segmentation");
  }
  RecordingTable table(folder);
  RecordingListing listing;
  listing.labels = *named;
  listing.frames = table.readFrames();
  const Camera camera = cameraOf(folder, listing.frames[0], table.depthIsRange());
  const ColorTable colors = colorTable(listing.labels);
  listing.read = [camera, colors](const ListedFrame& listed, Frame& frame) {
    frame.camera = camera;
    frame.depth = readAirsimDepth(listed.measurement, camera);
    frame.label = labelsOfColors(decodeImage(listed.label), colors, listed.label);
    requireSameSizes(listed, frame);
  };
  return listing;
}

}  // namespace xview::io
