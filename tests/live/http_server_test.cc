#include "apps/live/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "live/loopback_client.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using testing::HasSubstr;

const char* const kGood = "GET /good HTTP/1.1\r\nHost: localhost\r\n\r\n";
constexpr std::size_t kLarge = 16 << 20;  // bytes, more than the buffers of sockets

// Test server: /good returns a short answer, /large a large answer, /later answers after Wake(),
// and other targets return 403.
class HttpServerTest : public testing::Test {
 protected:
  explicit HttpServerTest(HttpLimits limits = Short())
      : server_("127.0.0.1", 0, limits,
                [this](const HttpRequest& request, bool must) { return Answer(request, must); }) {}

  static HttpLimits Short() {
    HttpLimits limits;
    limits.request_s = limits.hold_s = limits.write_s = 0.5;
    return limits;
  }

  std::optional<HttpAnswer> Answer(const HttpRequest& request, bool must) {
    if (request.target == "/throws") throw std::runtime_error("a failure");
    if (request.target == "/later" && !is_ready_ && !must) return std::nullopt;
    HttpAnswer answer;
    answer.has_token = request.target != "/other";
    answer.status = answer.has_token ? 200 : 403;
    const std::size_t size = request.target == "/large" ? kLarge : 4;
    if (answer.has_token) answer.body = std::make_shared<std::string>(size, 'x');
    return answer;
  }

  LoopbackClient Client() { return LoopbackClient(server_.port()); }
  ReceivedAnswer Ask(const std::string& bytes) { return Client().Ask(bytes); }
  void ExpectAlive() { EXPECT_EQ(Ask(kGood).body, "xxxx"); }

  std::atomic<bool> is_ready_{false};
  HttpServer server_;
};

TEST_F(HttpServerTest, AnswersConsecutiveRequests) {
  LoopbackClient client = Client();
  for (int i = 0; i < 3; ++i) {
    const ReceivedAnswer answer = client.Ask(kGood);
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, "xxxx");
    for (const char* header :
         {"Cache-Control: no-store", "X-Content-Type-Options: nosniff", "X-Frame-Options: DENY",
          "Referrer-Policy: no-referrer", "Cross-Origin-Resource-Policy: same-origin"}) {
      EXPECT_THAT(answer.head, HasSubstr(header));
    }
    EXPECT_THAT(answer.head, testing::Not(HasSubstr("Access-Control")));
  }
}

TEST_F(HttpServerTest, RejectsMalformedRequests) {
  const std::string head = "GET /good HTTP/1.1\r\nHost: localhost\r\n";
  const std::string large(20000, 'a');
  const std::pair<std::string, int> kCases[] = {
      {"nonsense\r\n\r\n", 400},
      {"GET\r\n\r\n", 400},
      {"GET /good HTTP/9.9\r\n\r\n", 400},
      {std::string("GET /\0 HTTP/1.1\r\n\r\n", 19), 400},
      {"GET /good HTTP/1.1\r\n\r\n", 400},  // without a host
      {head + "Host: localhost\r\n\r\n", 400},
      {head + "Content-Length: -1\r\n\r\n", 400},
      {head + "Content-Length: 1\r\nContent-Length: 2\r\n\r\n", 400},
      {head + "Transfer-Encoding: chunked\r\n\r\nzz\r\n", 400},
      {head + "no colon\r\n\r\n", 400},
      {head + "Content-Length: 5000\r\n\r\n", 413},
      {head + "Content-Length: 18446744073709551615\r\n\r\n", 413},
      {head + "Transfer-Encoding: chunked\r\n\r\nfffffff\r\n" + large, 413},
      {"GET /" + large + " HTTP/1.1\r\n\r\n", 431},
      {head + "X: " + large + "\r\n\r\n", 431},
  };
  for (const auto& [bytes, status] : kCases) {
    LoopbackClient client = Client();
    EXPECT_EQ(client.Ask(bytes).status, status) << bytes.substr(0, 80);
    EXPECT_TRUE(client.IsClosedWithin(5)) << bytes.substr(0, 80);
  }
  ExpectAlive();
}

TEST_F(HttpServerTest, SurvivesAnyBytes) {
  std::uint32_t state = 1;
  for (int i = 0; i < 200; ++i) {
    std::string bytes = i % 2 == 0 ? kGood : "";
    for (int k = 0; k < 100; ++k) {
      state = 1664525 * state + 1013904223;
      const char byte = static_cast<char>(state >> 24);
      bytes.empty() || i % 2 == 1 ? bytes.push_back(byte)
                                  : void(bytes[state % bytes.size()] = byte);
    }
    Client().Send(bytes);
  }
  ExpectAlive();
}

