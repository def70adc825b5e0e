// SPDX-License-Identifier: BSD-3-Clause
#include "connection.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <utility>

namespace xview::tools {
namespace {

thread_local Connection* t_connection = nullptr;

constexpr std::size_t kPart = 1 << 14;  ///< bytes that are taken at a time

}  // namespace

Connection::Connection(int socket, double time_s, std::size_t most_body)
    : socket_(socket), time_s_(time_s), most_(most_body + kMostHead) {
  t_connection = this;
}

/// What still comes is read for a moment, because a socket that is closed over unread bytes takes
/// the answer back.
Connection::~Connection() {
  constexpr double kLinger_s = 1;
  t_connection = nullptr;
  shutdown(socket_, SHUT_WR);
  begin_ = Clock::now();
  time_s_ = std::min(time_s_, kLinger_s);
  std::array<char, kPart> unread;
  while (waitFor(POLLIN) && recv(socket_, unread.data(), unread.size(), 0) > 0) {
  }
  close(socket_);
}

Connection& Connection::current() { return *t_connection; }

// ---- the request

bool Connection::awaitHead() {
  bool is_whole = false;
  while (!is_whole && !isHeadTooLong()) {
    if (receive() <= 0) {
      if (buffer_.empty() && !whyCut()) return false;
      refuse(whyCut().value_or(Refusal{400, "the head of the request is not whole"}));
      break;
    }
    is_whole = buffer_.find("\n\r\n") != std::string::npos;
  }
  if (first_line_.empty()) first_line_ = buffer_.substr(0, buffer_.find_first_of("\r\n"));
  if (is_whole) isHeadTooLong();
  if (refusal_) buffer_ = "GET / HTTP/1.1\r\n\r\n";
  hideRanges();
  stage_ = Stage::answer;
  return true;
}

/// Looks at the lines so far, the last of which may not be whole.
bool Connection::isHeadTooLong() {
  const std::string_view head(buffer_.data(), std::min(buffer_.size(), buffer_.find("\n\r\n")));
  std::size_t begin = 0;
  while (begin < head.size() && !refusal_) {
    const std::size_t end = std::min(head.find('\n', begin), head.size());
    if (end - begin > kMostLine - 2)
      refuse(begin == 0 ? Refusal{414, "the URI is longer than 8 kB"}
                        : Refusal{431, "a header line is longer than 8 kB"});
    begin = end + 1;
  }
  if (head.size() > kMostHead && !refusal_) refuse({431, "the head is longer than 64 kB"});
  return refusal_.has_value();
}

/// Answers are small and whole: httplib would cut those of a POST as well, and repeat them as often
/// as is asked.
void Connection::hideRanges() {
  constexpr std::string_view kName = "\nrange:";
  const auto is_same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  };
  const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(buffer_.find("\n\r\n"));
  for (auto at = buffer_.begin();
       (at = std::search(at, end, kName.begin(), kName.end(), is_same)) != end; ++at)
    at[1] = '-';
}

void Connection::refuse(const Refusal& refusal) {
  refusal_ = refusal;
  first_line_ = buffer_.substr(0, buffer_.find_first_of("\r\n"));
}

void Connection::beginBody() {
  stage_ = Stage::body;
  counted_ = taken_;
}

/// The time for the answer begins with it, also if the client was told to go on before.
void Connection::endBody() {
  stage_ = Stage::answer;
  answers_ = false;
}

std::optional<Refusal> Connection::whyCut() const {
  if (is_too_large_) return Refusal{413, "the request is larger than --max-body"};
  if (is_given_up_) return Refusal{503, "too many connections"};
  if (timed_out_) return Refusal{408, "the request came too slowly"};
  return std::nullopt;
}

void Connection::giveUp() {
  is_given_up_ = true;
  shutdown(socket_, SHUT_RD);
}

// ---- bytes

bool Connection::waitFor(short event) const {
  const double left_s = time_s_ - secondsSince(begin_);
  pollfd wanted{socket_, event, 0};
  const bool is_ready = left_s > 0 && poll(&wanted, 1, static_cast<int>(1000 * left_s)) > 0;
  if (!is_ready) timed_out_ = true;
  return is_ready;
}

/// Adds what comes to the buffer; like recv.
ssize_t Connection::receive() {
  is_too_large_ |= taken_ > most_ || (stage_ == Stage::body && taken_ - counted_ > kMostHead);
  if (is_too_large_ || is_given_up_ || !waitFor(POLLIN)) return -1;
  const std::size_t before = buffer_.size();
  buffer_.resize(before + kPart);
  const ssize_t came = recv(socket_, buffer_.data() + before, kPart, 0);
  const auto bytes = static_cast<std::size_t>(std::max<ssize_t>(came, 0));
  buffer_.resize(before + bytes);
  taken_ += bytes;
  return came <= 0 && is_given_up_ ? -1 : came;
}

ssize_t Connection::read(char* data, std::size_t size) {
  if (at_ == buffer_.size()) {
    if (refusal_) return -1;
    buffer_.clear();
    at_ = 0;
    const ssize_t came = receive();
    if (came <= 0) return came;
  }
  const std::size_t count = std::min(size, buffer_.size() - at_);
  std::memcpy(data, buffer_.data() + at_, count);
  at_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t Connection::write(const char* data, std::size_t size) {
  if (!std::exchange(answers_, true)) begin_ = Clock::now();
  return is_writable() ? send(socket_, data, size, MSG_NOSIGNAL) : -1;
}

void Connection::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip = "local";
  port = 0;
}

/// The address that the client has reached; of a Unix socket none.
void Connection::get_local_ip_and_port(std::string& ip, int& port) const {
  sockaddr_in address = {};
  socklen_t size = sizeof address;
  std::array<char, INET_ADDRSTRLEN> text = {};
  const bool has_one = getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
                       address.sin_family == AF_INET &&
                       inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) != nullptr;
  ip = has_one ? text.data() : "";
  port = has_one ? ntohs(address.sin_port) : 0;
}

}  // namespace xview::tools
