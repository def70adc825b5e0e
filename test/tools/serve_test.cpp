// SPDX-License-Identifier: BSD-3-Clause
// xview serve: clients of all kinds at once, hostile bodies, a map that is replaced.
#ifdef XVIEW_WITH_SERVE
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <thread>

#include "tools/server.h"

namespace xview::test {
namespace {

/// The answer is that of the program, and the other routes tell of it.
TEST_F(Serve, AnswersAsLocalizeDoes) {
  const std::string body = cloud();
  Server server({"--port", "0"}, map());
  ASSERT_EQ(server.address.rfind("http://127.0.0.1:", 0), 0u) << server.address;
  httplib::Client client = clientOf(server);
  const auto answer = localize(client, body);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200) << answer->body;
  const Outcome alone = runXview({"localize", "-q", "--json", file("query.ply"), map()});
  EXPECT_EQ(untimed(answer->body), untimed(alone.out));
  const auto tracked = client.Post("/track/robot", body, "application/octet-stream");
  ASSERT_TRUE(tracked);
  EXPECT_EQ(Json::parse(tracked->body)["state"], "found") << tracked->body;
  const auto forgotten = client.Delete("/track/robot"), again = client.Delete("/track/robot");
  ASSERT_TRUE(forgotten && again);
  EXPECT_EQ(forgotten->status, 200) << forgotten->body;
  EXPECT_EQ(again->status, 404) << again->body;
  const auto health = client.Get("/health");
  ASSERT_TRUE(health);
  EXPECT_EQ(Json::parse(health->body)["status"], "ok");
  const auto metrics = client.Get("/metrics");
  ASSERT_TRUE(metrics);
  EXPECT_NE(metrics->body.find("xview_latency_seconds_count{route=\"/localize\"} 1\n"),
            std::string::npos)
      << metrics->body;
  const auto api = client.Get("/openapi.json");
  ASSERT_TRUE(api);
  EXPECT_TRUE(Json::parse(api->body)["paths"].contains("/localize"));
}

/// What no reader takes is refused in a line of JSON that does not say where bodies lie.
TEST_F(Serve, HostileRequestsAreRefusedAndItStays) {
  const std::string body = cloud();
  Server server({"--port", "0", "--max-body", "1", "--patience", "2"}, map());
  httplib::Client client = clientOf(server);
  const auto statusOf = [&](const std::string& bytes, const std::string& route = "/localize") {
    const auto answer = client.Post(route, bytes, "application/octet-stream");
    if (!answer) return 0;
    EXPECT_EQ(Json::parse(answer->body)["status"], "error") << answer->body;
    EXPECT_EQ(answer->body.find("/tmp"), std::string::npos) << answer->body;
    return answer->status;
  };
  EXPECT_EQ(statusOf(""), 400);
  EXPECT_EQ(statusOf("SQLite format 3"), 400);
  EXPECT_EQ(statusOf("ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n"), 400);
  EXPECT_EQ(statusOf(body.substr(0, 3000)), 400);
  EXPECT_EQ(statusOf("# .PCD v0.7\n" + std::string(100, '\xff')), 400);
  EXPECT_EQ(statusOf("laz", "/localize?name=scan.laz"), 400);
  EXPECT_EQ(statusOf("scan", "/localize?name=../../x.pcd"), 400);
  EXPECT_EQ(statusOf("scan", "/track/robot?pose=1+2+3"), 400);
  EXPECT_EQ(statusOf(body, "/localize?near=1,2"), 400) << "it would not be heeded";
  EXPECT_EQ(statusOf("scan", "/nowhere"), 404);
  EXPECT_EQ(statusOf(std::string(3000000, 'x')), 413);
  const auto slow = client.Post(
      "/localize", 1000,
      [](std::size_t offset, std::size_t, httplib::DataSink& sink) {
        if (offset > 0) std::this_thread::sleep_for(std::chrono::seconds(3));
        return sink.write("x", 1);
      },
      "application/octet-stream");
  EXPECT_TRUE(!slow || slow->status == 408);
  const auto health = client.Get("/health");
  ASSERT_TRUE(health);
  EXPECT_EQ(health->status, 200);
}

TEST_F(Serve, ManyClientsGetTheSameAnswerWhileTheMapIsReplaced) {
  const std::string body = cloud(), own = file("served.xvm");
  fs::copy_file(map(), own);
  Server server({"--port", "0", "--patience", "300"}, own);
  httplib::Client one = clientOf(server);
  const auto answer = localize(one, body);
  ASSERT_TRUE(answer);
  const std::string first = untimed(answer->body);
  std::atomic<int> right{0}, other{0};
  std::vector<std::thread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      httplib::Client client = clientOf(server);
      for (int k = 0; k < 2; ++k) {
        const auto again = localize(client, body);
        ++(again && again->status == 200 && untimed(again->body) == first ? right : other);
      }
    });
  }
  fs::copy_file(map(), file("new.xvm"));
  fs::rename(file("new.xvm"), own);
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(right, 16);
  EXPECT_EQ(other, 0);
  const auto isExchanged = [&] {
    const auto health = one.Get("/health");
    return health && Json::parse(health->body)["exchanges"] == 1;
  };
  for (int i = 0; i < 100 && !isExchanged(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(isExchanged());
  // What is no map is not exchanged.
  writeText(own, "no map");
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  const auto still = localize(one, body);
  ASSERT_TRUE(still);
  EXPECT_EQ(untimed(still->body), first);
}

/// Each request has its own time to be computed in.
TEST_F(Serve, RequestsWhoseTimeEndsAreRejected) {
  const std::string body = cloud();
  Server server({"--port", "0", "--timeout", "0.000001"}, map());
  httplib::Client client = clientOf(server);
  for (int i = 0; i < 2; ++i) {
    const auto answer = localize(client, body);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 200) << answer->body;
    EXPECT_EQ(Json::parse(answer->body)["status"], "rejected");
    EXPECT_EQ(Json::parse(answer->body)["budget_exhausted"], "time");
  }
  const auto tracked = client.Post("/track/robot", body, "application/octet-stream");
  ASSERT_TRUE(tracked);
  EXPECT_EQ(Json::parse(tracked->body)["state"], "searching") << tracked->body;
  EXPECT_EQ(Json::parse(tracked->body)["budget_exhausted"], "time");
}

