// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

namespace xview::tools {

/// Where to listen, and what one client may take.
struct Listening {
  std::string socket;  ///< path of a Unix socket; empty = a port
  std::string mode;    ///< of that file, octal; empty = 0700, with a group 0660
  std::string group;   ///< of that file, by name or number; empty = that of the process
  std::string address = "127.0.0.1";
  int port = 8642;  ///< 0 = any free one
  int max_clients = 128;
  double patience_s = 30;  ///< for a request to come, and for its answer to be taken
};

/// A socket that listens; its file is removed at the end if it still is that of this one.
class ListeningSocket {
 public:
  ListeningSocket() = default;
  ~ListeningSocket() { removeFile(); }
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;

  /// Throws Error or UsageError. `where` has the port from then on.
  void open(Listening& where);
  int descriptor() const { return socket_; }
  void close();
  void removeFile();

 private:
  void listenOnFile(const Listening& where);

  int socket_ = -1;
  std::string path_;
  dev_t device_ = 0;  ///< of the file
  ino_t inode_ = 0;
};

}  // namespace xview::tools
