// SPDX-License-Identifier: BSD-3-Clause
#include "http_sockets.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "answer_json.h"
#include "clock.h"
#include "narrative.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostHead = 1 << 16;  ///< bytes of a request before its body

/// One connection with one request, all of which must come within the time [s], as its answer must
/// be taken.
class Connection final : public httplib::Stream {
 public:
  Connection(int socket, double time_s) : socket_(socket), time_s_(time_s) {}
  /// What still comes is read for a moment, because a socket that is closed over unread bytes takes
  /// the answer back.
  ~Connection() override {
    constexpr double kLinger_s = 1;
    shutdown(socket_, SHUT_WR);
    begin_ = Clock::now();
    time_s_ = std::min(time_s_, kLinger_s);
    while (waitFor(POLLIN) && recv(socket_, buffer_.data(), buffer_.size(), 0) > 0) {
    }
    close(socket_);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  using httplib::Stream::write;
  bool is_readable() const override { return at_ < end_ || waitFor(POLLIN); }
  bool is_writable() const override { return waitFor(POLLOUT); }
  ssize_t read(char* data, std::size_t size) override {
    if (at_ == end_) {
      if (taken_ > kMostHead && !takes_body_) return -1;
      if (!is_readable()) return -1;
      const ssize_t came = recv(socket_, buffer_.data(), buffer_.size(), 0);
      if (came <= 0) return came;
      at_ = 0;
      end_ = static_cast<std::size_t>(came);
      taken_ += end_;
    }
    const std::size_t count = std::min(size, end_ - at_);
    std::memcpy(data, buffer_.data() + at_, count);
    at_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* data, std::size_t size) override {
    if (!std::exchange(answers_, true)) begin_ = Clock::now();
    return is_writable() ? send(socket_, data, size, MSG_NOSIGNAL) : -1;
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = "local";
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    get_remote_ip_and_port(ip, port);
  }
  socket_t socket() const override { return socket_; }

  void takeBody() { takes_body_ = true; }
  bool timedOut() const { return timed_out_; }

 private:
  bool waitFor(short event) const {
    const double left_s = time_s_ - secondsSince(begin_);
    pollfd wanted{socket_, event, 0};
    const bool is_ready = left_s > 0 && poll(&wanted, 1, static_cast<int>(1000 * left_s)) > 0;
    if (!is_ready) timed_out_ = true;
    return is_ready;
  }

  int socket_;
  double time_s_;
  Clock::time_point begin_ = Clock::now();
  mutable bool timed_out_ = false;
  bool takes_body_ = false, answers_ = false;
  std::array<char, 1 << 14> buffer_;
  std::size_t at_ = 0, end_ = 0, taken_ = 0;
};

/// What the thread of a connection knows of it.
thread_local Connection* t_connection = nullptr;
thread_local bool t_is_one_too_many = false;

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

int listenOnSocket(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    throw UsageError(fmt::format("--socket {}: expected a path of at most {} bytes", path,
                                 sizeof address.sun_path - 1));
  std::copy(path.begin(), path.end(), address.sun_path);
  const auto* const where = reinterpret_cast<const sockaddr*>(&address);
  const auto open = [] { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); };
  // That of a server that was killed is in the way, one that listens is not removed.
  if (fs::is_socket(path)) {
    const int probe = open();
    const bool is_alive = connect(probe, where, sizeof address) == 0;
    close(probe);
    if (is_alive) throw Error(path, "another server listens there");
    fs::remove(path);
  }
  const int socket = open();
  const mode_t before = umask(0077);
  const bool is_bound = bind(socket, where, sizeof address) == 0;
  umask(before);
  if (!is_bound || ::listen(socket, SOMAXCONN) != 0) failToListen(path);
  return socket;
}

}  // namespace

void answerWith(const Refusal& refusal, httplib::Response& response) {
  response.status = refusal.status;
  if (refusal.status == 503) response.set_header("Retry-After", "1");
  response.set_content(toText({{"status", "error"}, {"reason", oneLine(refusal.reason)}}) + "\n",
                       "application/json");
}

void beginBody() { t_connection->takeBody(); }
bool cameTooSlowly() { return t_connection->timedOut(); }
bool isOneTooMany() { return t_is_one_too_many; }

void SocketServer::HttpServer::answer(int socket, double time_s, bool is_one_too_many) {
  Connection connection(socket, time_s);
  t_connection = &connection;
  t_is_one_too_many = is_one_too_many;
  bool is_closed = false;
  process_request(connection, true, is_closed, {});
}

void SocketServer::listen(Listening& where) {
  listening_ = where.socket.empty() ? listenOnPort(where) : listenOnSocket(where.socket);
  where_ = where;
}

/// Those beyond --max-clients are told so by as many threads again; others wait to be accepted.
void SocketServer::acceptUntilEnd() {
  static constexpr int kLook_ms = 50;
  const auto most = static_cast<std::size_t>(where_.max_clients);
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(kLook_ms)); };
  while (true) {
    pollfd wanted{listening_, POLLIN, 0};
    if (connections_ >= 2 * most) {
      pause();
    } else if (poll(&wanted, 1, kLook_ms) > 0) {
      const int client = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0 || !beginToAnswer({client, connections_ >= most})) pause();
    } else if (is_ending_) {
      close(listening_);
      is_closed_ = true;
      while (true) ::pause();  // finish() runs on the thread that ends the program
    }
  }
}

/// False if there is no thread for it.
bool SocketServer::beginToAnswer(const Client& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (idle_ <= waiting_.size()) {
    try {
      std::thread([this] { answerUntilEnd(); }).detach();
    } catch (const std::system_error&) {
      close(client.socket);
      return false;
    }
  }
  ++connections_;
  waiting_.push_back(client);
  came_.notify_one();
  return true;
}

void SocketServer::answerUntilEnd() {
  while (true) {
    std::unique_lock<std::mutex> lock(mutex_);
    ++idle_;
    came_.wait(lock, [this] { return !waiting_.empty(); });
    --idle_;
    const Client client = waiting_.front();
    waiting_.pop_front();
    lock.unlock();
    server_.answer(client.socket, where_.patience_s, client.is_one_too_many);
    --connections_;
  }
}

void SocketServer::finish() {
  constexpr double kMostCompute_s = 30;
  const auto begin = Clock::now();
  is_ending_ = true;
  while ((!is_closed_ || connections_ > 0) &&
         secondsSince(begin) < where_.patience_s + kMostCompute_s)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::error_code ignored;
  if (!where_.socket.empty()) fs::remove(where_.socket, ignored);
}

}  // namespace xview::tools
