// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <sys/stat.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "answer_json.h"
#include "clock.h"
#include "http_sockets.h"
#include "live.h"
#include "map/contents.h"
#include "outputs.h"
#include "pose_text.h"
#include "query_places.h"
#include "request_body.h"
#include "request_metrics.h"
#include "request_rules.h"
#include "robots.h"
#include "service_manager.h"
#include "tool.h"
#include "windows.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

constexpr const char* kJson = "application/json";

/// By what a file differs from the one that its path led to before; of no file nothing.
using FileStamp = std::tuple<dev_t, ino_t, off_t, time_t, long>;
FileStamp stampOf(const std::string& path) {
  struct stat file = {};
  if (stat(path.c_str(), &file) != 0) return {};
  return {file.st_dev, file.st_ino, file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec};
}

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
            "requests are answered, or --patience is over.",
            "xview serve town.xvm --socket /run/xview/town.sock",
            1,
            1};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    flags.add("--socket PATH", where_.socket,
              "listen on this Unix socket, which is its owner's only");
    flags.add("--socket-mode MODE", where_.mode, "of that socket, octal: 0660 for its group, too");
    flags.add("--socket-group GROUP", where_.group, "of that socket, whose mode then is 0660");
    flags.add("--port", where_.port,
              "listen on this port, if there is no --socket; 0 = any free one");
    flags.add("--listen ADDRESS", where_.address, "of the port; beyond this machine only if asked");
    max_body_mb_ = 256;
    flags.add("--max-body", max_body_mb_, "largest body [MB]; larger: 413");
    flags.add("--max-clients", where_.max_clients, "connections at a time; more: 503");
    jobs_ = 2;
    flags.add("--jobs", jobs_, "queries computed at a time; the others wait");
    verdict_.declare(flags);
    flags.add("--patience", where_.patience_s,
              "a request must come within this time, else 408, and have its turn within it, else "
              "503 [s]");
  }

  ExitCode run(const Job& given) override {
    checkFlags();
    boundMemoryPools();
    Job job = given;
    verdict_.applyTo(job);
    job_ = &job;
    served_ = stampOf(job.operands[0]);
    load();
    scratch_.emplace("xview-serve");
    places_.setCount(jobs_);
    addRoutes();
    server_.listen(where_);
    finishOnInterrupt([this] { finish(); });
    Results results("");
    results.print(where_.socket.empty() ? fmt::format("http://{}:{}", where_.address, where_.port)
                                        : where_.socket,
                  job.narrate);
    results.finish();
    std::thread([this] { watchMap(); }).detach();
    tellServiceManager("READY=1");
    server_.acceptUntilEnd([this] { tellIsAlive(); });
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
    if (!(where_.patience_s > 0 && where_.patience_s < 1e6))
      throw UsageError(fmt::format("--patience = {}, must be > 0", where_.patience_s));
  }

  /// Each thread of a client would keep a pool with what its largest request took.
  void boundMemoryPools() const {
#ifdef __GLIBC__
    mallopt(M_ARENA_MAX, jobs_ + static_cast<int>(std::thread::hardware_concurrency()));
#endif
  }

  /// Nothing waits for a query that does not end.
  void finish() {
    tellServiceManager("STOPPING=1");
    if (const std::size_t left = server_.finish())
      job_->narrate.error(
          fmt::format("{} requests are not answered: they took longer than --patience {} s", left,
                      where_.patience_s));
    server_.removeSocket();
    scratch_->remove();
  }

  /// A manager that does not hear this for long starts the server anew.
  void tellIsAlive() {
    constexpr double kEvery_s = 1;
    if (secondsSince(told_) < kEvery_s || queries().isStuck()) return;
    told_ = Clock::now();
    tellServiceManager("WATCHDOG=1");
  }

  /// A query that takes twice the time that it has is taken for stuck.
  QueryPlaces::Load queries() const {
    return places_.load(2 * (job_->limits.time_s > 0 ? job_->limits.time_s : where_.patience_s));
  }

  // ---- the map

  void load() {
    Stopwatch watch;
    map::SemanticMap map = readMap(job_->operands[0], input_, *job_);
    auto loaded = std::make_shared<const LoadedMap>(std::move(map), *job_,
                                                    input_.parsed().class_names, watch.lap_ms());
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
    for (FileStamp before = served_;;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
      robots_.letGoOfOthersThan(currentMap());
      const FileStamp now = stampOf(path);
      const bool is_settled = std::exchange(before, now) == now;
      if (now == served_ || !is_settled) continue;
      served_ = now;
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
        const BodyFile body(*scratch_, request, response, read, mostBody());
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
    const QueryPlaces::Place place(places_, where_.patience_s);
    try {
      return work(request, body);
    } catch (const std::bad_alloc&) {
      throw Refusal{413, "out of memory"};
    } catch (const std::exception& e) {
      throw Refusal{400, body.inWordsOfClient(e.what())};
    }
  }

  std::size_t mostBody() const { return static_cast<std::size_t>(max_body_mb_) << 20; }

  /// Before the body of a request is read. Who asks how the server is hears it however many there
  /// are.
  void requireTakable(const httplib::Request& request) const {
    if (const auto& refusal = Connection::current().refusal()) throw Refusal(*refusal);
    requireAnswerable(request, where_, mostBody());
    if (isOneTooMany() && request.method == "POST") throw Refusal{503, "too many connections"};
  }

  void addRoutes() {
    httplib::Server& routes = server_.routes();
    routes.set_payload_max_length(mostBody());
    routes.set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
          try {
            requireTakable(request);
            return httplib::Server::HandlerResponse::Unhandled;
          } catch (const Refusal& refusal) {
            answerWith(refusal, response);
            if (refusal.status == 405) response.set_header("Allow", methodOf(request.path));
          }
          metrics_.add("refused", response.status, 0);
          return httplib::Server::HandlerResponse::Handled;
        });
    routes.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (response.body.empty()) answerWith({response.status, "not a valid request"}, response);
    });
    routes.set_logger([this](const httplib::Request&, const httplib::Response& response) {
      log(response.status);
    });
    routes.Post("/localize", handler("/localize", [this](const auto&, const BodyFile& body) {
                  return localize(body);
                }));
    routes.Post(kTrackRoute, handler("/track", [this](const auto& request, const BodyFile& body) {
                  return track(request, body);
                }));
    routes.Get("/health", [this](const httplib::Request&, httplib::Response& response) {
      const QueryPlaces::Load load = queries();
      if (load.isStuck()) response.status = 503;
      response.set_content(healthText(load) + "\n", kJson);
    });
    routes.Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(metrics_.text(server_.connections(), exchanges_, LoadedMap::count),
                           "text/plain; version=0.0.4");
    });
    routes.Get("/openapi.json", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(openApi(), kJson);
    });
  }

  std::string healthText(const QueryPlaces::Load& load) const {
    return toText({{"status", load.status()},
                   {"map", job_->operands[0]},
                   {"map_checksum", currentMap()->unanswered.map_checksum},
                   {"vertices", map::countsOf(currentMap()->map).vertices},
                   {"exchanges", exchanges_.load()},
                   {"running", load.running},
                   {"jobs", load.places},
                   {"stuck", load.stuck},
                   {"longest_s", load.longest_s},
                   {"version", XVIEW_VERSION}});
  }

  /// What is refused is told, whatever else is.
  void log(int status) const {
    constexpr std::size_t kMost = 200;  // bytes of what others sent
    const Connection& connection = Connection::current();
    const std::string line = fmt::format("{}: {}", connection.firstLine().substr(0, kMost), status);
    if (status < 400) return job_->narrate.detail(line);
    job_->narrate.error(line + ", " +
                        (connection.reason.empty() ? "see /health" : connection.reason));
  }

  std::string localize(const BodyFile& body) const {
    const auto map = currentMap();
    const Budget budget(job_->limits);
    QueryInput input = readQuery(body.path(), input_, map->job, map->map.labels, kLastMetres);
    input.path = body.name();
    Answer answer = answerFor(input, {0, input.size()}, *input.whole, map->unanswered);
    answer.fix = map->localizer.localize(*input.whole);
    answer.budget_exhausted = budget.exhausted();
    answer.heading_rad = headingOf(answer.fix.T_map_sensor.linear(), input.whole->sensor);
    return toJson(answer);
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
    const std::shared_ptr<Robot> robot = robots_.named(request.matches[1].str());
    const std::lock_guard<std::mutex> lock(robot->mutex);
    const auto map = currentMap();
    robot->followIn(map);
    frame.number = robot->frames++;
    const FollowAnswer answer = robot->follower->withinBudget(job_->limits, [&] {
      return follow(*robot->follower, openQuery(body.path(), input_, map->job, map->map.labels),
                    frame, T_odom_sensor);
    });
    if (const std::string jump = jumpText(answer); !jump.empty()) {
      metrics_.addJump();
      job_->narrate.note(fmt::format("/track/{}: found {}", request.matches[1].str(), jump));
    }
    return toJson(frame, answer, 1000 * secondsSince(came));
  }

  InputFlags input_;
  VerdictFlags verdict_;
  Listening where_;
  int max_body_mb_ = 0, jobs_ = 0;
  const Job* job_ = nullptr;
  std::optional<ScratchFolder> scratch_;  ///< of the bodies
  mutable std::mutex map_mutex_;
  std::shared_ptr<const LoadedMap> map_;
  FileStamp served_;  ///< of the file that was read last, from before it was
  std::atomic<int> exchanges_{0};
  SocketServer server_;
  QueryPlaces places_;
  Metrics metrics_;
  Robots robots_;
  Clock::time_point told_;  ///< when the service manager was
};

}  // namespace

std::unique_ptr<Command> makeServe() { return std::make_unique<ServeCommand>(); }

}  // namespace xview::tools
