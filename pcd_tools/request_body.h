// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>

#include "connection.h"
#include "scratch_folder.h"

namespace xview::tools {

/// The body of a request as a file, as long as the object lives: it may be larger than the memory.
/// Of a body of several parts (multipart/form-data) it is the part that is a file.
class BodyFile {
 public:
  /// Throws Refusal.
  BodyFile(ScratchFolder& folder, const httplib::Request& request,
           const httplib::Response& response, const httplib::ContentReader& read,
           std::size_t most_bytes);
  ~BodyFile() { remove(); }
  BodyFile(const BodyFile&) = delete;
  BodyFile& operator=(const BodyFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& name() const { return name_; }  ///< as the client calls it
  /// Who asks need not know where bodies lie.
  std::string inWordsOfClient(std::string text) const;

 private:
  void take(std::FILE* file, const httplib::Request& request, const httplib::Response& response,
            const httplib::ContentReader& read, std::size_t most_bytes);
  bool add(const char* data, std::size_t size, std::FILE* file, std::size_t most_bytes);
  bool readParts(const httplib::ContentReader& read, const httplib::ContentReceiver& receive);
  std::string ending() const;
  void remove() const;

  std::string name_, path_, first_;
  std::size_t bytes_ = 0;
  int files_ = 0;  ///< parts that are files
};

}  // namespace xview::tools
