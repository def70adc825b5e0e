// SPDX-License-Identifier: BSD-3-Clause
// E57 clouds. The input has no sums, which no mutation would survive; they are added here.
#include "support/e57.h"
#include "fuzz.h"
#include "xview/io/cloud_files.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string content(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzz::written("in.e57", size < 48 ? content : test::e57Paged(content));
  fuzz::isDone([&] { io::readCloudHeader(path); });
  LabelledCloud cloud;
  if (!fuzz::isDone([&] { cloud = io::readCloud(path, {}, false); })) return 0;
  const std::string copy = fuzz::scratch() + "/out.ply";
  io::writePly(copy, cloud, nullptr);
  fuzz::require(io::readCloud(copy, {}, false).size() == cloud.size());
  return 0;
}
