// SPDX-License-Identifier: BSD-3-Clause
// Recordings of all layouts, from SemanticKITTI to AirSim: an input is the files of a folder, one
// behind the other.
#include <algorithm>

#include "fuzz.h"
#include "xview/io/recording.h"
#include "xview/types/frame.h"

namespace {

namespace fs = std::filesystem;

bool isHarmless(const std::string& name) {
  return !name.empty() && name.size() < 80 && name.front() != '/' &&
         name.find("..") == std::string::npos &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '_' || c == '.' || c == '/' || c == '-';
         });
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string folder = fuzz::scratch() + "/recording";
  fs::remove_all(folder);
  fs::create_directories(folder);
  fuzz::forEachFile(std::string(reinterpret_cast<const char*>(data), size),
                    [&](const std::string& name, const std::string& bytes) {
                      std::error_code failed;
                      if (!isHarmless(name)) return;
                      fs::create_directories(fs::path(folder + "/" + name).parent_path(), failed);
                      if (!failed) fuzz::written("recording/" + name, bytes);
                    });
  fuzz::isDone([&] {
    const auto source = io::openRecording(folder);
    for (std::size_t i = 0; i < std::min<std::size_t>(source->size(), 3); ++i)
      fuzz::isDone([&] { source->read(i); });
  });
  return 0;
}
