// SPDX-License-Identifier: BSD-3-Clause
// Every YAML: classes, cameras, configurations of networks, options. Options that are read are
// written and read again.
#include "fuzz.h"
#include "io/image_files.h"
#include "xview/io/label_files.h"
#include "xview/options.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string path =
      fuzz::written("in.yaml", std::string(reinterpret_cast<const char*>(data), size));
  fuzz::isDone([&] { io::readLabelSet(path); });
  fuzz::isDone([&] {
    const Camera camera = io::readCamera(path);
    io::writeCamera(fuzz::scratch() + "/out.yaml", camera);
    fuzz::require(io::readCamera(fuzz::scratch() + "/out.yaml").fx == camera.fx);
  });
  fuzz::isDone([&] { io::readNetworkInput(path); });
  fuzz::isDone([&] {
    Options options, again;
    applyOptionsFile(options, path);
    applyOptionsFile(again, fuzz::written("out.yaml", toYaml(options)));
    fuzz::require(toYaml(again) == toYaml(options));
  });
  return 0;
}
