// SPDX-License-Identifier: BSD-3-Clause
// xview serve among others who use the same machine: pages, planted files, foreign sockets, clients
// that never end.
#ifdef XVIEW_WITH_SERVE
#include <gtest/gtest.h>

#include <sys/stat.h>

#include "tools/server.h"

namespace xview::test {
namespace {

const std::string kGet = "GET /health HTTP/1.1\r\n";

std::string headOf(const std::string& route, const std::string& lines) {
  return "POST " + route + " HTTP/1.1\r\nHost: localhost\r\n" + lines + "\r\n";
}
std::string lengthOf(const std::string& body) {
  return "Content-Length: " + std::to_string(body.size()) + "\r\n";
}

/// A page in a browser of this machine neither reads nor writes.
TEST_F(Serve, HostAndOriginAreItsOwn) {
  const std::string socket = file("pages");
  Server server({"--port", "0"}, map()), on_file({"--socket", socket}, map());
  const std::string port = server.address.substr(server.address.rfind(':'));
  const auto status = [&](const std::string& lines) {
    return statusOf(sent(server, kGet + lines + "\r\n"));
  };
  for (const std::string host : {"localhost", "LOCALHOST", "127.0.0.1", "[::1]"}) {
    EXPECT_EQ(status("Host: " + host + "\r\n"), 200) << host;
    EXPECT_EQ(status("Host: " + host + port + "\r\n"), 200) << host;
  }
  for (const std::string host : {"evil.example", "localhost.evil.example", "localhost:80.evil", "",
                                 "127.0.0.1.evil.example", "[::1].evil", ":80"})
    EXPECT_EQ(status("Host: " + host + "\r\n"), 421) << host;
  EXPECT_EQ(status(""), 421);
  EXPECT_EQ(status("Host: localhost\r\nHost: evil.example\r\n"), 421);
  const std::string own = "Host: 127.0.0.1" + port + "\r\nOrigin: ";
  EXPECT_EQ(status(own + "http://127.0.0.1" + port + "\r\n"), 200);
  for (const std::string origin : {"http://evil.example", "http://127.0.0.1:1", "null"})
    EXPECT_EQ(status(own + origin + "\r\n"), 403) << origin;
  const std::string foreign = "Host: evil.example\r\nOrigin: http://evil.example\r\n\r\n";
  EXPECT_EQ(statusOf(sent(on_file, kGet + foreign)), 200) << "no page reaches a file";
}

/// Each refusal has its status and a line of JSON, and a line on stderr.
TEST_F(Serve, WhatHttpForbidsIsRefusedWithItsStatus) {
  const std::string errors = file("errors");
  Server server({"-q", "--port", "0", "--max-body", "1", "--patience", "1"}, map(), "", errors);
  const auto expect = [&](int status, const std::string& bytes, bool goes = false) {
    const std::string answer = sent(server, bytes, goes);
    EXPECT_EQ(statusOf(answer), status) << bytes.substr(0, 100) << answer;
    if (status == 200 || statusOf(answer) == 0) return answer;
    EXPECT_EQ(jsonOf(answer)["status"], "error") << answer;
    EXPECT_EQ(answer.find("bad_function"), std::string::npos) << answer;
    return answer;
  };
  const std::string host = "Host: localhost\r\n", long_line(9000, 'a');
  const std::string put = expect(405, "PUT /localize HTTP/1.1\r\n" + host + "\r\n");
  EXPECT_NE(put.find("Allow: POST\r\n"), std::string::npos) << put;
  expect(405, headOf("/health", lengthOf("")));
  expect(404, "PUT /nowhere HTTP/1.1\r\n" + host + "\r\n");
  expect(413, headOf("/localize", "Content-Length: 99999999999999999999999\r\n"));
  expect(414, "GET /" + long_line + " HTTP/1.1\r\n" + host + "\r\n");
  expect(414, std::string(100000, '\0'));
  expect(431, kGet + host + "A: " + long_line + "\r\n\r\n");
  std::string lines;
  for (int i = 0; i < 10; ++i) lines += "A: " + long_line.substr(0, 8000) + "\r\n";
  expect(431, kGet + host + lines + "\r\n");
  expect(415, headOf("/localize", "Content-Encoding: zstd\r\n" + lengthOf("x")) + "x");
  expect(415, headOf("/localize", "Content-Type: multipart/mixed\r\n" + lengthOf("x")) + "x");
  expect(501, headOf("/localize", "Transfer-Encoding: gzip, chunked\r\n"));
  expect(400, headOf("/localize", "Content-Length: 1\r\nContent-Length: 2\r\n") + "xx");
  expect(400, headOf("/localize", "Content-Length: -1\r\n") + "xx");
  expect(400, "noise\x1b[2J\r\n\r\n");
  expect(400, "GET /health", true);
  expect(408, "");
  const std::string said = readText(errors);
  EXPECT_NE(said.find("error: PUT /localize HTTP/1.1: 405, "), std::string::npos) << said;
  EXPECT_NE(said.find("error: noise\\x1b[2J: 400, "), std::string::npos) << said;
  EXPECT_EQ(lineCount(said), 16u) << said;
  std::string many;
  for (int i = 0; i < 2000; ++i) many += "0-,";
  const std::string whole = expect(200, "GET /openapi.json HTTP/1.1\r\n" + host + "\r\n");
  EXPECT_EQ(
      expect(200, "GET /openapi.json HTTP/1.1\r\n" + host + "Range: bytes=" + many + "0-\r\n\r\n"),
      whole);
  EXPECT_EQ(lineCount(readText(errors)), 16u) << "what is answered is told if --verbose";
}

TEST_F(Serve, AFileOfAFormIsABody) {
  const std::string cloud_file = cloud();
  Server server({"--port", "0"}, map());
  const auto answered = [&](const std::string& body, const std::string& range = "") {
    return sent(server, headOf("/localize", "Content-Type: multipart/form-data; boundary=X\r\n" +
                                                range + lengthOf(body)) +
                            body);
  };
  const std::string field = "--X\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\nb\r\n";
  const std::string scan =
      "--X\r\nContent-Disposition: form-data; name=\"file\"; filename=\"query.ply\"\r\n\r\n" +
      cloud_file + "\r\n";
  httplib::Client client = clientOf(server);
  const auto alone =
      client.Post("/localize?name=query.ply", cloud_file, "application/octet-stream");
  ASSERT_TRUE(alone);
  const std::string right = answered(field + scan + "--X--\r\n", "Range: bytes=0-3\r\n");
  EXPECT_EQ(statusOf(right), 200);
  EXPECT_EQ(untimed(jsonOf(right).dump()), untimed(alone->body));
  for (const std::string& wrong : {field + "--X--\r\n", scan + scan + "--X--\r\n", scan,
                                   std::string("no parts"), std::string()}) {
    const std::string answer = answered(wrong);
    EXPECT_EQ(statusOf(answer), 400) << answer;
    EXPECT_EQ(answer.find("bad_function"), std::string::npos) << answer;
  }
  EXPECT_EQ(statusOf(answered(field + "--X" + std::string(1000000, 'x'))), 413)
      << "what is no part is not kept";
}

/// Whatever the bytes of a request mean.
TEST_F(Serve, EveryByteCounts) {
  Server server({"--port", "0", "--max-body", "1"}, map());
  const std::string head = headOf("/localize", "Transfer-Encoding: chunked\r\n");
  const std::string much(1200000, '0');
  EXPECT_EQ(statusOf(sent(server, head + much)), 413) << "a size of a chunk";
  EXPECT_EQ(statusOf(sent(server, head + "1;" + much)), 413) << "its extension";
  std::string pieces;
  for (int i = 0; i < 4; ++i) pieces += "8;" + std::string(600000, '0') + "\r\n12345678\r\n";
  EXPECT_EQ(statusOf(sent(server, head + pieces)), 413) << "one by one";
  pieces.clear();
  for (int i = 0; i < 200000; ++i) pieces += "1\r\nx\r\n";
  EXPECT_EQ(statusOf(sent(server, head + pieces)), 413) << "around small chunks";
}

/// Names in the folder that all users share are nobody's before the server has made them.
TEST_F(Serve, BodiesLieWhereNobodyPlantedAnything) {
  const TemporaryFolder shared;
  const std::string body = cloud(), victim = file("victim");
  writeText(victim + "/0", "precious");
  writeText(shared / "xview-serve", "a file");
  fs::create_directory_symlink(victim, shared / "xview-serve-aaaaaa");
  fs::create_directory(shared / "xview-serve-bbbbbb");
  fs::permissions(shared / "xview-serve-bbbbbb", fs::perms::all);
  writeText(shared / "xview-serve-bbbbbb/0", "of others");
  const auto others = [&] {
    std::vector<std::string> folders;
    for (const auto& entry : fs::directory_iterator(shared.path())) {
      const std::string name = entry.path().filename();
      if (name.size() == 18 && name.find("aaaaaa") + name.find("bbbbbb") > 1000)
        folders.push_back(entry.path());
    }
    return folders;
  };
  const std::string variable = "TMPDIR=" + shared.path();
  std::optional<Server> killed(std::in_place, std::vector<std::string>{"--port", "0"}, map(),
                               variable);
  ASSERT_EQ(others().size(), 1u);
  const std::string first = others()[0];
  struct stat made = {};
  ASSERT_EQ(stat(first.c_str(), &made), 0);
  EXPECT_EQ(made.st_mode & 0777u, 0700u);
  Server server({"--port", "0"}, map(), variable);
  EXPECT_EQ(others().size(), 2u) << "that of one that runs stays";
  writeText(first + "/0", "a body");
  killed.reset();
  Server next({"--port", "0"}, map(), variable);
  EXPECT_FALSE(fs::exists(first)) << "that of one that was killed does not";
  for (const std::string& folder : others()) fs::remove_all(folder);
  httplib::Client client = clientOf(server);
  const auto answer = localize(client, body);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200) << answer->body;
  EXPECT_EQ(others().size(), 1u) << "is made again";
  EXPECT_EQ(server.stop(SIGTERM), 143);
  EXPECT_EQ(next.stop(SIGTERM), 143);
  EXPECT_TRUE(others().empty());
  EXPECT_EQ(readText(victim + "/0"), "precious");
  EXPECT_EQ(readText(shared / "xview-serve-bbbbbb/0"), "of others");
}

TEST_F(Serve, SocketsOfOthersStay) {
  const std::string path = file("own");
  Server old({"--socket", path}, map());
  fs::remove(path);
  Server successor({"--socket", path}, map());
  EXPECT_EQ(old.stop(SIGTERM), 143);
  EXPECT_EQ(statusOf(sent(successor, kGet + "\r\n")), 200);
  EXPECT_EQ(successor.stop(SIGKILL), -1);
  Server again({"--socket", path}, map());
  EXPECT_EQ(statusOf(sent(again, kGet + "\r\n")), 200) << "that of a killed one is replaced";
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  for (const int kind : {SOCK_DGRAM, SOCK_STREAM}) {
    const std::string taken = file("kind" + std::to_string(kind));
    taken.copy(address.sun_path, sizeof address.sun_path - 1);
    const auto* const where = reinterpret_cast<sockaddr*>(&address);
    const int other = socket(AF_UNIX, kind, 0);
    ASSERT_EQ(bind(other, where, sizeof address), 0);
    int waiting = -1;
    if (kind == SOCK_STREAM) {
      listen(other, 0);
      waiting = connected(taken);  // nobody is accepted, and no second one can wait
    }
    const Outcome outcome = runXview({"serve", "-q", map(), "--socket", taken});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
    EXPECT_TRUE(fs::exists(taken));
    if (waiting >= 0) close(waiting);
    close(other);
  }
}

TEST_F(Serve, ASocketHasTheModeAndGroupThatAreAskedFor) {
  const std::string path = file("shared"), group = std::to_string(getgid());
  {
    Server server({"--socket", path, "--socket-group", group}, map());
    struct stat made = {};
    ASSERT_EQ(stat(path.c_str(), &made), 0);
    EXPECT_EQ(made.st_mode & 0777u, 0660u);
    EXPECT_EQ(made.st_gid, getgid());
  }
  {
    Server server({"--socket", path, "--socket-mode", "0640"}, map());
    struct stat made = {};
    ASSERT_EQ(stat(path.c_str(), &made), 0);
    EXPECT_EQ(made.st_mode & 0777u, 0640u);
  }
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--socket", path, "--socket-mode", "0888"},
        {"--socket", path, "--socket-mode", "07777"},
        {"--socket", path, "--socket-group", "no such group"},
        {"--port", "0", "--socket-mode", "0660"}}) {
    std::vector<std::string> arguments = {"serve", "-q", map()};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(runXview(arguments).code, 2) << wrong.back();
  }
}

