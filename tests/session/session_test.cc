#include "surfit/session/session.h"

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <thread>

#include "mapping/same_map.h"
#include "session/some_session.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr int kFrames = 40;

const SimulatedSequence& Room() {
  static const auto* const room = new SimulatedSequence(SimulateRoom(1, kFrames, Sensor::kKinect));
  return *room;
}

// Surfels of a map in a canonical order.
std::vector<decltype(AsTuple(Surfel()))> Sorted(const SurfelMap& map) {
  std::vector<decltype(AsTuple(Surfel()))> surfels;
  for (const std::int32_t id : map.Ids()) surfels.push_back(AsTuple(map[id]));
  std::sort(surfels.begin(), surfels.end());
  return surfels;
}

void ExpectStateOf(const SlamState& state, const Slam& slam) {
  const Backend& backend = *slam.backend();
  ExpectSamePoses(state.frames, backend.poses().frames());
  ASSERT_EQ(state.keyframes.size(), backend.poses().keyframes().size());
  ASSERT_EQ(state.views.size(), state.keyframes.size());
  for (std::size_t k = 0; k < state.keyframes.size(); ++k) {
    EXPECT_EQ(state.keyframes[k].frame, backend.poses().keyframes()[k].frame);
    EXPECT_EQ(state.keyframes[k].parent_frame, backend.poses().keyframes()[k].parent_frame);
    EXPECT_FALSE(state.views[k].empty());
  }
  ASSERT_EQ(state.edges.size(), backend.poses().edges().size());
  for (std::size_t e = 0; e < state.edges.size(); ++e) {
    EXPECT_EQ(state.edges[e].a_from_b.Matrix(), backend.poses().edges()[e].a_from_b.Matrix());
    EXPECT_EQ(state.edges[e].information, backend.poses().edges()[e].information);
  }
  ExpectConsistent(state.map);
  EXPECT_EQ(Sorted(state.map), Sorted(slam.map()));
}

TEST(Session, EqualsTheStateOfSlamAfterEachSave) {
  const TempFolder folder;
  const std::string path = folder.path() + "/session";
  const auto slam = KeepSession(Room(), kFrames, path);
  const Session session = ReadSession(path);
  ExpectStateOf(session.state, *slam);
  EXPECT_EQ(session.state.settled_keyframes, session.state.keyframes.size());
  EXPECT_EQ(session.sensor.camera.fx, Room().camera.fx);
  ASSERT_EQ(session.runs.size(), 1u);
  EXPECT_EQ(session.runs[0].sequence, "/recordings/room");
  EXPECT_TRUE(session.runs[0].ended);
  EXPECT_GE(session.saves, kFrames / 15);
  EXPECT_THAT(CheckSession(path), IsEmpty());
  // Saved every half second, not only at the end.
  const SessionCounts counts = CountSession(path);
  EXPECT_EQ(counts.surfels, static_cast<std::int64_t>(slam->map().size()));
  EXPECT_EQ(counts.frames, kFrames);
}

// After a save the files contain the state of SLAM at this time, including all changes since the
// last save.
TEST(Session, EverySaveIsComplete) {
  const TempFolder folder;
  const std::string path = folder.path() + "/session";
  const DepthSensor sensor = {Room().camera, {}};
  Slam slam(sensor, SessionSlamOptions(), Room().world_from_camera[0]);
  SessionWriter writer(path, SessionWriter::Mode::kNew);
  writer.Begin({SomeRun()}, sensor, &slam);
  for (int i = 0; i < 30; ++i) {
    slam.Process(Room().frames[i]);
    writer.SaveIfDue(slam, i);  // one second later each, so every state is saved
    if (i % 10 != 9) continue;
    writer.SaveIfDue(slam, i + 0.5);  // waits for the previous save
    writer.SaveIfDue(slam, i + 1.);
    const Session session = ReadSession(path);
    ExpectSamePoses(session.state.frames, slam.backend()->poses().frames());
    EXPECT_EQ(Sorted(session.state.map), Sorted(slam.map())) << i;
  }
}

TEST(SessionThreads, SavesInTheBackground) {
  const TempFolder folder;
  const auto run = [&](const std::string& name) {
    KeepSession(Room(), 12, folder.path() + name);
    return ReadSession(folder.path() + name).state.frames;
  };
  ExpectSamePoses(run("/a"), run("/b"));
}