/// What is under way is answered; sockets and bodies are gone.
TEST_F(Serve, EndsOnceAllAreAnswered) {
  const std::string body = cloud();
  for (const int signal : {SIGINT, SIGTERM}) {
    Server server({"--port", "0"}, map());
    std::atomic<int> right{0};
    std::vector<std::thread> clients;
    for (int i = 0; i < 3; ++i) {
      clients.emplace_back([&] {
        httplib::Client client = clientOf(server);
        const auto answer = localize(client, body);
        right += answer && answer->status == 200;
      });
    }
    httplib::Client one = clientOf(server);
    const auto areThere = [&] {
      const auto metrics = one.Get("/metrics");
      return metrics && metrics->body.find("xview_connections 4\n") != std::string::npos;
    };
    for (int i = 0; i < 200 && right == 0 && !areThere(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(server.stop(signal), 128 + signal);
    for (std::thread& client : clients) client.join();
    EXPECT_EQ(right, 3);
  }
  const std::string socket = file("socket");
  Server server({"--socket", socket}, map());
  ASSERT_EQ(server.address, socket);
  EXPECT_EQ(fs::status(socket).permissions() & fs::perms::all, fs::perms::owner_all);
  EXPECT_EQ(runXview({"serve", "-q", map(), "--socket", socket}).code, 1) << "it is taken";
  EXPECT_EQ(server.stop(SIGTERM), 143);
  EXPECT_FALSE(fs::exists(socket));
}

}  // namespace
}  // namespace xview::test
#endif
