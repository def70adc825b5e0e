// SPDX-License-Identifier: BSD-3-Clause
#include <httplib.h>
#undef _res  // resolv.h makes it a macro, and Eigen has variables of that name

#include <arpa/inet.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "answer_json.h"
#include "live.h"
#include "outputs.h"
#include "pose_text.h"
#include "tool.h"
#include "windows.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostTracks = 64;  ///< robots; the one that was silent longest is forgotten
constexpr std::size_t kMostHead = 1 << 16;  ///< bytes of a request before its body
constexpr const char* kJson = "application/json";

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// A request that is not answered as it wishes, with its HTTP status.
struct Refusal {
  int status;
  std::string reason;
};

void answerWith(const Refusal& refusal, httplib::Response& response) {
  response.status = refusal.status;
  if (refusal.status == 503) response.set_header("Retry-After", "1");
  response.set_content(toText({{"status", "error"}, {"reason", oneLine(refusal.reason)}}) + "\n",
                       kJson);
}

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

/// Answers requests on sockets of any kind.
class HttpServer final : public httplib::Server {
 public:
  void answer(int socket, double time_s, bool is_one_too_many) {
    Connection connection(socket, time_s);
    t_connection = &connection;
    t_is_one_too_many = is_one_too_many;
    bool is_closed = false;
    process_request(connection, true, is_closed, {});
  }
};

/// A map in memory, with what finds queries in it.
struct LoadedMap {
  LoadedMap(map::SemanticMap loaded, const Job& given, double load_ms)
      : map(std::move(loaded)), job(inMap(given, map)), localizer(map::borrowed(map), job.options) {
    job.narrate = Narrative(Verbosity::quiet);
    unanswered.map = given.operands[0];
    unanswered.size = sizeText(map.size);
    unanswered.load_map_ms = load_ms;
  }
  const map::SemanticMap map;
  Job job;  ///< of a request
  const Localizer localizer;
  Answer unanswered;  ///< with what all answers share
};

/// A robot that is followed.
struct Track {
  std::mutex mutex;  ///< its frames are taken one after the other
  std::shared_ptr<const LoadedMap> map;
  std::optional<Follower> follower;
  std::int64_t frames = 0;
  Clock::time_point last = Clock::now();
};

/// Counts and the last latencies, for /metrics.
class Metrics {
 public:
  void add(const std::string& route, int status, double seconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++requests_[{route, status}];
    Latencies& latencies = latencies_[route];
    ++latencies.count;
    latencies.sum_s += seconds;
    latencies.last_s.push_back(seconds);
    if (latencies.last_s.size() > kLast) latencies.last_s.pop_front();
  }
  std::string text(std::size_t connections, int exchanges) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::string text = "# TYPE xview_requests_total counter\n";
    for (const auto& [key, count] : requests_)
      text += fmt::format("xview_requests_total{{route=\"{}\",status=\"{}\"}} {}\n", key.first,
                          key.second, count);
    text += "# TYPE xview_latency_seconds summary\n";
    for (const auto& [route, latencies] : latencies_) {
      std::vector<double> sorted(latencies.last_s.begin(), latencies.last_s.end());
      std::sort(sorted.begin(), sorted.end());
      for (const double q : {0.5, 0.99})
        text += fmt::format(
            "xview_latency_seconds{{route=\"{}\",quantile=\"{}\"}} {:.6f}\n", route, q,
            sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))]);
      text += fmt::format(
          "xview_latency_seconds_sum{{route=\"{0}\"}} {1:.6f}\n"
          "xview_latency_seconds_count{{route=\"{0}\"}} {2}\n",
          route, latencies.sum_s, latencies.count);
    }
    return text + fmt::format(
                      "# TYPE xview_connections gauge\nxview_connections {}\n"
                      "# TYPE xview_map_exchanges_total counter\nxview_map_exchanges_total {}\n",
                      connections, exchanges);
  }

 private:
  static constexpr std::size_t kLast = 4096;
  struct Latencies {
    std::uint64_t count = 0;
    double sum_s = 0;
    std::deque<double> last_s;
  };
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, std::uint64_t> requests_;
  std::map<std::string, Latencies> latencies_;
};

/// So many queries are computed at a time; the others wait, but not for ever.
class Places {
 public:
  void setCount(int count) { free_ = count; }
  void take(double most_s) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!changed_.wait_for(lock, std::chrono::duration<double>(most_s), [&] { return free_ > 0; }))
      throw Refusal{503, "busy: no query ended in time"};
    --free_;
  }
  void give() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++free_;
    changed_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int free_ = 1;
};

