// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/pose_files.h"

#include <cstdio>

#include "frame_listing.h"
#include "header_text.h"
#include "input_file.h"
#include "pose_lines.h"
#include "xview/io/atomic_file.h"

namespace xview {

std::vector<StampedPose> readPoses(const std::string& path) {
  InputFile file(path);
  std::vector<StampedPose> poses;
  std::size_t columns = 0;
  std::string_view line;
  while (file.readLine(line)) {
    line = line.substr(0, line.find('#'));
    const std::vector<std::string_view> words = splitWords(line);
    if (words.empty()) continue;
    const std::vector<double> numbers = numbersOf(words, file);
    if (numbers.size() != 8 && numbers.size() != 12) {
      file.failAtLine("expected 8 numbers (TUM) or 12 (KITTI), found " +
                      std::to_string(numbers.size()));
    }
    if (columns == 0) columns = numbers.size();
    if (numbers.size() != columns) {
      file.failAtLine("expected " + std::to_string(columns) +
                      " numbers as in the lines before, found " + std::to_string(numbers.size()));
    }
    StampedPose pose;
    if (columns == 8) {
      pose.stamp_s = numbers[0];
      pose.T_frame_sensor = poseFromTum(numbers.data() + 1, file);
    } else {
      pose.stamp_s = static_cast<double>(poses.size());
      pose.T_frame_sensor = poseFromRows(numbers.data(), file);
    }
    poses.push_back(pose);
  }
  return poses;
}

std::vector<StampedPose> posesOfFrames(const std::string& path,
                                       const std::vector<std::int64_t>& frame_numbers) {
  const std::vector<StampedPose> poses = readPoses(path);
  std::vector<StampedPose> chosen;
  for (const std::size_t line : linesOfFrames(path, "poses", poses.size(), frame_numbers)) {
    chosen.push_back(poses[line]);
  }
  return chosen;
}

void writeTumPoses(const std::string& path, const std::vector<StampedPose>& poses) {
  AtomicFile file(path);
  for (const StampedPose& pose : poses) {
    const Eigen::Vector3d t = pose.T_frame_sensor.translation();
    Eigen::Quaterniond q(pose.T_frame_sensor.linear());
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    char line[400];
    std::snprintf(line, sizeof line, "%.9f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", pose.stamp_s,
                  t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
    file.write(line);
  }
  file.commit();
}

}  // namespace xview
