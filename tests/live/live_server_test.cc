#include "apps/live/live_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

#include "live/live_fixture.h"
#include "live/loopback_client.h"
#include "live/sample_client.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

SampleChanges ReadChanges(const std::string& bytes) {
  SampleChanges changes;
  std::uint32_t head[6] = {};
  if (bytes.size() < sizeof(head)) return changes;
  std::memcpy(head, bytes.data(), sizeof(head));
  changes.epoch = head[0];
  changes.level = head[1];
  changes.slots = head[2];
  changes.version = head[3];
  changes.next = head[4];
  changes.slot.resize(head[5]);
  changes.surfel.resize(head[5]);
  EXPECT_EQ(bytes.size(), sizeof(head) + 20 * changes.slot.size());
  std::memcpy(changes.slot.data(), &bytes[sizeof(head)], 4 * changes.slot.size());
  std::memcpy(changes.surfel.data(), &bytes[sizeof(head) + 4 * changes.slot.size()],
              16 * changes.slot.size());
  return changes;
}

class LiveServerTest : public testing::Test {
 protected:
  LiveServerTest() {
    ServeOptions options;
    options.port = 0;
    auto server = std::make_unique<LiveServer>(options, &run_);
    server_ = server.get();
    const std::string url = server->url();
    host_ = url.substr(7, url.find('/', 7) - 7);
    port_ = std::atoi(host_.substr(host_.find(':') + 1).c_str());
    token_ = url.substr(url.find('/', 7) + 1, 32);
    run_.Add(std::move(server));
  }

  std::string Request(const std::string& method, const std::string& target,
                      const std::string& more = "") const {
    return method + " " + target + " HTTP/1.1\r\nHost: " + host_ + "\r\n" + more + "\r\n";
  }
  ReceivedAnswer Ask(const std::string& request) const {
    return LoopbackClient(port_).Ask(request);
  }
  ReceivedAnswer Get(const std::string& page) const {
    return Ask(Request("GET", "/" + token_ + "/" + page));
  }
  ReceivedAnswer Post(const std::string& page, const std::string& more = "") const {
    return Ask(Request("POST", "/" + token_ + "/" + page, "Content-Length: 0\r\n" + more));
  }
  json State() const { return json::parse(Get("state?want=62").body); }

  // Receives one complete round of map changes.
  void TakeRound(SampleClient* client) const {
    for (bool goes_on = true; goes_on;) {
      const SamplePlace place = client->place();
      goes_on =
          client->Take(ReadChanges(Get(Concat("map?epoch=", place.epoch, "&level=", place.level,
                                              "&since=", place.version, "&slot=", place.slot))
                                       .body));
    }
  }

  LiveFixture live_;
  LiveRun run_{live_.interrupted_, [this] { live_.interrupted_ = true; }};
  LiveServer* server_ = nullptr;
  std::string host_, token_;
  int port_ = 0;
};

std::size_t CountShown(const SampleClient& client) {
  std::size_t count = 0;
  for (const PackedSurfel& surfel : client.surfels()) count += surfel[14] != 0 ? 1 : 0;
  return count;
}

TEST_F(LiveServerTest, ListensOnlyOnLoopback) {
  EXPECT_THAT(server_->url(), testing::MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/[0-9a-f]+/"));
}

TEST_F(LiveServerTest, ServesThePageWithoutExternalScripts) {
  const ReceivedAnswer page = Get("");
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.body, HasSubstr("surfit.Live = class"));
  EXPECT_THAT(page.body, HasSubstr("OrbitControls"));
  EXPECT_THAT(page.body, Not(HasSubstr("src=\"http")));
}

TEST_F(LiveServerTest, RejectsRequestsWithoutTheToken) {
  live_.Tell(&run_);
  std::string other = token_;
  other[31] = other[31] == '0' ? '1' : '0';
  for (const std::string& target :
       {std::string("/"), std::string("/state"), "/" + other + "/", "/" + other + "/state",
        "/" + token_.substr(1) + "/", "/" + token_ + "0/", "/" + token_, "//" + token_ + "/",
        "/?token=" + token_, std::string("/favicon.ico")}) {
    for (const char* method : {"GET", "POST", "PUT", "OPTIONS", "BREW"}) {
      const ReceivedAnswer answer = Ask(Request(method, target, "Content-Length: 0\r\n"));
      EXPECT_EQ(answer.status, 403) << method << target;
      EXPECT_EQ(answer.body, "Forbidden") << method << target;
    }
  }
}

TEST_F(LiveServerTest, ServesNoFilesOfTheDisk) {
  for (const char* page :
       {"../etc/passwd", "../../../../etc/passwd", "/etc/passwd", "%2e%2e/etc/passwd",
        "..%2f..%2fetc/passwd", "....//etc/passwd", "file:///etc/passwd", "state/../../etc/passwd",
        "\\etc\\passwd", "summary.json", "frame.jpg/../../map.ply", "live.html", ".", "..",
        "map/"}) {
    const ReceivedAnswer answer = Get(page);
    EXPECT_EQ(answer.status, 404) << page;
    EXPECT_EQ(answer.body, "Not Found") << page;
  }
}

