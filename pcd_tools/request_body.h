// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "http_sockets.h"

namespace xview::tools {

/// The body of a request as a file, as long as the object lives: it may be larger than the memory.
class BodyFile {
 public:
  /// Throws Refusal.
  BodyFile(const std::string& folder, const httplib::Request& request,
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
  void take(const httplib::Response& response, const httplib::ContentReader& read,
            std::size_t most_bytes);
  std::string ending() const;
  void remove() const;

  std::string name_, path_, first_;
};

}  // namespace xview::tools