TEST(Session, RejectsASecondWriter) {
  const TempFolder folder;
  const SessionWriter writer(folder.path(), SessionWriter::Mode::kNew);
  ExpectInputError([&] { SessionWriter(folder.path(), SessionWriter::Mode::kContinue); },
                   Names(folder.path()));
}

TEST(Session, RejectsReplacement) {
  const TempFolder folder;
  KeepSession(Room(), 2, folder.path());
  ExpectInputError([&] { SessionWriter(folder.path(), SessionWriter::Mode::kNew); },
                   Names(folder.path()));
}

TEST(Session, RejectsAnotherSensor) {
  const TempFolder folder;
  KeepSession(Room(), 2, folder.path());
  DepthSensor other = {Room().camera, {}};
  other.camera.fx += 1;
  Slam slam(other, SessionSlamOptions(), {});
  SessionWriter writer(folder.path(), SessionWriter::Mode::kContinue);
  ExpectInputError([&] { writer.Begin({SomeRun()}, other, &slam); }, Names(folder.path()));
}

TEST(Session, RejectsOtherVersionsAndFiles) {
  const TempFolder folder;
  KeepSession(Room(), 2, folder.path());
  const auto run = [&](const char* sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((folder.path() + "/session.db").c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(database);
  };
  run("PRAGMA user_version = 1");
  ExpectInputError([&] { ReadSession(folder.path()); }, Names(folder.path(), 1));
  run("PRAGMA user_version = 2; PRAGMA application_id = 5");
  ExpectInputError([&] { ReadSession(folder.path()); }, Names(folder.path()));
  ExpectInputError([&] { ReadSession(folder.path() + "/none"); }, Names(folder.path() + "/none"));
}

TEST(Session, WaitsForALockAndReportsIt) {
  const TempFolder folder;
  KeepSession(Room(), 2, folder.path());
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path() + "/session.db").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_NO_THROW(ReadSession(folder.path()));  // a writer does not block readers
  const DepthSensor sensor = {Room().camera, {}};
  Slam slam(sensor, SessionSlamOptions(), {});
  SessionWriter writer(folder.path(), SessionWriter::Mode::kContinue);
  writer.Begin({SomeRun()}, sensor, &slam);
  slam.Process(Room().frames[0]);
  ExpectInputError([&] { writer.Finish(slam); }, Names(folder.path() + "/session.db"));
  sqlite3_close(database);
}

// A separate process, killed by Session.SurvivesSigkill.
TEST(SessionWriting, WritesUntilSigkill) {
  const char* const given = std::getenv("SURFIT_TEST_SESSION");
  if (!given) GTEST_SKIP() << "run by Session.SurvivesSigkill";
  const std::string folder = given;
  const DepthSensor sensor = {Room().camera, {}};
  Slam slam(sensor, SessionSlamOptions(), Room().world_from_camera[0]);
  SessionWriter writer(folder + "/session", SessionWriter::Mode::kNew);
  writer.Begin({SomeRun()}, sensor, &slam);
  for (int i = 0; i < kFrames; ++i) {
    slam.Process(Room().frames[i]);
    WriteBytes(folder + "/progress", std::to_string(i) + "\n");
    writer.SaveIfDue(slam, Room().frames[i].stamp_s);
  }
}

// After SIGKILL at any time, the files contain a complete save that is at most one second old.
TEST(Session, SurvivesSigkill) {
  std::mt19937_64 rng(1);
  std::uniform_int_distribution<int> some_ms(0, 300);
  for (int round = 0; round < 6; ++round) {
    const TempFolder folder;
    const std::string session = folder.path() + "/session";
    setenv("SURFIT_TEST_SESSION", folder.path().c_str(), 1);
    RunningProgram writing(std::filesystem::read_symlink("/proc/self/exe"),
                           {"--gtest_filter=SessionWriting.*"});
    const auto last = [&] { return std::atoi(ReadBytes(folder.path() + "/progress").c_str()); };
    while (last() < 2 + 5 * round && writing.IsRunning()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(some_ms(rng)));
    writing.Signal(SIGKILL);
    writing.Wait();
    EXPECT_THAT(CheckSession(session), IsEmpty());
    const SlamState state = ReadSession(session).state;
    ASSERT_FALSE(state.frames.empty() && last() > 30);
    const int saved = state.frames.empty() ? -1 : state.frames.back().index;
    EXPECT_LE(last() - saved, 30) << round;
    // The session can be continued.
    EXPECT_NO_THROW(SessionWriter(session, SessionWriter::Mode::kContinue));
  }
}

}  // namespace
}  // namespace surfit::testing
