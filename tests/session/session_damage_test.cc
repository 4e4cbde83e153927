// Sessions with changed or missing bytes.
#include <gmock/gmock.h>

#include <filesystem>
#include <random>

#include "mapping/same_map.h"
#include "session/database.h"
#include "session/some_session.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class SessionDamage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const SimulatedSequence room = SimulateRoom(1, 12, Sensor::kKinect);
    KeepSession(room, 12, Whole());
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string Whole() { return folder_->path() + "/whole"; }
  std::string Copy() const {
    const std::string copy = own_.path() + "/copy";
    fs::remove_all(copy);
    fs::copy(Whole(), copy, fs::copy_options::recursive);
    return copy;
  }
  static std::vector<fs::path> Tiles(const std::string& session) {
    std::vector<fs::path> tiles;
    for (const auto& entry : fs::directory_iterator(session + "/tiles")) {
      tiles.push_back(entry.path());
    }
    std::sort(tiles.begin(), tiles.end());
    return tiles;
  }
  // Expects that CheckSession() reports this file, and that ReadSession() rejects it.
  static void ExpectTold(const std::string& session, const std::string& name) {
    EXPECT_THAT(CheckSession(session), ::testing::Contains(Names(name)));
    ExpectInputError([&] { ReadSession(session); }, Names(name));
  }

  static TempFolder* folder_;
  TempFolder own_;
};

TempFolder* SessionDamage::folder_ = nullptr;

void Flip(const std::string& path, std::size_t at) {
  std::string bytes = ReadBytes(path);
  bytes[at] = static_cast<char>(bytes[at] ^ 0x40);
  WriteBytes(path, bytes);
}

// True if both sessions are equal.
bool IsSame(const Session& a, const Session& b) {
  const SlamState &x = a.state, &y = b.state;
  if (x.frames.size() != y.frames.size() || x.edges.size() != y.edges.size() ||
      x.views.size() != y.views.size() || x.map.size() != y.map.size() ||
      x.calibration_frames.size() != y.calibration_frames.size()) {
    return false;
  }
  for (std::size_t i = 0; i < x.frames.size(); ++i) {
    if (x.frames[i].world_from_camera.Matrix() != y.frames[i].world_from_camera.Matrix() ||
        x.frames[i].stamp_s != y.frames[i].stamp_s) {
      return false;
    }
  }
  for (std::size_t k = 0; k < x.views.size(); ++k) {
    if (!(x.views[k].depth == y.views[k].depth)) return false;
    if (x.keyframes[k].frame != y.keyframes[k].frame) return false;
  }
  for (std::size_t e = 0; e < x.edges.size(); ++e) {
    if (x.edges[e].information != y.edges[e].information) return false;
  }
  return true;
}

TEST_F(SessionDamage, OfEveryTileIsReportedByName) {
  const std::string session = Copy();
  for (const fs::path& tile : Tiles(session)) {
    const std::string bytes = ReadBytes(tile);
    Flip(tile, bytes.size() / 2);
    ExpectTold(session, tile.filename().string());
    WriteBytes(tile, bytes.substr(0, bytes.size() - 1));
    ExpectTold(session, tile.filename().string());
    fs::remove(tile);
    ExpectTold(session, tile.filename().string());
    WriteBytes(tile, bytes);
  }
  EXPECT_THAT(CheckSession(session), IsEmpty());
}

TEST_F(SessionDamage, LockIsNoDamage) {
  const std::string session = Copy();
  Database other(session + "/session.db", Database::Mode::kWrite);
  other.Run("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE");
  ExpectInputError([&] { CheckSession(session); }, Names("session.db", "locked"));
  other.Run("COMMIT");
}

// Changes a byte of each page. The change is detected, or it is in unused space of the page.
TEST_F(SessionDamage, OfEveryPageIsReported) {
  constexpr std::size_t kPage = 4096;
  const std::string session = Copy(), path = session + "/session.db";
  const std::string bytes = ReadBytes(path);
  ASSERT_EQ(bytes.size() % kPage, 0u);
  const Session whole = ReadSession(session);
  std::mt19937_64 rng(3);
  std::uniform_int_distribution<std::size_t> in_page(0, kPage - 1);
  std::size_t told = 0, pages = bytes.size() / kPage;
  for (std::size_t page = 0; page < pages; ++page) {
    const std::size_t at = page * kPage + in_page(rng);
    Flip(path, at);
    std::vector<std::string> damages;
    try {
      damages = CheckSession(session);
    } catch (const InputError& error) {
      damages = {error.what()};
    }
    if (damages.empty()) {
      EXPECT_TRUE(IsSame(ReadSession(session), whole)) << "byte " << at;
    } else {
      ++told;
      EXPECT_THAT(damages, Each(Names("session.db")));
    }
    WriteBytes(path, bytes);
  }
  EXPECT_GE(told, pages * 3 / 4);  // most of a page is used
}

TEST_F(SessionDamage, OfATruncatedFileIsReported) {
  const std::string session = Copy(), path = session + "/session.db";
  const std::string bytes = ReadBytes(path);
  for (const double share : {0.99, 0.5, 0.1, 0.0}) {
    WriteBytes(path, bytes.substr(0, static_cast<std::size_t>(share * bytes.size())));
    std::vector<std::string> damages;
    try {
      damages = CheckSession(session);
    } catch (const InputError& error) {
      damages = {error.what()};
    }
    EXPECT_THAT(damages, Not(IsEmpty())) << share;
  }
}

}  // namespace
}  // namespace surfit::testing