/// The body of a request as a file, as long as the object lives: it may be larger than the memory.
class BodyFile {
 public:
  BodyFile(const std::string& folder, const httplib::Request& request,
           const httplib::Response& response, const httplib::ContentReader& read,
           std::size_t most_bytes) {
    static std::atomic<std::uint64_t> count{0};
    name_ = request.has_param("name") ? request.get_param_value("name") : "body";
    path_ = fmt::format("{}/{}", folder, count++);
    try {
      take(response, read, most_bytes);
      const std::string named = path_ + ending();
      fs::rename(path_, named);
      path_ = named;
    } catch (...) {
      remove();
      throw;
    }
  }
  ~BodyFile() { remove(); }
  BodyFile(const BodyFile&) = delete;
  BodyFile& operator=(const BodyFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& name() const { return name_; }  ///< as the client calls it
  /// Who asks need not know where bodies lie.
  std::string inWordsOfClient(std::string text) const {
    const std::string bare = fs::path(path_).replace_extension(),
                      bare_name = fs::path(name_).replace_extension();
    for (const auto& [ours, theirs] : {std::pair(path_, name_), std::pair(bare, bare_name)}) {
      for (std::size_t at = 0; (at = text.find(ours, at)) != std::string::npos; at += theirs.size())
        text.replace(at, ours.size(), theirs);
    }
    return text;
  }

 private:
  void take(const httplib::Response& response, const httplib::ContentReader& read,
            std::size_t most_bytes) {
    std::ofstream file(path_, std::ios::binary);
    std::size_t bytes = 0;
    t_connection->takeBody();
    const bool is_whole = read([&](const char* data, std::size_t size) {
      bytes += size;
      if (first_.size() < 16) first_.append(data, std::min<std::size_t>(size, 16));
      return bytes <= most_bytes && file.write(data, static_cast<std::streamsize>(size)).good();
    });
    file.close();
    if (bytes > most_bytes || response.status == 413)
      throw Refusal{413, "the body is larger than --max-body"};
    if (t_connection->timedOut()) throw Refusal{408, "the body came too slowly"};
    if (!file) throw Refusal{507, "the body cannot be stored"};
    if (!is_whole) throw Refusal{400, "the body is not whole"};
    if (bytes == 0) throw Refusal{400, "the body is empty; expected a cloud file"};
  }

  /// By which readers know the kind: that of the name, else by the bytes. A scan of a Velodyne has
  /// no header.
  std::string ending() const {
    const auto begins = [&](const char* with) { return first_.rfind(with, 0) == 0; };
    const std::string named = endingOf(name_);
    if (named.size() > 1 && named.size() < 8 &&
        std::all_of(named.begin() + 1, named.end(), [](unsigned char c) { return isalnum(c); }))
      return named;
    if (begins("ply")) return ".ply";
    if (begins("SQLite format 3")) return ".xvm";
    if (begins("LASF")) return ".las";
    return begins("#") || begins("VERSION") ? ".pcd" : ".bin";
  }

  void remove() const {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }

  std::string name_, path_, first_;
};

const char* const kOpenApi =
    R"({"openapi":"3.0.3","info":{"title":"xview serve","version":"1"},"paths":{)"
    R"("/localize":{"post":{"summary":"where is this cloud (PCD, PLY, LAS, KITTI scan), graph or map in the map?","parameters":[{"name":"name","in":"query","description":"file name, whose ending tells the kind","schema":{"type":"string"}}],"requestBody":{"content":{"application/octet-stream":{}}},"responses":{"200":{"description":"the JSON of xview localize --json"},"400":{"description":"not read"},"408":{"description":"came too slowly"},"413":{"description":"too large"},"503":{"description":"busy"}}}},)"
    R"("/track/{id}":{"post":{"summary":"the next frame of a robot","parameters":[{"name":"id","in":"path","required":true,"schema":{"type":"string"}},{"name":"pose","in":"query","description":"stamp tx ty tz qx qy qz qw of the odometry; or the header X-Pose","schema":{"type":"string"}}],"responses":{"200":{"description":"a line of xview follow"}}}},)"
    R"("/health":{"get":{"responses":{"200":{"description":"ready"}}}},"/metrics":{"get":{"responses":{"200":{"description":"Prometheus text"}}}},"/openapi.json":{"get":{"responses":{"200":{"description":"this"}}}}}})"
    "\n";

class ServeCommand final : public Command {
 public:
  Description describe() const override {
    return {"serve",
            "MAP",
            "the map in memory behind a socket: where is what is posted?",
            "POST /localize takes a cloud file and answers the JSON of localize; POST /track/ID a "
            "frame, with its odometry in the header X-Pose, and answers a line of follow. GET "
            "/health, /metrics (Prometheus), /openapi.json. A MAP file that changes is loaded and "
            "exchanged between two requests. SIGINT and SIGTERM end it (130, 143) once all "
            "requests are answered.",
            "xview serve town.xvm --socket /run/xview/town.sock",
            1,
            1};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    flags.add("--socket PATH", socket_, "listen on this Unix socket, which is its owner's only");
    port_ = 8642;
    flags.add("--port", port_, "listen on this port, if there is no --socket; 0 = any free one");
    address_ = "127.0.0.1";
    flags.add("--listen ADDRESS", address_, "of the port; beyond this machine only if asked");
    max_body_mb_ = 256;
    flags.add("--max-body", max_body_mb_, "largest body [MB]; larger: 413");
    max_clients_ = 128;
    flags.add("--max-clients", max_clients_, "connections at a time; more: 503");
    jobs_ = 2;
    flags.add("--jobs", jobs_, "queries computed at a time; the others wait");
    declareLimits(flags, limits_);
    time_s_ = 30;
    flags.add("--patience", time_s_,
              "a request must come within this time, else 408, and have its turn within it, else "
              "503 [s]");
  }

