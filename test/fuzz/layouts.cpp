// SPDX-License-Identifier: BSD-3-Clause
// Recordings of all layouts, from SemanticKITTI to AirSim: an input is the files of a folder, one
// behind the other.
#include <algorithm>

#include "fuzz.h"
#include "xview/base/frame.h"
#include "xview/io/recording.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string folder =
      fuzz::writtenFolder("recording", std::string(reinterpret_cast<const char*>(data), size));
  fuzz::isDone([&] {
    const auto source = io::openRecording(folder);
    for (std::size_t i = 0; i < std::min<std::size_t>(source->size(), 3); ++i)
      fuzz::isDone([&] { source->read(i); });
  });
  return 0;
}
