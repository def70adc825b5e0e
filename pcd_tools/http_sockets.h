// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <httplib.h>
#undef _res  // resolv.h makes it a macro, and Eigen has variables of that name

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>

namespace xview::tools {

/// A request that is not answered as it wishes, with its HTTP status.
struct Refusal {
  int status;
  std::string reason;
};
void answerWith(const Refusal& refusal, httplib::Response& response);

/// What the thread of a connection asks about it.
void beginBody();      ///< from now on more than a head may come
bool cameTooSlowly();  ///< it took longer than the patience
bool isOneTooMany();   ///< it is to be told so

/// Where to listen, and what one client may take.
struct Listening {
  std::string socket;  ///< path of a Unix socket; empty = a port
  std::string address = "127.0.0.1";
  int port = 8642;  ///< 0 = any free one
  int max_clients = 128;
  double patience_s = 30;  ///< for a request to come, and for its answer to be taken
};

/// Answers requests on a Unix socket or a port, each on a thread of its own, and no more of them at
/// a time than was agreed. Threads stay for later clients, because of each one that has computed
/// something TBB 2021 keeps 7 kB for ever.
class SocketServer {
 public:
  httplib::Server& routes() { return server_; }
  std::size_t connections() const { return connections_; }
  /// Throws Error or UsageError. `where` has the port from then on.
  void listen(Listening& where);
  [[noreturn]] void acceptUntilEnd();
  /// Answers all who have connected.
  void finish();

 private:
  /// Reads a request from a connection and writes what its route answers.
  class HttpServer final : public httplib::Server {
   public:
    void answer(int socket, double time_s, bool is_one_too_many);
  };

  /// A client that is connected.
  struct Client {
    int socket;
    bool is_one_too_many;
  };
  bool beginToAnswer(const Client& client);
  [[noreturn]] void answerUntilEnd();

  HttpServer server_;
  Listening where_;
  int listening_ = -1;
  std::atomic<std::size_t> connections_{0};
  std::atomic<bool> is_ending_{false}, is_closed_{false};
  std::mutex mutex_;              ///< of those below
  std::condition_variable came_;  ///< another client
  std::deque<Client> waiting_;
  std::size_t idle_ = 0;  ///< threads that wait for a client
};

}  // namespace xview::tools