  ExitCode run(const Job& job) override {
    checkFlags();
    job_ = &job;
    load();
    AtomicFolder scratch((fs::temp_directory_path() / "xview-serve").string());
    scratch_ = scratch.temporaryPath();
    fs::permissions(scratch_, fs::perms::owner_all);
    places_.setCount(jobs_);
    addRoutes();
    const int listening = socket_.empty() ? listenOnPort() : listenOnSocket();
    finishOnInterrupt([this] { finish(); });
    Results results("");
    results.print(socket_.empty() ? fmt::format("http://{}:{}", address_, port_) : socket_,
                  job.narrate);
    results.finish();
    std::thread([this] { watchMap(); }).detach();
    acceptUntilEnd(listening);
  }

 private:
  static void requirePositive(const char* name, int value) {
    if (value < 1) throw UsageError(fmt::format("{} = {}, must be >= 1", name, value));
  }

  void checkFlags() const {
    if (port_ < 0 || port_ > 65535)
      throw UsageError(fmt::format("--port = {}, must be in [0, 65535]", port_));
    requirePositive("--max-body", max_body_mb_);
    requirePositive("--max-clients", max_clients_);
    requirePositive("--jobs", jobs_);
    requireValid(limits_);
    if (!(time_s_ > 0 && time_s_ < 1e6))
      throw UsageError(fmt::format("--patience = {}, must be > 0", time_s_));
  }

  // ---- the map

  void load() {
    Stopwatch watch;
    map::SemanticMap map = readMap(job_->operands[0], input_, *job_);
    auto loaded = std::make_shared<const LoadedMap>(std::move(map), *job_, watch.lap_ms());
    const std::lock_guard<std::mutex> lock(map_mutex_);
    map_ = std::move(loaded);
  }
  std::shared_ptr<const LoadedMap> currentMap() const {
    const std::lock_guard<std::mutex> lock(map_mutex_);
    return map_;
  }
  /// Requests that have begun keep the map that they began with. A file that changes is read once
  /// it has stayed as it is from one look to the next.
  [[noreturn]] void watchMap() {
    const std::string& path = job_->operands[0];
    const auto look = [&] {
      std::error_code failed;
      return fs::last_write_time(path, failed);
    };
    for (auto loaded = look(), before = loaded;;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
      const auto now = look();
      const bool is_settled = std::exchange(before, now) == now;
      if (now == loaded || !is_settled) continue;
      loaded = now;
      try {
        load();
        ++exchanges_;
        job_->narrate.line(path + " has changed and is served from now on");
      } catch (const std::exception& e) {
        job_->narrate.error(std::string(e.what()) + "; the map before is served still");
      }
    }
  }

  // ---- sockets

  [[noreturn]] static void failToListen(const std::string& where) {
    throw Error(where, std::string("cannot be listened on: ") + std::strerror(errno));
  }

  int listenOnPort() {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    if (inet_pton(AF_INET, address_.c_str(), &address.sin_addr) != 1)
      throw UsageError("--listen " + address_ + ": expected an address such as 127.0.0.1");
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    auto* const where = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = sizeof address;
    if (bind(socket, where, size) != 0 || ::listen(socket, SOMAXCONN) != 0 ||
        getsockname(socket, where, &size) != 0)
      failToListen(fmt::format("{}:{}", address_, port_));
    port_ = ntohs(address.sin_port);
    return socket;
  }

