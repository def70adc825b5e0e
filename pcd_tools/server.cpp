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
#include "server.h"
#include "service_manager.h"
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

/// The map behind a socket.
class Server {
 public:
  Server(Serving serving, Job job) : serving_(std::move(serving)), job_(std::move(job)) {}

  [[noreturn]] void run() {
    boundMemoryPools();
    served_ = stampOf(job_.operands[0]);
    load();
    scratch_.emplace("xview-serve");
    places_.setCount(serving_.jobs);
    addRoutes();
    Listening& where = serving_.where;
    server_.listen(where);
    finishOnInterrupt([this] { finish(); });
    Results results("");
    results.print(where.socket.empty() ? fmt::format("http://{}:{}", where.address, where.port)
                                       : where.socket,
                  job_.narrate);
    results.finish();
    job_.narrate.line("listening; SIGINT or SIGTERM ends it");
    std::thread([this] { watchMap(); }).detach();
    tellServiceManager("READY=1");
    server_.acceptUntilEnd([this] { tellIsAlive(); });
  }

 private:
  /// Each thread of a client would keep a pool with what its largest request took.
  void boundMemoryPools() const {
#ifdef __GLIBC__
    mallopt(M_ARENA_MAX, serving_.jobs + static_cast<int>(std::thread::hardware_concurrency()));
#endif
  }

  /// Nothing waits for a query that does not end.
  void finish() {
    tellServiceManager("STOPPING=1");
    if (const std::size_t left = server_.finish())
      job_.narrate.error(
          fmt::format("{} requests are not answered: they took longer than --patience {} s", left,
                      serving_.where.patience_s));
    server_.removeSocket();
    scratch_->remove();
    job_.narrate.line("stopped");
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
    return places_.load(2 *
                        (job_.limits.time_s > 0 ? job_.limits.time_s : serving_.where.patience_s));
  }

  // ---- the map

  void load() {
    Stopwatch watch;
    map::SemanticMap map = readMap(job_.operands[0], serving_.input, job_);
    auto loaded = std::make_shared<const LoadedMap>(
        std::move(map), job_, serving_.input.parsed().class_names, watch.lap_ms());
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
    const std::string& path = job_.operands[0];
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
        job_.narrate.line(path + " has changed and is served from now on");
      } catch (const std::exception& e) {
        job_.narrate.error(std::string(e.what()) + "; the map before is served still");
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
    const QueryPlaces::Place place(places_, serving_.where.patience_s);
    try {
      return work(request, body);
    } catch (const std::bad_alloc&) {
      throw Refusal{413, "out of memory"};
    } catch (const std::exception& e) {
      throw Refusal{400, body.inWordsOfClient(e.what())};
    }
  }

  std::size_t mostBody() const { return static_cast<std::size_t>(serving_.max_body_mb) << 20; }

  /// Before the body of a request is read. Who asks how the server is hears it however many there
  /// are.
  void requireTakable(const httplib::Request& request) const {
    if (const auto& refusal = Connection::current().refusal()) throw Refusal(*refusal);
    requireAnswerable(request, serving_.where, mostBody());
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
            if (refusal.status == 405) response.set_header("Allow", methodsOf(request.path));
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
    routes.Delete(kTrackRoute, [this](const auto& request, httplib::Response& response) {
      const std::string id = request.matches[1].str();
      if (robots_.forget(id))
        response.set_content(toText({{"status", "ok"}, {"forgotten", id}}) + "\n", kJson);
      else
        answerWith({404, "no robot of this name is followed: " + id}, response);
    });
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
                   {"map", job_.operands[0]},
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
    if (status < 400) return job_.narrate.detail(line);
    job_.narrate.error(line + ", " +
                       (connection.reason.empty() ? "see /health" : connection.reason));
  }

  std::string localize(const BodyFile& body) const {
    const auto map = currentMap();
    const Budget budget(job_.limits);
    QueryInput input =
        readQuery(body.path(), serving_.input, map->job, map->map.labels, kLastMetres);
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
    const FollowAnswer answer = robot->follower->withinBudget(job_.limits, [&] {
      return follow(*robot->follower,
                    openQuery(body.path(), serving_.input, map->job, map->map.labels), frame,
                    T_odom_sensor);
    });
    if (const std::string jump = jumpText(answer); !jump.empty()) {
      metrics_.addJump();
      job_.narrate.note(fmt::format("/track/{}: found {}", request.matches[1].str(), jump));
    }
    return toJson(frame, answer, 1000 * secondsSince(came));
  }

  Serving serving_;
  Job job_;
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
}  // namespace xview::tools

void xviewServe(const xview::tools::Serving& serving, const xview::tools::Job& job) {
  xview::tools::Server(serving, job).run();
}