// A client that sends single bytes and never completes a request.
TEST_F(HttpServerTest, ClosesConnectionsOfSlowSenders) {
  LoopbackClient slow = Client();
  const auto begin = std::chrono::steady_clock::now();
  const std::string request(kGood);
  std::size_t sent = 0;
  while (sent < request.size() && slow.Send(request.substr(sent++, 1)) &&
         !slow.IsClosedWithin(0.05)) {
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(sent, request.size());
  EXPECT_GT(took.count(), 0.4);
}

TEST_F(HttpServerTest, ClosesConnectionsOfStalledReadersAndServesOthers) {
  LoopbackClient stalled = Client();
  stalled.Send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  for (int i = 0; i < 10; ++i) ExpectAlive();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  // The remaining bytes of the socket buffers, and then the end of the connection.
  EXPECT_LT(stalled.Receive().body.size(), kLarge);
}

TEST_F(HttpServerTest, SendsALargeAnswerCompletely) {
  EXPECT_EQ(Ask("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n").body.size(), kLarge);
}

const char* const kLater = "GET /later HTTP/1.1\r\nHost: localhost\r\n\r\n";

TEST_F(HttpServerTest, AnswersWaitingRequestsAfterTheTimeout) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(Ask(kLater).body, "xxxx");
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_GT(took.count(), 0.4);
}

// A server whose answers may wait for an hour.
class PatientHttpServerTest : public HttpServerTest {
 protected:
  PatientHttpServerTest() : HttpServerTest(Patient()) {}

  static HttpLimits Patient() {
    HttpLimits limits;
    limits.hold_s = 3600;
    return limits;
  }
};

TEST_F(PatientHttpServerTest, AnswersWaitingRequestsAfterWake) {
  LoopbackClient client = Client();
  client.Send(kLater);
  server_.Wake();  // the answer is not ready yet
  EXPECT_EQ(client.Receive(0.1).status, 0);
  is_ready_ = true;
  server_.Wake();
  EXPECT_EQ(client.Receive().body, "xxxx");
}

TEST_F(HttpServerTest, ClosesOnlyTheConnectionOfAFailure) {
  EXPECT_EQ(Ask("GET /throws HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 0);
  ExpectAlive();
}

// 1000 open connections do not block other clients. The server keeps 32 of them.
TEST_F(HttpServerTest, ServesOthersDespiteAThousandConnections) {
  rlimit files;
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = std::min<rlim_t>(files.rlim_max, 4096);
  setrlimit(RLIMIT_NOFILE, &files);
  LoopbackClient viewer = Client();
  EXPECT_EQ(viewer.Ask(kGood).status, 200);
  std::vector<LoopbackClient> idle;
  for (int i = 0; i < 1000; ++i) {
    idle.push_back(Client());
    ASSERT_TRUE(idle.back().is_connected());
    if (i % 100 == 99) {
      EXPECT_EQ(viewer.Ask(kGood).status, 200);
      ExpectAlive();
    }
  }
  int open = 0;
  for (LoopbackClient& client : idle) open += client.IsClosedWithin(0.001) ? 0 : 1;
  EXPECT_LE(open, 32);
  EXPECT_EQ(viewer.Ask(kGood).status, 200);
}

TEST_F(HttpServerTest, RejectsMoreThanTheMaximumOfClients) {
  std::vector<LoopbackClient> clients;
  for (int i = 0; i < 64; ++i) {
    clients.push_back(Client());
    EXPECT_EQ(clients.back().Ask(kGood).status, 200);
  }
  EXPECT_EQ(Ask(kGood).status, 503);
  clients.pop_back();
  int status = 503;
  for (int i = 0; i < 50 && status == 503; ++i) status = Ask(kGood).status;
  EXPECT_EQ(status, 200);
}

TEST(HttpServer, RejectsAUsedPort) {
  const auto nothing = [](const HttpRequest&, bool) { return HttpAnswer(); };
  const HttpServer first("127.0.0.1", 0, {}, nothing);
  try {
    const HttpServer second("127.0.0.1", first.port(), {}, nothing);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(std::to_string(first.port())));
  }
  EXPECT_THROW(HttpServer("no address", 0, {}, nothing), InputError);
}

}  // namespace
}  // namespace surfit
