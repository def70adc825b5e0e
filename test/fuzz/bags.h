// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "fuzz.h"
#include "io/bag_files.h"
#include "xview/base/frame.h"

namespace xview::fuzz {

/// Lists the topics of a bag with these bytes, and reads its first frames, with poses and without.
inline int readBag(const std::string& name, const std::uint8_t* data, std::size_t size) {
  const std::string path = written(name, std::string(reinterpret_cast<const char*>(data), size));
  isDone([&] { io::bagTopics(path); });
  for (const char* frames : {":", "0:1"}) {
    io::InputOptions options;
    options.frames = io::parseFrameRange(frames);
    isDone([&] {
      const auto source = io::openRecording(path, options);
      for (std::size_t i = 0; i < std::min<std::size_t>(source->size(), 5); ++i)
        isDone([&] { source->read(i); });
    });
  }
  return 0;
}

}  // namespace xview::fuzz
