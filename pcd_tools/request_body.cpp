// SPDX-License-Identifier: BSD-3-Clause
#include "request_body.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <utility>

#include "outputs.h"
#include "xview/base/error.h"

namespace xview::tools {

namespace fs = std::filesystem;

BodyFile::BodyFile(ScratchFolder& folder, const httplib::Request& request,
                   const httplib::Response& response, const httplib::ContentReader& read,
                   std::size_t most_bytes) {
  name_ = request.get_param_value("name");
  std::FILE* file = nullptr;
  try {
    const ScratchFolder::File made = folder.makeFile();
    path_ = made.path;
    file = fdopen(made.descriptor, "wb");
  } catch (const Error&) {
    throw Refusal{507, "the body cannot be stored"};
  }
  try {
    take(file, request, response, read, most_bytes);
    const std::string named = path_ + ending();
    fs::rename(path_, named);
    path_ = named;
  } catch (const fs::filesystem_error&) {
    remove();
    throw Refusal{507, "the body cannot be stored"};
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

void BodyFile::take(std::FILE* file, const httplib::Request& request,
                    const httplib::Response& response, const httplib::ContentReader& read,
                    std::size_t most_bytes) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> closed(file, std::fclose);
  const auto receive = [&](const char* data, std::size_t size) {
    return add(data, size, file, most_bytes);
  };
  const bool has_parts = request.is_multipart_form_data();
  Connection& connection = Connection::current();
  connection.beginBody();
  const bool is_whole = has_parts ? readParts(read, receive) : read(receive);
  connection.endBody();
  if (bytes_ > most_bytes || response.status == 413)
    throw Refusal{413, "the body is larger than --max-body"};
  if (!is_whole && connection.whyCut()) throw Refusal(*connection.whyCut());
  if (std::fflush(file) != 0 || std::ferror(file) != 0)
    throw Refusal{507, "the body cannot be stored"};
  if (files_ > 1) throw Refusal{400, "the body has several files; expected one"};
  if (has_parts && files_ == 0)
    throw Refusal{400, "no part of the body is a file; expected one, as of curl -F file=@scan.pcd"};
  if (!is_whole) throw Refusal{400, "the body is not whole"};
  if (bytes_ == 0) throw Refusal{400, "the body is empty; expected a cloud file"};
  if (name_.empty()) name_ = "body";
}

/// False if no more of it is wanted.
bool BodyFile::add(const char* data, std::size_t size, std::FILE* file, std::size_t most_bytes) {
  bytes_ += size;
  Connection::current().bodyCame();
  if (first_.size() < 16) first_.append(data, std::min<std::size_t>(size, 16));
  return bytes_ <= most_bytes && std::fwrite(data, 1, size, file) == size;
}

/// Parts without a file name are fields of a form that nobody asked for.
bool BodyFile::readParts(const httplib::ContentReader& read,
                         const httplib::ContentReceiver& receive) {
  bool is_file = false;
  return read(
      [&](const httplib::MultipartFormData& part) {
        is_file = !part.filename.empty();
        if (is_file && name_.empty()) name_ = part.filename;
        files_ += is_file ? 1 : 0;
        return files_ <= 1;
      },
      [&](const char* data, std::size_t size) { return !is_file || receive(data, size); });
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
  if (begins("ASTM-E57")) return ".e57";
  return begins("#") || begins("VERSION") ? ".pcd" : ".bin";
}

void BodyFile::remove() const {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

}  // namespace xview::tools
