// SPDX-License-Identifier: BSD-3-Clause
#include "listening.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>

#include "base/user_text.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

[[noreturn]] void failToListen(const std::string& where) {
  throw Error(where, std::string("cannot be listened on: ") + std::strerror(errno));
}

int listenOnPort(Listening& wanted) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(wanted.port));
  if (inet_pton(AF_INET, wanted.address.c_str(), &address.sin_addr) != 1)
    throw UsageError("--listen " + wanted.address + ": expected an address such as 127.0.0.1");
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  auto* const where = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  if (bind(socket, where, size) != 0 || ::listen(socket, SOMAXCONN) != 0 ||
      getsockname(socket, where, &size) != 0)
    failToListen(fmt::format("{}:{}", wanted.address, wanted.port));
  wanted.port = ntohs(address.sin_port);
  return socket;
}

// ---- files

/// The socket of a server that was killed is in the way and removed. Only a connection that is
/// refused tells that nobody listens there: a full queue has a listener, and a socket of another
/// kind is that of another program.
void removeDeadSocket(const std::string& path, const sockaddr_un& address) {
  struct stat there = {};
  if (lstat(path.c_str(), &there) != 0 || !S_ISSOCK(there.st_mode)) return;
  const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const bool is_connected =
      connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int problem = is_connected ? 0 : errno;
  close(probe);
  if (problem == ENOENT) return;
  if (is_connected || problem == EAGAIN) throw Error(path, "another server listens there");
  if (problem == EPROTOTYPE)
    throw Error(path, "is the socket of another program; give --socket another path");
  if (problem != ECONNREFUSED)
    throw Error(path, std::string("cannot be listened on: ") + std::strerror(problem));
  if (unlink(path.c_str()) != 0 && errno != ENOENT) failToListen(path);
}

mode_t modeOf(const Listening& where) {
  if (where.mode.empty()) return where.group.empty() ? 0700 : 0660;
  constexpr unsigned kMost = 0777;
  unsigned mode = 0;
  const char* const end = where.mode.data() + where.mode.size();
  const auto [stop, problem] = std::from_chars(where.mode.data(), end, mode, 8);
  if (problem != std::errc() || stop != end || mode > kMost)
    throw UsageError("--socket-mode " + where.mode + ": expected an octal mode such as 0660");
  return mode;
}

gid_t groupOf(const std::string& name) {
  if (const auto number = numberFrom<gid_t>(name)) return *number;
  const struct group* const found = getgrnam(name.c_str());  // while there is one thread
  if (!found) throw UsageError("--socket-group " + name + ": there is no such group");
  return found->gr_gid;
}

}  // namespace

void ListeningSocket::open(Listening& where) {
  if (!where.socket.empty()) return listenOnFile(where);
  if (!where.mode.empty() || !where.group.empty())
    throw UsageError("--socket-mode and --socket-group are of a --socket");
  socket_ = listenOnPort(where);
}

/// The file is its owner's only until it has its group.
void ListeningSocket::listenOnFile(const Listening& where) {
  const mode_t mode = modeOf(where);
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (where.socket.size() >= sizeof address.sun_path)
    throw UsageError(fmt::format("--socket {}: expected a path of at most {} bytes", where.socket,
                                 sizeof address.sun_path - 1));
  const gid_t group = where.group.empty() ? static_cast<gid_t>(-1) : groupOf(where.group);
  std::copy(where.socket.begin(), where.socket.end(), address.sun_path);
  removeDeadSocket(where.socket, address);
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const mode_t before = umask(0077);
  const bool is_bound =
      bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  umask(before);
  struct stat made = {};
  if (!is_bound || lstat(where.socket.c_str(), &made) != 0) failToListen(where.socket);
  path_ = where.socket;
  device_ = made.st_dev;
  inode_ = made.st_ino;
  const bool has_group = where.group.empty() || made.st_gid == group;
  if (!has_group && lchown(path_.c_str(), static_cast<uid_t>(-1), group) != 0)
    throw Error(path_, fmt::format("cannot be given to the group {}: {}; the user of the server "
                                   "must be in it",
                                   where.group, std::strerror(errno)));
  if (chmod(path_.c_str(), mode) != 0 || ::listen(socket_, SOMAXCONN) != 0) failToListen(path_);
}

void ListeningSocket::close() { ::close(socket_); }

/// Who has taken the path in the meantime keeps it.
void ListeningSocket::removeFile() {
  struct stat there = {};
  if (path_.empty() || lstat(path_.c_str(), &there) != 0) return;
  if (there.st_dev == device_ && there.st_ino == inode_) unlink(path_.c_str());
}

}  // namespace xview::tools
