// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <httplib.h>
#include <poll.h>
#undef _res  // resolv.h makes it a macro, and Eigen has variables of that name

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>

#include "clock.h"

namespace xview::tools {

/// A request that is not answered as it wishes, with its HTTP status.
struct Refusal {
  int status;
  std::string reason;
};

/// One connection with one request, all of which must come within the time [s], as its answer must
/// be taken. Every byte that comes counts, whatever it means: the request has no more of them than
/// the largest body and the largest head together, nor more than a head between two pieces of its
/// body.
class Connection final : public httplib::Stream {
 public:
  static constexpr std::size_t kMostHead = 1 << 16;  ///< bytes of a request before its body
  static constexpr std::size_t kMostLine = 1 << 13;  ///< bytes of one line of them

  enum class Stage { head, body, answer };

  Connection(int socket, double time_s, std::size_t most_body);
  ~Connection() override;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  /// That which the calling thread answers.
  static Connection& current();

  /// Waits for the head of the request; false if the client went without a byte. If the head cannot
  /// be answered, refusal() says why, and what read() gives is another request without a body.
  bool awaitHead();
  const std::optional<Refusal>& refusal() const { return refusal_; }
  const std::string& firstLine() const { return first_line_; }

  void beginBody();
  void bodyCame() { counted_ = taken_; }  ///< a piece of the body
  void endBody();
  /// Why no more of the request is taken, if the client is not the one who ended it.
  std::optional<Refusal> whyCut() const;

  Stage stage() const { return stage_; }
  /// From another thread, to make room for others: nothing more is taken of the request.
  void giveUp();
  bool isGivenUp() const { return is_given_up_; }

  using httplib::Stream::write;
  bool is_readable() const override { return at_ < buffer_.size() || waitFor(POLLIN); }
  bool is_writable() const override { return waitFor(POLLOUT); }
  ssize_t read(char* data, std::size_t size) override;
  ssize_t write(const char* data, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override { return socket_; }

  std::string reason;  ///< of what is refused, for the log

 private:
  bool waitFor(short event) const;
  ssize_t receive();
  void refuse(const Refusal& refusal);
  bool isHeadTooLong();
  void hideRanges();

  int socket_;
  double time_s_;
  std::size_t most_;  ///< bytes of the request
  Clock::time_point begin_ = Clock::now();
  mutable bool timed_out_ = false;
  bool is_too_large_ = false, answers_ = false;
  std::atomic<Stage> stage_{Stage::head};
  std::atomic<bool> is_given_up_{false};
  std::string buffer_;  ///< that came
  std::size_t at_ = 0;  ///< of it that was read
  std::size_t taken_ = 0, counted_ = 0;
  std::string first_line_;
  std::optional<Refusal> refusal_;
};

}  // namespace xview::tools