TEST_F(LiveServerTest, AcceptsOnlyGetAndThePostsOfItsButtons) {
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "CONNECT", "BREW"}) {
    EXPECT_EQ(Ask(Request(method, "/" + token_ + "/state")).status, 405) << method;
  }
  for (const char* page : {"pause", "go_on", "step", "stop"}) EXPECT_EQ(Get(page).status, 404);
  for (const char* page : {"", "state", "map", "path", "frame.jpg", "quit"}) {
    EXPECT_EQ(Post(page).status, 404) << page;
  }
  EXPECT_FALSE(run_.is_paused());
  EXPECT_FALSE(live_.interrupted_);
}

// A page of another site: by DNS rebinding or with a form.
TEST_F(LiveServerTest, RejectsRequestsOfOtherPages) {
  const std::string target = "/" + token_ + "/pause HTTP/1.1\r\nContent-Length: 0\r\nHost: ";
  EXPECT_EQ(Ask("POST " + target + "evil.example\r\n\r\n").status, 403);
  EXPECT_EQ(Ask("GET /" + token_ + "/state HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 403);
  EXPECT_EQ(Post("pause", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(Post("pause", "Origin: null\r\n").status, 403);
  EXPECT_FALSE(run_.is_paused());
  EXPECT_EQ(Post("pause", "Origin: http://" + host_ + "\r\n").status, 200);
  EXPECT_TRUE(run_.is_paused());
}

TEST_F(LiveServerTest, ServesTheState) {
  EXPECT_EQ(State()["frames_done"], 0);
  live_.report_.state = FrameState::kLost;
  run_.Pause();  // the complete state is sent in a pause
  std::thread run([this] { live_.Tell(&run_); });
  json state;
  for (int i = 0; i < 200 && state["frames_done"] != 1; ++i) {
    state = State();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(state["frames_done"], 1);
  EXPECT_EQ(state["frames_total"], 100);
  EXPECT_EQ(state["frame_state"], "lost");
  EXPECT_EQ(state["paused"], true);
  EXPECT_EQ(state["advice"][0]["kind"], "lost");
  EXPECT_EQ(state["camera"]["width"], 160);
  EXPECT_EQ(state["map_points"], 100);
  Post("go_on");
  run.join();
  EXPECT_EQ(State()["paused"], false);
}

TEST_F(LiveServerTest, AnswersWaitingRequestsWithANewState) {
  const std::uint32_t number = State()["number"];
  LoopbackClient client(port_);
  client.Send(Request("GET", Concat("/", token_, "/state?after=", number)));
  EXPECT_EQ(client.Receive(0.2).status, 0);
  live_.Tell(&run_);
  EXPECT_GT(json::parse(client.Receive().body)["number"], number);
}

TEST_F(LiveServerTest, StopsTheRunOnce) {
  EXPECT_EQ(Post("stop").status, 200);
  EXPECT_TRUE(live_.interrupted_);
}

// During a pause a viewer receives the complete map, the pictures and the trajectory.
TEST_F(LiveServerTest, ServesMapTrajectoryAndPicturesInAPause) {
  State();  // a viewer is present
  for (int i = 0; i < 20; ++i) {
    live_.AddRow();
    live_.Tell(&run_);
  }
  run_.Pause();
  std::thread run([this] { live_.Tell(&run_); });
  SampleClient client;
  std::size_t shown = 0;
  for (int i = 0; i < 200 && shown != live_.map_.size(); ++i) {
    TakeRound(&client);
    shown = CountShown(client);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(shown, live_.map_.size());
  EXPECT_EQ(shown, 2100u);
  for (const std::int32_t id : live_.map_.Ids()) {
    ASSERT_EQ(client.surfels().at(id), PackSurfel(live_.map_[id])) << id;
  }
  EXPECT_EQ(json::parse(Get("path").body)["positions"].size(), 3 * 22u);
  for (const char* picture : {"frame.jpg", "model.jpg", "normals.jpg"}) {
    const ReceivedAnswer answer = Get(picture);
    EXPECT_EQ(answer.status, 200) << picture;
    EXPECT_EQ(answer.body.substr(0, 3), "\xff\xd8\xff") << picture;
  }
  run_.GoOn();
  run.join();
}

// Frame and model pictures belong to the same frame. A late request is rejected instead of
// receiving the next frame.
TEST_F(LiveServerTest, ServesFrameAndModelOfTheSameFrame) {
  State();
  std::uint32_t last = 0;
  for (int i = 0; i < 3; ++i) {
    json numbers;
    for (int wait = 0; wait < 200; ++wait) {
      live_.Tell(&run_);
      numbers = State()["numbers"];
      if (numbers["frame"] > last) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    const auto number = numbers["frame"].get<std::uint32_t>();
    EXPECT_GT(number, last);
    EXPECT_EQ(numbers["model"], number);
    EXPECT_EQ(numbers["normals"], number);
    for (const char* picture : {"frame.jpg", "model.jpg", "normals.jpg"}) {
      EXPECT_EQ(Get(Concat(picture, "?number=", number)).status, 200) << picture;
      if (last == 0) continue;
      EXPECT_EQ(Get(Concat(picture, "?number=", last)).status, 204) << picture;
    }
    last = number;
  }
}

// Without viewers no pictures are rendered.
TEST_F(LiveServerTest, RendersNoPicturesWithoutViewers) {
  for (int i = 0; i < 5; ++i) live_.Tell(&run_);
  EXPECT_EQ(Get("frame.jpg").status, 204);
  EXPECT_EQ(Get("model.jpg").status, 204);
  EXPECT_EQ(Get("path").status, 204);
}

// A late run skips pictures for at most one second.
TEST_F(LiveServerTest, SkipsPicturesWhileFramesWait) {
  State();  // a viewer is present
  live_.age_ms_ = 40;
  live_.Tell(&run_);
  EXPECT_EQ(Get("path").status, 204);
  EXPECT_EQ(Get("frame.jpg").status, 204);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  live_.Tell(&run_);
  EXPECT_EQ(json::parse(Get("path").body)["positions"].size(), 3 * 3u);
  EXPECT_EQ(Get("frame.jpg").status, 200);
}

TEST_F(LiveServerTest, ServesTheFinalResult) {
  State();
  live_.Tell(&run_);
  SampleClient client;
  TakeRound(&client);
  LiveFixture final;
  for (int i = 0; i < 9; ++i) final.AddRow();
  run_.Keep({final.map_, {{0, Rigid3d()}}});
  TakeRound(&client);
  EXPECT_EQ(CountShown(client), 1000u);
  const json state = State();
  EXPECT_EQ(state["done"], true);
  EXPECT_EQ(state["shown"], 1000);
}

TEST_F(LiveServerTest, EndsSoonWithoutViewers) {
  run_.Keep({live_.map_, {}});
  const auto begin = std::chrono::steady_clock::now();
  run_.Stay();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
  SampleClient client;
  TakeRound(&client);
  State();
  run_.Stay();
  EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

// The data exceed the rate limit of one second.
TEST_F(LiveServerTest, SendsTheRestAfterTheRun) {
  constexpr std::size_t kWhole = 24000000;
  for (int i = 0; i < 100; ++i) live_.AddRow();
  run_.Keep({live_.map_, {}});
  State();
  std::atomic<std::size_t> sent{0};
  std::thread viewer([&] {
    while (sent < kWhole) sent += Get("map?epoch=0&level=0&since=0&slot=0").body.size() + 1;
  });
  run_.Stay();
  EXPECT_GE(sent, kWhole);
  viewer.join();
}

// A stalled client and clients with endless requests during a run. Also a test for ThreadSanitizer.
TEST(LiveServer, ServesDuringARun) {
  LiveFixture live;
  LiveRun run(live.interrupted_, [] {});
  ServeOptions options;
  options.port = 0;
  auto server = std::make_unique<LiveServer>(options, &run);
  const std::string url = server->url(), host = url.substr(7, url.find('/', 7) - 7),
                    path = url.substr(url.find('/', 7));
  const int port = std::atoi(host.substr(host.find(':') + 1).c_str());
  run.Add(std::move(server));
  const auto request = [&](const std::string& page) {
    return "GET " + path + page + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n";
  };
  std::atomic<bool> is_over{false};
  std::atomic<int> answers{0};
  std::vector<std::thread> viewers;
  for (int i = 0; i < 3; ++i) {
    viewers.emplace_back([&] {
      LoopbackClient client(port);
      while (!is_over) {
        for (const char* page : {"state?want=62", "map", "path", "frame.jpg", "model.jpg"}) {
          answers += client.Ask(request(page)).status >= 200 ? 1 : 0;
        }
      }
    });
  }
  LoopbackClient stalled(port);
  for (int i = 0; i < 100; ++i) stalled.Send(request(""));
  for (int i = 0; i < 200 || answers < 100; ++i) {
    live.AddRow();
    live.Tell(&run);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  is_over = true;
  for (std::thread& viewer : viewers) viewer.join();
  EXPECT_EQ(run.path().size(), static_cast<std::size_t>(live.frame_.index));
}

TEST(ServeOptions, AreValidated) {
  LiveFixture live;
  LiveRun run(live.interrupted_, [] {});
  ServeOptions options;
  EXPECT_THROW(LiveServer(options, &run), InputError);  // port -1
  options.port = 65536;
  EXPECT_THROW(LiveServer(options, &run), InputError);
  options.port = 0;
  options.address = "evil.example";
  EXPECT_THROW(LiveServer(options, &run), InputError);
}

}  // namespace
}  // namespace surfit
