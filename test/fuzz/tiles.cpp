// SPDX-License-Identifier: BSD-3-Clause
// Clouds in tiles, as Autoware has them: an input is the files of a folder, one behind the other.
// What is read is divided anew, written and read again.
#include "fuzz.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string folder =
      fuzz::writtenFolder("tiles", std::string(reinterpret_cast<const char*>(data), size));
  fuzz::isDone([&] { io::recogniseInput(folder); });
  fuzz::isDone([&] { io::readCloudHeader(folder); });
  LabelledCloud cloud;
  if (!fuzz::isDone([&] { cloud = io::readCloud(folder, {}, false); }) || cloud.empty()) return 0;
  const std::string copy = fuzz::scratch() + "/copy";
  if (!fuzz::isDone([&] { io::writeTiles(copy, cloud, 20); })) return 0;
  fuzz::isDone([&] { fuzz::require(io::readCloud(copy).size() == cloud.size()); });
  return 0;
}
