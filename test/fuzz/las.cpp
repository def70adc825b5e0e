// SPDX-License-Identifier: BSD-3-Clause
// LAS clouds. What is read is written as PLY and read again; then the points are as many.
#include "fuzz.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzz::written("in.las", bytes);
  fuzz::isDone([&] { io::readCloudHeader(path); });
  fuzz::isDone([&] { io::openRecording(path); });
  LabelledCloud cloud;
  if (!fuzz::isDone([&] { cloud = io::readCloud(path, {}, false); })) return 0;
  const std::string copy = fuzz::scratch() + "/out.ply";
  io::writePly(copy, cloud, nullptr);
  fuzz::require(io::readCloud(copy, {}, false).size() == cloud.size());
  return 0;
}
