// SPDX-License-Identifier: BSD-3-Clause
// PNG, PFM, TIFF, EXR and JPEG as depth, labels and colours of a camera of 8 x 6 pixels. The
// checksums of PNG are not looked at in this build.
#include "fuzz.h"
#include "io/image_files.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const bool is_pfm = bytes.compare(0, 1, "P") == 0;
  const std::string path = fuzz::written(is_pfm ? "in.pfm" : "in.img", bytes);
  Camera camera;
  camera.width = 8;
  camera.height = 6;
  camera.depth_scale = 0.01;
  fuzz::isDone([&] {
    const DepthImage depth = io::readDepth(path, camera);
    fuzz::require(depth.width == 8 && depth.height == 6);
    for (const float value : depth.pixels) fuzz::require(value >= 0);
  });
  LabelImage labels;
  if (fuzz::isDone([&] { labels = io::readLabels(path); }) && labels.width < 200) {
    const std::string copy = fuzz::scratch() + "/out.png";
    io::writeLabelPng(copy, labels);
    fuzz::require(io::readLabels(copy).pixels == labels.pixels);
  }
  fuzz::isDone([&] { io::readColors(path); });
  return 0;
}
