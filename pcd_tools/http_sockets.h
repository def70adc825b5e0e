// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <list>
#include <mutex>
#include <string>

#include "connection.h"
#include "listening.h"

namespace xview::tools {

void answerWith(const Refusal& refusal, httplib::Response& response);

/// What the thread of a connection asks about it: it is to be told that there are too many.
bool isOneTooMany();

/// Answers requests on a Unix socket or a port, each on a thread of its own, and no more of them at
/// a time than was agreed. Threads stay for later clients, because of each one that has computed
/// something TBB 2021 keeps 7 kB for ever. Clients that have not asked make room for others.
class SocketServer {
 public:
  httplib::Server& routes() { return server_; }
  std::size_t connections() const { return connections_; }
  /// Throws Error or UsageError. `where` has the port from then on.
  void listen(Listening& where);
  /// Calls `look` every now and then.
  [[noreturn]] void acceptUntilEnd(const std::function<void()>& look);
  /// Answers all who have connected, within the patience; how many are left unanswered.
  std::size_t finish();
  void removeSocket() { listening_.removeFile(); }

 private:
  /// Reads a request from a connection and writes what its route answers.
  class HttpServer final : public httplib::Server {
   public:
    void answer(Connection& connection);
    std::size_t mostBody() const { return payload_max_length_; }
  };

  /// A client that is connected.
  struct Client {
    int socket;
    bool is_one_too_many;
  };
  void accept(std::size_t most);
  bool beginToAnswer(const Client& client);
  [[noreturn]] void answerUntilEnd();
  void answer(const Client& client);
  bool makeRoom(Connection::Stage last);

  HttpServer server_;
  Listening where_;
  ListeningSocket listening_;
  std::atomic<std::size_t> connections_{0};
  std::atomic<bool> is_ending_{false}, is_closed_{false};
  std::mutex mutex_;              ///< of those below
  std::condition_variable came_;  ///< another client
  std::deque<Client> waiting_;
  std::list<Connection*> answered_;  ///< by threads now, the oldest first
  std::size_t idle_ = 0;             ///< threads that wait for a client
};

}  // namespace xview::tools
