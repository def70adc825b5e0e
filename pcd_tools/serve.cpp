// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "answer_json.h"
#include "clock.h"
#include "http_sockets.h"
#include "live.h"
#include "outputs.h"
#include "pose_text.h"
#include "request_body.h"
#include "tool.h"
#include "windows.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTracks = 64;  ///< robots; the one that was silent longest is forgotten
constexpr const char* kJson = "application/json";

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
    flags.add("--socket PATH", where_.socket,
              "listen on this Unix socket, which is its owner's only");
    flags.add("--port", where_.port,
              "listen on this port, if there is no --socket; 0 = any free one");
    flags.add("--listen ADDRESS", where_.address, "of the port; beyond this machine only if asked");
    max_body_mb_ = 256;
    flags.add("--max-body", max_body_mb_, "largest body [MB]; larger: 413");
    flags.add("--max-clients", where_.max_clients, "connections at a time; more: 503");
    jobs_ = 2;
    flags.add("--jobs", jobs_, "queries computed at a time; the others wait");
    declareLimits(flags, limits_);
    flags.add("--patience", where_.patience_s,
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
    server_.listen(where_);
    finishOnInterrupt([this] { server_.finish(); });
    Results results("");
    results.print(where_.socket.empty() ? fmt::format("http://{}:{}", where_.address, where_.port)
                                        : where_.socket,
                  job.narrate);
    results.finish();
    std::thread([this] { watchMap(); }).detach();
    server_.acceptUntilEnd();
  }

 private:
  static void requirePositive(const char* name, int value) {
    if (value < 1) throw UsageError(fmt::format("{} = {}, must be >= 1", name, value));
  }

  void checkFlags() const {
    if (where_.port < 0 || where_.port > 65535)
      throw UsageError(fmt::format("--port = {}, must be in [0, 65535]", where_.port));
    requirePositive("--max-body", max_body_mb_);
    requirePositive("--max-clients", where_.max_clients);
    requirePositive("--jobs", jobs_);
    requireValid(limits_);
    if (!(where_.patience_s > 0 && where_.patience_s < 1e6))
      throw UsageError(fmt::format("--patience = {}, must be > 0", where_.patience_s));
  }

  // ---- the map

  void load() {
    Stopwatch watch;
    map::SemanticMap map = readMapToLocalize(job_->operands[0], input_, *job_);
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
    const Place place(places_, where_.patience_s);
    try {
      return work(request, body);
    } catch (const std::bad_alloc&) {
      throw Refusal{413, "out of memory"};
    } catch (const std::exception& e) {
      throw Refusal{400, body.inWordsOfClient(e.what())};
    }
  }

  void addRoutes() {
    server_.routes().set_payload_max_length(static_cast<std::size_t>(max_body_mb_) << 20);
    server_.routes().set_pre_routing_handler([this](const auto&, httplib::Response& response) {
      if (!isOneTooMany()) return httplib::Server::HandlerResponse::Unhandled;
      answerWith({503, "too many connections"}, response);
      metrics_.add("refused", response.status, 0);
      return httplib::Server::HandlerResponse::Handled;
    });
    server_.routes().set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (!response.body.empty()) return;
      const int status = cameTooSlowly() ? 408 : response.status;
      answerWith({status, status == 413   ? "the body is larger than --max-body"
                          : status == 408 ? "the request came too slowly"
                          : status == 404 ? "no such route; see /openapi.json"
                                          : "not a valid request"},
                 response);
    });
    server_.routes().Post(
        "/localize",
        handler("/localize", [this](const auto&, const BodyFile& body) { return localize(body); }));
    server_.routes().Post(R"(/track/([A-Za-z0-9_.-]{1,64}))",
                          handler("/track", [this](const auto& request, const BodyFile& body) {
                            return track(request, body);
                          }));
    server_.routes().Get("/health", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(toText({{"status", "ok"},
                                   {"map", job_->operands[0]},
                                   {"vertices", map::vertexCount(currentMap()->map)},
                                   {"exchanges", exchanges_.load()},
                                   {"version", XVIEW_VERSION}}) +
                               "\n",
                           kJson);
    });
    server_.routes().Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(metrics_.text(server_.connections(), exchanges_),
                           "text/plain; version=0.0.4");
    });
    server_.routes().Get("/openapi.json", [](const httplib::Request&, httplib::Response& response) {
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
  Listening where_;
  int max_body_mb_ = 0, jobs_ = 0;
  const Job* job_ = nullptr;
  std::string scratch_;  ///< folder of the bodies
  mutable std::mutex map_mutex_;
  std::shared_ptr<const LoadedMap> map_;
  std::atomic<int> exchanges_{0};
  SocketServer server_;
  Places places_;
  Metrics metrics_;
  std::mutex tracks_mutex_;
  std::map<std::string, std::shared_ptr<Track>> tracks_;
};

}  // namespace

std::unique_ptr<Command> makeServe() { return std::make_unique<ServeCommand>(); }

}  // namespace xview::tools
