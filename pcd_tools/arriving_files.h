// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <Eigen/Geometry>

#include "clock.h"

namespace xview::tools {

/// A file that came, with the pose that was said of it.
struct ArrivedFile {
  std::string path;
  std::optional<double> stamp_s{};
  std::optional<Eigen::Isometry3d> T_odom_sensor{};
  std::string error{};  ///< why it is not even opened; empty if it is
};

/// The file that the next line of a stream names: a path, which may hold blanks, and behind it
/// perhaps a pose. Nothing at the end of the stream. A line is kept up to the length of a path
/// only.
std::optional<ArrivedFile> nextNamed(std::FILE* lines);

/// A folder that fills with clouds: they are taken by name, each as soon as it is whole, and with
/// the line of its number if there is a poses.txt. What is no cloud, never gets whole or has no
/// such line is handed out with an error; the others do not wait for it for long.
class FillingFolder {
 public:
  FillingFolder(std::string folder, double idle_s, std::string stop)
      : folder_(std::move(folder)), idle_s_(idle_s), stop_(std::move(stop)) {}

  /// Waits for the next; nothing once the stop file is there or the time to wait is over.
  std::optional<ArrivedFile> next();

 private:
  enum class Wait {
    on,       ///< more may come
    is_over,  ///< nothing came for too long
    is_ended  ///< whoever writes says that all is there
  };
  /// Size and time of a file: it changed if they did.
  struct Mark {
    std::uintmax_t bytes = 0;
    std::filesystem::file_time_type time{};
    bool operator==(const Mark& o) const { return bytes == o.bytes && time == o.time; }
  };
  struct Pending {
    Clock::time_point seen = Clock::now();     ///< first
    Clock::time_point changed = Clock::now();  ///< last
    Mark mark{};
    std::string problem{};             ///< why it is no file; empty if it is one
    std::optional<bool> is_whole{};    ///< what its header says, once it was asked
    std::optional<Mark> poses_then{};  ///< of poses.txt, which had no line for it
  };

  void list();
  void look(const std::string& name, Pending& file);
  std::optional<ArrivedFile> firstReady(Wait wait);
  std::optional<ArrivedFile> ready(const std::string& name, Pending& file, Wait wait) const;
  std::optional<ArrivedFile> withPose(const std::string& name, Pending& file, Wait wait) const;
  std::string pathOf(const std::string& name) const;

  std::string folder_;
  double idle_s_;
  std::string stop_;
  std::set<std::string> taken_;
  std::map<std::string, Pending> pending_;
  Clock::time_point sign_of_life_ = Clock::now();
  bool is_over_ = false;
};

}  // namespace xview::tools