TEST_F(Serve, ThoseWhoSayNothingMakeRoom) {
  const std::string body = cloud();
  Server server({"--port", "0", "--max-clients", "2", "--patience", "50"}, map());
  std::vector<int> idle;
  for (int i = 0; i < 12; ++i) idle.push_back(connected(server.address));
  EXPECT_EQ(statusOf(sent(server, kGet + "Host: localhost\r\n\r\n")), 200);
  std::vector<int> slow;
  for (int i = 0; i < 6; ++i) {
    slow.push_back(connected(server.address));
    const std::string begin = headOf("/localize", "Content-Length: 1000\r\n") + "x";
    send(slow.back(), begin.data(), begin.size(), MSG_NOSIGNAL);
  }
  EXPECT_EQ(statusOf(sent(server, kGet + "Host: localhost\r\n\r\n")), 200);
  EXPECT_EQ(statusOf(received(idle[0])), 503);
  for (std::size_t i = 1; i < idle.size(); ++i) close(idle[i]);
  for (const int client : slow) close(client);
  httplib::Client client = clientOf(server);
  EXPECT_TRUE(comes([&] {
    const auto answer = localize(client, body);
    return answer && answer->status == 200;
  }));
}

/// A file that is replaced as soon as the address is there, or has the time of the one before.
TEST_F(Serve, NoChangeOfTheMapIsMissedAndNoOldOneIsKept) {
  const std::string body = cloud(), own = file("changing.xvm");
  fs::copy_file(map(), own);
  const auto time = fs::last_write_time(own);
  Server server({"--port", "0"}, own);
  const auto exchange = [&] {
    fs::copy_file(map(), file("next.xvm"));
    fs::last_write_time(file("next.xvm"), time);
    fs::rename(file("next.xvm"), own);
  };
  httplib::Client client = clientOf(server);
  for (int exchanges = 1; exchanges <= 2; ++exchanges) {
    exchange();
    const auto tracked =
        client.Post("/track/robot" + std::to_string(exchanges), body, "application/octet-stream");
    ASSERT_TRUE(tracked);
    EXPECT_TRUE(comes([&] {
      const auto health = client.Get("/health");
      return health && Json::parse(health->body)["exchanges"] == exchanges;
    }));
  }
  EXPECT_TRUE(comes([&] {
    const auto metrics = client.Get("/metrics");
    return metrics && metrics->body.find("xview_maps_in_memory 1\n") != std::string::npos;
  })) << "two robots are silent since their map was exchanged";
}

