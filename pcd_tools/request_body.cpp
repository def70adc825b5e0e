// SPDX-License-Identifier: BSD-3-Clause
#include "request_body.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <utility>

#include "outputs.h"

namespace xview::tools {

namespace fs = std::filesystem;

BodyFile::BodyFile(const std::string& folder, const httplib::Request& request,
                   const httplib::Response& response, const httplib::ContentReader& read,
                   std::size_t most_bytes) {
  static std::atomic<std::uint64_t> count{0};
  name_ = request.has_param("name") ? request.get_param_value("name") : "body";
  path_ = fmt::format("{}/{}", folder, count++);
  try {
    take(response, read, most_bytes);
    const std::string named = path_ + ending();
    fs::rename(path_, named);
    path_ = named;
  } catch (...) {
    remove();
    throw;
  }
}
std::string BodyFile::inWordsOfClient(std::string text) const {
  const std::string bare = fs::path(path_).replace_extension(),
                    bare_name = fs::path(name_).replace_extension();
  for (const auto& [ours, theirs] : {std::pair(path_, name_), std::pair(bare, bare_name)}) {
    for (std::size_t at = 0; (at = text.find(ours, at)) != std::string::npos; at += theirs.size())
      text.replace(at, ours.size(), theirs);
  }
  return text;
}

void BodyFile::take(const httplib::Response& response, const httplib::ContentReader& read,
                    std::size_t most_bytes) {
  std::ofstream file(path_, std::ios::binary);
  std::size_t bytes = 0;
  beginBody();
  const bool is_whole = read([&](const char* data, std::size_t size) {
    bytes += size;
    if (first_.size() < 16) first_.append(data, std::min<std::size_t>(size, 16));
    return bytes <= most_bytes && file.write(data, static_cast<std::streamsize>(size)).good();
  });
  file.close();
  if (bytes > most_bytes || response.status == 413)
    throw Refusal{413, "the body is larger than --max-body"};
  if (cameTooSlowly()) throw Refusal{408, "the body came too slowly"};
  if (!file) throw Refusal{507, "the body cannot be stored"};
  if (!is_whole) throw Refusal{400, "the body is not whole"};
  if (bytes == 0) throw Refusal{400, "the body is empty; expected a cloud file"};
}

/// By which readers know the kind: that of the name, else by the bytes. A scan of a Velodyne has
/// no header.
std::string BodyFile::ending() const {
  const auto begins = [&](const char* with) { return first_.rfind(with, 0) == 0; };
  const std::string named = endingOf(name_);
  if (named.size() > 1 && named.size() < 8 &&
      std::all_of(named.begin() + 1, named.end(), [](unsigned char c) { return isalnum(c); }))
    return named;
  if (begins("ply")) return ".ply";
  if (begins("SQLite format 3")) return ".xvm";
  if (begins("LASF")) return ".las";
  return begins("#") || begins("VERSION") ? ".pcd" : ".bin";
}

void BodyFile::remove() const {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

}  // namespace xview::tools
