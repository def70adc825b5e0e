// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <fcntl.h>
#include <httplib.h>
#undef _res  // resolv.h makes it a macro, and Eigen has variables of that name
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tools/tiny_town.h"

namespace xview::test {

namespace fs = std::filesystem;

/// A running server, stopped at the end.
class Server {
 public:
  /// `variable`: NAME=VALUE of its environment; `errors`: the file where its stderr goes.
  explicit Server(const std::vector<std::string>& flags, const std::string& map,
                  const std::string& variable = "", const std::string& errors = "/dev/null") {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe");
    process_ = fork();
    if (process_ == 0) {
      dup2(ends[1], 1);
      dup2(open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
      if (!variable.empty()) putenv(const_cast<char*>(variable.c_str()));
      std::vector<const char*> arguments = {XVIEW_PROGRAM, "serve", map.c_str()};
      for (const std::string& flag : flags) arguments.push_back(flag.c_str());
      arguments.push_back(nullptr);
      execv(XVIEW_PROGRAM, const_cast<char* const*>(arguments.data()));
      _exit(127);
    }
    signal(SIGPIPE, SIG_IGN);  // of clients that are refused
    close(ends[1]);
    char letter = 0;
    while (read(ends[0], &letter, 1) == 1 && letter != '\n') address += letter;
    close(ends[0]);
  }
  ~Server() {
    if (process_ > 0) stop(SIGKILL);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The exit code.
  int stop(int signal) {
    kill(process_, signal);
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::string address;  ///< as it printed it
  pid_t process() const { return process_; }

 private:
  pid_t process_ = 0;
};

class Serve : public TinyTown {
 protected:
  static std::string cloud() {
    const std::string path = file("query.ply");
    if (!fs::exists(path)) succeed({"lift", "-q", town("rear"), path});
    return readText(path);
  }
  /// The answer without what the clock decides.
  static std::string untimed(const std::string& json) {
    Json answer = Json::parse(json);
    answer.erase("timing_ms");
    return answer.dump();
  }
  /// All bytes that the server answers these with.
  static std::string sent(const Server& server, const std::string& bytes, bool goes = false) {
    const int socket = connected(server.address);
    std::size_t at = 0;
    for (ssize_t count = 0; at < bytes.size() && count >= 0; at += static_cast<std::size_t>(count))
      count =
          std::max<ssize_t>(send(socket, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL), -1);
    if (goes) shutdown(socket, SHUT_WR);
    return received(socket);
  }
  /// A socket to a server; timed, so that a test whose answer never comes ends.
  static int connected(const std::string& address) {
    const timeval most{60, 0};
    const std::size_t port = address.rfind(':');
    const bool is_file = address.rfind("http", 0) != 0;
    const int socket = ::socket(is_file ? AF_UNIX : AF_INET, SOCK_STREAM, 0);
    setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof most);
    sockaddr_un file = {};
    file.sun_family = AF_UNIX;
    if (is_file) address.copy(file.sun_path, sizeof file.sun_path - 1);
    sockaddr_in local = {};
    local.sin_family = AF_INET;
    local.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (!is_file)
      local.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(port + 1))));
    const auto* const where =
        is_file ? reinterpret_cast<sockaddr*>(&file) : reinterpret_cast<sockaddr*>(&local);
    if (connect(socket, where, is_file ? sizeof file : sizeof local) != 0)
      throw std::runtime_error(address);
    return socket;
  }
  static std::string received(int socket) {
    std::string answer(1 << 14, '\0');
    std::size_t size = 0;
    for (ssize_t came = 1; came > 0; size += static_cast<std::size_t>(came)) {
      answer.resize(size + (1 << 14));
      came = std::max<ssize_t>(recv(socket, answer.data() + size, 1 << 14, 0), 0);
    }
    close(socket);
    return answer.substr(0, size);
  }
  static int statusOf(const std::string& answer) {
    return answer.size() > 12 ? std::atoi(answer.c_str() + 9) : 0;
  }
  static Json jsonOf(const std::string& answer) {
    return Json::parse(answer.substr(answer.find("\r\n\r\n") + 4));
  }
  /// Waits for what comes soon or never.
  template <class Is>
  static bool comes(const Is& is) {
    for (int i = 0; i < 500 && !is(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return is();
  }
  static httplib::Client clientOf(const Server& server) {
    httplib::Client client(server.address);
    client.set_read_timeout(600);
    return client;
  }
  static httplib::Result localize(httplib::Client& client, const std::string& body) {
    return client.Post("/localize?name=" + file("query.ply"), body, "application/octet-stream");
  }
};

}  // namespace xview::test
