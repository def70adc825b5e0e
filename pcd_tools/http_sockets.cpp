// SPDX-License-Identifier: BSD-3-Clause
#include "http_sockets.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <system_error>
#include <thread>

#include "answer_json.h"
#include "clock.h"
#include "narrative.h"

namespace xview::tools {
namespace {

thread_local bool t_is_one_too_many = false;

void pauseFor(int time_ms) { std::this_thread::sleep_for(std::chrono::milliseconds(time_ms)); }

}  // namespace

void answerWith(const Refusal& refusal, httplib::Response& response) {
  Connection::current().reason = refusal.reason;
  response.status = refusal.status;
  if (refusal.status == 503) response.set_header("Retry-After", "1");
  response.set_content(toText({{"status", "error"}, {"reason", oneLine(refusal.reason)}}) + "\n",
                       "application/json");
}

bool isOneTooMany() { return t_is_one_too_many; }

void SocketServer::HttpServer::answer(Connection& connection) {
  bool is_closed = false;
  process_request(connection, true, is_closed, {});
}

void SocketServer::listen(Listening& where) {
  listening_.open(where);
  where_ = where;
}

void SocketServer::acceptUntilEnd(const std::function<void()>& look) {
  static constexpr int kLook_ms = 50;
  const auto most = static_cast<std::size_t>(where_.max_clients);
  while (true) {
    look();
    pollfd wanted{listening_.descriptor(), POLLIN, 0};
    if (poll(&wanted, 1, kLook_ms) > 0) {
      accept(most);
    } else if (is_ending_) {
      listening_.close();
      is_closed_ = true;
      while (true) ::pause();  // finish() runs on the thread that ends the program
    }
  }
}

/// Beyond --max-clients those make room who have not asked yet, the oldest first. If all have, the
/// new one is told so by one of as many threads again; when these are taken, those make room who
/// still send a body.
void SocketServer::accept(std::size_t most) {
  static constexpr int kPause_ms = 50;
  const bool has_room = connections_ < most || makeRoom(Connection::Stage::head);
  if (connections_ >= 2 * most) {
    pauseFor(has_room || makeRoom(Connection::Stage::body) ? 1 : kPause_ms);
    return;
  }
  const int client = accept4(listening_.descriptor(), nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0 || !beginToAnswer({client, !has_room})) pauseFor(kPause_ms);
}

/// False if no client is in that stage or one before.
bool SocketServer::makeRoom(Connection::Stage last) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto stage : {Connection::Stage::head, Connection::Stage::body}) {
    for (Connection* const one : answered_) {
      if (stage > last || one->stage() != stage || one->isGivenUp()) continue;
      one->giveUp();
      return true;
    }
  }
  return false;
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
    answer(client);
    --connections_;
  }
}

void SocketServer::answer(const Client& client) {
  Connection connection(client.socket, where_.patience_s, server_.mostBody());
  t_is_one_too_many = client.is_one_too_many;
  std::unique_lock<std::mutex> lock(mutex_);
  const auto place = answered_.insert(answered_.end(), &connection);
  lock.unlock();
  if (connection.awaitHead()) server_.answer(connection);
  lock.lock();
  answered_.erase(place);
}

std::size_t SocketServer::finish() {
  constexpr double kGrace_s = 1;
  const auto begin = Clock::now();
  is_ending_ = true;
  while ((!is_closed_ || connections_ > 0) && secondsSince(begin) < where_.patience_s + kGrace_s)
    pauseFor(5);
  return connections_;
}

}  // namespace xview::tools
