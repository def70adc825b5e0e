// SPDX-License-Identifier: BSD-3-Clause
// PCD and PLY clouds. What is read is written and read again; then nothing changes.
#include <algorithm>

#include "fuzz.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace {

using namespace xview;

void readAndWrite(const std::string& path, const std::string& copy) {
  fuzz::isDone([&] { io::readCloudHeader(path); });
  LabelledCloud cloud;
  if (!fuzz::isDone([&] { cloud = io::readCloud(path, {}, false); })) return;
  const bool is_pcd = copy.back() == 'd';
  if (is_pcd)
    io::writePcd(copy, cloud, nullptr);
  else
    io::writePly(copy, cloud, nullptr);
  const LabelledCloud again = io::readCloud(copy, {}, false);
  fuzz::require(again.size() == cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    fuzz::require(again.points[i].label == cloud.points[i].label);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const bool is_ply = bytes.compare(0, 3, "ply") == 0;
  const std::string path = fuzz::written(is_ply ? "in.ply" : "in.pcd", bytes);
  fuzz::isDone([&] { io::recogniseInput(path); });
  readAndWrite(path, fuzz::scratch() + (is_ply ? "/out.ply" : "/out.pcd"));
  return 0;
}