/// What takes too long is told, and does not keep the server from ending.
TEST_F(Serve, AQueryThatDoesNotEndIsTold) {
  const std::string errors = file("stuck");
  std::string noise(16 * 3000000, '\0');
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < noise.size(); i += 4) {
    state = state * 1664525u + 1013904223u;
    const float value = static_cast<float>(state >> 8) * (i % 16 == 8 ? 1e-6f : 6e-6f);
    std::memcpy(noise.data() + i, &value, sizeof value);
  }
  Server server({"--port", "0", "--jobs", "1", "--patience", "0.5"}, map(), "", errors);
  std::thread client([&] {
    while (statusOf(sent(server, headOf("/localize", lengthOf(noise)) + noise)) == 408) {
    }
  });
  const auto isStuck = [&] {
    const std::string answer = sent(server, kGet + "Host: localhost\r\n\r\n");
    return statusOf(answer) == 503 && jsonOf(answer)["status"] == "stuck";
  };
  EXPECT_TRUE(comes(isStuck));
  EXPECT_EQ(server.stop(SIGTERM), 143);
  client.join();
  EXPECT_NE(readText(errors).find("1 requests are not answered"), std::string::npos);
}

TEST_F(Serve, TellsItsServiceManager) {
  const std::string path = file("manager");
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int manager = socket(AF_UNIX, SOCK_DGRAM, 0);
  const timeval most{20, 0};
  setsockopt(manager, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof most);
  ASSERT_EQ(bind(manager, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const auto told = [&] {
    std::string text(100, '\0');
    text.resize(
        static_cast<std::size_t>(std::max<ssize_t>(recv(manager, text.data(), text.size(), 0), 0)));
    return text;
  };
  Server server({"--port", "0"}, map(), "NOTIFY_SOCKET=" + path);
  EXPECT_EQ(told(), "READY=1");
  EXPECT_EQ(told(), "WATCHDOG=1");
  EXPECT_EQ(server.stop(SIGTERM), 143);
  std::string last = told();
  while (last == "WATCHDOG=1") last = told();
  EXPECT_EQ(last, "STOPPING=1");
  close(manager);
}

}  // namespace
}  // namespace xview::test
#endif