  int listenOnSocket() const {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    if (socket_.size() >= sizeof address.sun_path)
      throw UsageError(fmt::format("--socket {}: expected a path of at most {} bytes", socket_,
                                   sizeof address.sun_path - 1));
    std::copy(socket_.begin(), socket_.end(), address.sun_path);
    const auto* const where = reinterpret_cast<const sockaddr*>(&address);
    const auto open = [] { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); };
    // That of a server that was killed is in the way, one that listens is not removed.
    if (fs::is_socket(socket_)) {
      const int probe = open();
      const bool is_alive = connect(probe, where, sizeof address) == 0;
      close(probe);
      if (is_alive) throw Error(socket_, "another server listens there");
      fs::remove(socket_);
    }
    const int socket = open();
    const mode_t before = umask(0077);
    const bool is_bound = bind(socket, where, sizeof address) == 0;
    umask(before);
    if (!is_bound || ::listen(socket, SOMAXCONN) != 0) failToListen(socket_);
    return socket;
  }

  /// Those beyond --max-clients are told so by as many threads again; others wait to be accepted.
  [[noreturn]] void acceptUntilEnd(int listening) {
    static constexpr int kLook_ms = 50;
    const auto most = static_cast<std::size_t>(max_clients_);
    const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(kLook_ms)); };
    while (true) {
      pollfd wanted{listening, POLLIN, 0};
      if (connections_ >= 2 * most) {
        pause();
      } else if (poll(&wanted, 1, kLook_ms) > 0) {
        const int client = accept4(listening, nullptr, nullptr, SOCK_CLOEXEC);
        if (client < 0 || !beginToAnswer(client, connections_ >= most)) pause();
      } else if (is_ending_) {
        close(listening);
        is_closed_ = true;
        while (true) ::pause();  // finish() runs on the thread that ends the program
      }
    }
  }

  /// False if there is no thread for it.
  bool beginToAnswer(int client, bool is_one_too_many) {
    ++connections_;
    try {
      std::thread([this, client, is_one_too_many] {
        server_.answer(client, time_s_, is_one_too_many);
        --connections_;
      }).detach();
      return true;
    } catch (const std::system_error&) {
      close(client);
      --connections_;
      return false;
    }
  }

  /// Answers all who have connected.
  void finish() {
    constexpr double kMostCompute_s = 30;
    const auto begin = Clock::now();
    is_ending_ = true;
    while ((!is_closed_ || connections_ > 0) && secondsSince(begin) < time_s_ + kMostCompute_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::error_code ignored;
    if (!socket_.empty()) fs::remove(socket_, ignored);
  }

  // ---- requests

  using Work = std::function<std::string(const httplib::Request&, const BodyFile&)>;

  /// What a request cannot have is said in one line of JSON.
  httplib::Server::HandlerWithContentReader handler(const std::string& route, const Work& work) {
    return [this, route, work](const httplib::Request& request, httplib::Response& response,
                               const httplib::ContentReader& read) {
      const auto begin = Clock::now();
      try {
        const BodyFile body(scratch_, request, response, read,
                            static_cast<std::size_t>(max_body_mb_) << 20);
        response.status = 200;
        response.set_content(computed(work, request, body) + "\n", kJson);
      } catch (const Refusal& refusal) {
        answerWith(refusal, response);
      } catch (const std::exception& e) {
        answerWith({500, e.what()}, response);
      }
      metrics_.add(route, response.status, secondsSince(begin));
    };
  }

  std::string computed(const Work& work, const httplib::Request& request, const BodyFile& body) {
    struct Place {
      Place(Places& places, double most_s) : places_(places) { places_.take(most_s); }
      ~Place() { places_.give(); }
      Place(const Place&) = delete;
      Place& operator=(const Place&) = delete;
      Places& places_;
    };
    const Place place(places_, time_s_);
    try {
      return work(request, body);
    } catch (const std::bad_alloc&) {
      throw Refusal{413, "out of memory"};
    } catch (const std::exception& e) {
      throw Refusal{400, body.inWordsOfClient(e.what())};
    }
  }

  void addRoutes() {
    server_.set_payload_max_length(static_cast<std::size_t>(max_body_mb_) << 20);
    server_.set_pre_routing_handler([this](const auto&, httplib::Response& response) {
      if (!t_is_one_too_many) return httplib::Server::HandlerResponse::Unhandled;
      answerWith({503, "too many connections"}, response);
      metrics_.add("refused", response.status, 0);
      return httplib::Server::HandlerResponse::Handled;
    });
    server_.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (!response.body.empty()) return;
      const int status = t_connection->timedOut() ? 408 : response.status;
      answerWith({status, status == 413   ? "the body is larger than --max-body"
                          : status == 408 ? "the request came too slowly"
                          : status == 404 ? "no such route; see /openapi.json"
                                          : "not a valid request"},
                 response);
    });
    server_.Post("/localize", handler("/localize", [this](const auto&, const BodyFile& body) {
                   return localize(body);
                 }));
    server_.Post(R"(/track/([A-Za-z0-9_.-]{1,64}))",
                 handler("/track", [this](const auto& request, const BodyFile& body) {
                   return track(request, body);
                 }));
    server_.Get("/health", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(toText({{"status", "ok"},
                                   {"map", job_->operands[0]},
                                   {"vertices", currentMap()->map.graph.size()},
                                   {"exchanges", exchanges_.load()},
                                   {"version", XVIEW_VERSION}}) +
                               "\n",
                           kJson);
    });
    server_.Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(metrics_.text(connections_, exchanges_), "text/plain; version=0.0.4");
    });
    server_.Get("/openapi.json", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(kOpenApi, kJson);
    });
  }

  std::string localize(const BodyFile& body) const {
    const auto map = currentMap();
    const Budget budget(limits_);
    QueryInput input = readQuery(body.path(), input_, map->job, map->map.labels, kLastMetres);
    input.path = body.name();
    Answer answer = answerFor(input, {0, input.size()}, map->unanswered);
    answer.fix = map->localizer.localize(*input.whole);
    answer.budget_exhausted = budget.exhausted();
    answer.heading_rad = headingOf(answer.fix.T_map_sensor.linear(), input.whole->sensor);
    return toJson(answer);
  }

  std::shared_ptr<Track> trackOf(const std::string& id) {
    const std::lock_guard<std::mutex> lock(tracks_mutex_);
    std::shared_ptr<Track>& track = tracks_[id];
    if (!track) track = std::make_shared<Track>();
    track->last = Clock::now();
    const std::shared_ptr<Track> wanted = track;
    if (tracks_.size() > kMostTracks)
      tracks_.erase(std::min_element(
          tracks_.begin(), tracks_.end(),
          [](const auto& a, const auto& b) { return a.second->last < b.second->last; }));
    return wanted;
  }

  std::string track(const httplib::Request& request, const BodyFile& body) {
    const auto came = Clock::now();
    LiveFrame frame;
    frame.input = body.name();
    std::optional<Eigen::Isometry3d> T_odom_sensor;
    const std::string text = request.has_param("pose") ? request.get_param_value("pose")
                                                       : request.get_header_value("X-Pose");
    if (!text.empty()) {
      const auto pose = parseStampedPose(text);
      if (!pose) throw Error("pose", "expected stamp tx ty tz qx qy qz qw, found " + text);
      frame.stamp_s = pose->stamp_s;
      T_odom_sensor = pose->T_frame_sensor;
    }
    frame.has_odometry = T_odom_sensor.has_value();
    const std::shared_ptr<Track> robot = trackOf(request.matches[1].str());
    const std::lock_guard<std::mutex> lock(robot->mutex);
    const auto map = currentMap();
    if (robot->map != map) {
      robot->follower.emplace(map->localizer, map->job.options, 0, 0);
      robot->map = map;
    }
    frame.number = robot->frames++;
    const LiveAnswer answer = robot->follower->withinBudget(limits_, [&] {
      return robot->follower->add(openQuery(body.path(), input_, map->job, map->map.labels), frame,
                                  T_odom_sensor);
    });
    return toJson(frame, answer, 1000 * secondsSince(came));
  }

  InputFlags input_;
  BudgetLimits limits_;
  std::string socket_, address_;
  int port_ = 0, max_body_mb_ = 0, max_clients_ = 0, jobs_ = 0;
  double time_s_ = 0;
  const Job* job_ = nullptr;
  std::string scratch_;  ///< folder of the bodies
  mutable std::mutex map_mutex_;
  std::shared_ptr<const LoadedMap> map_;
  std::atomic<int> exchanges_{0};
  HttpServer server_;
  std::atomic<std::size_t> connections_{0};
  std::atomic<bool> is_ending_{false}, is_closed_{false};
  Places places_;
  Metrics metrics_;
  std::mutex tracks_mutex_;
  std::map<std::string, std::shared_ptr<Track>> tracks_;
};

}  // namespace

std::unique_ptr<Command> makeServe() { return std::make_unique<ServeCommand>(); }

}  // namespace xview::tools
