#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/files.h"
#include "session/load_session.h"
#include "session/schema.h"
#include "session/tile_file.h"

namespace surfit {
namespace {

constexpr std::size_t kMaxTileBytes = std::size_t{4} << 30;

class Loader {
 public:
  Loader(const std::string& folder, const DamageCallback& tell)
      : folder_(folder), tell_(tell), database_(DatabaseOf(folder), Database::Mode::kRead) {
    RequireSchema(&database_);
  }

  Session Load() {
    database_.Run("BEGIN");  // all tables are from the same save
    ReadFacts();
    session_.runs = ReadRuns();
    ReadFrames();
    ReadKeyframes();
    ReadViews();
    ReadCalibration();
    ReadEdges();
    ReadTiles();
    database_.Run("COMMIT");
    session_.sensor = facts_.sensor;
    session_.saves = facts_.saves;
    state().settled_keyframes = static_cast<std::size_t>(facts_.settled_keyframes);
    state().calibration = facts_.calibration;
    state().color_latency_s = facts_.color_latency_s;
    CheckLinks();
    return std::move(session_);
  }

  void ReadFacts() {
    bool is_there = false;
    ForEach("session", [&](RowReader* row) {
      facts_ = TakeSession(row);
      is_there = true;
    });
    ThrowIf(!is_there, database_.path(), ": the row of the session is missing");
  }

  std::vector<SessionRun> ReadRuns() {
    std::vector<SessionRun> runs;
    ForEach("runs", [&](RowReader* row) { runs.push_back(TakeRun(row)); });
    Expect("runs", static_cast<std::int64_t>(runs.size()), facts_.runs);
    return runs;
  }

 private:
  SlamState& state() { return session_.state; }

  // Calls `take` for each intact row. Reports damaged rows.
  void ForEach(const char* table, const std::function<void(RowReader*)>& take) {
    try {
      database_.ForEach(table, LayoutOf(table).count, [&](const Row& row, bool is_intact) {
        key_ = 0;
        if (const auto* key = std::get_if<std::int64_t>(&row[0])) key_ = *key;
        RowReader reader(row, Concat(database_.path(), ": row ", key_, " of ", table));
        if (!is_intact) return tell_(reader.from() + " is damaged: its checksum is wrong");
        try {
          take(&reader);
        } catch (const InputError& error) {
          tell_(error.what());
        }
      });
    } catch (const LockedError&) {
      throw;
    } catch (const InputError& error) {
      tell_(error.what());
    }
  }

  void Expect(const char* table, std::int64_t found, std::int64_t told) {
    if (found == told) return;
    tell_(Concat(database_.path(), ": table ", table, " has ", found, " intact rows, must have ",
                 told));
  }

  void ReadFrames() {
    ForEach("frames", [&](RowReader* row) { state().frames.push_back(TakeFrame(row)); });
    Expect("frames", static_cast<std::int64_t>(state().frames.size()), facts_.frames);
  }

  void ReadKeyframes() {
    ForEach("keyframes", [&](RowReader* row) { state().keyframes.push_back(TakeKeyframe(row)); });
    Expect("keyframes", static_cast<std::int64_t>(state().keyframes.size()), facts_.keyframes);
  }

  std::size_t KeyOfKeyframe(const RowReader& row) const {
    if (key_ < 0 || key_ >= facts_.keyframes) row.Fail("belongs to no keyframe");
    return static_cast<std::size_t>(key_);
  }

  void ReadViews() {
    std::int64_t count = 0;
    state().views.resize(state().keyframes.size());
    ForEach("views", [&](RowReader* row) {
      ++count;
      const std::size_t keyframe = KeyOfKeyframe(*row);
      PlaceView view = TakeStoredView(row);
      if (keyframe < state().views.size()) state().views[keyframe] = std::move(view);
    });
    Expect("views", count, facts_.views);
  }

  // Calibration frames are used only if all keyframes have one.
  void ReadCalibration() {
    auto& frames = state().calibration_frames;
    ForEach("calibration", [&](RowReader* row) {
      KeyOfKeyframe(*row);
      frames.push_back(std::make_shared<RgbdFrame>(TakeCalibrationFrame(row)));
    });
    Expect("calibration", static_cast<std::int64_t>(frames.size()), facts_.calibration_frames);
    if (frames.size() != state().keyframes.size()) frames.clear();
  }

  void ReadEdges() {
    ForEach("edges", [&](RowReader* row) {
      const StoredEdge kept = TakeEdge(row);
      const auto keyframes = static_cast<std::size_t>(facts_.keyframes);
      const auto settled = static_cast<std::size_t>(facts_.settled_keyframes);
      const auto& [a, b] = std::make_pair(kept.edge.a, kept.edge.b);
      if (a >= keyframes || b >= keyframes || a == b)
        row->Fail("connects keyframes that do not exist");
      if (kept.edge.loop ? std::max(a, b) >= settled : a > b)
        row->Fail("is a loop of an unsettled keyframe, or an odometry edge in wrong order");
      state().edges.push_back(kept.edge);
      if (kept.edge.loop) state().loops_in_graph.push_back(kept.in_graph);
    });
    Expect("edges", static_cast<std::int64_t>(state().edges.size()), facts_.edges);
  }

  void ReadTiles() {
    std::int64_t count = 0;
    ForEach("tiles", [&](RowReader* row) {
      const TileRow tile = TakeTile(row);
      ++count;
      const std::string path = TilesOf(folder_) + "/" + TileName(tile.key, tile.save);
      const std::string bytes = ReadFile(path, kMaxTileBytes);
      ThrowIf(static_cast<std::int64_t>(bytes.size()) != tile.bytes ||
                  Crc(bytes.data(), bytes.size()) != static_cast<std::uint32_t>(tile.crc),
              path, " is damaged: its checksum is wrong");
      UnpackTile(bytes, path, &state().map);
    });
    Expect("tiles", count, facts_.tiles);
  }

  void CheckLinks() {
    const auto keyframes = static_cast<int>(state().keyframes.size());
    if (facts_.settled_keyframes < 0 || facts_.settled_keyframes > keyframes) {
      tell_(database_.path() + ": settled_keyframes is larger than the number of keyframes");
    }
    if (state().frames.empty() != state().keyframes.empty()) {
      tell_(database_.path() + ": there are only frames or only keyframes, must be both");
    }
    for (const PosedFrame& frame : state().frames) {
      if (frame.keyframe >= 0 && frame.keyframe < keyframes) continue;
      tell_(Concat(database_.path(), ": frame ", frame.index, " belongs to no keyframe"));
    }
    int before = -1;
    for (const KeyframeLink& link : state().keyframes) {
      if (!IsFrame(link.frame) || link.frame <= before || link.submap < 0 ||
          (link.parent_frame != KeyframeLink::kNone && !IsParent(link))) {
        tell_(Concat(database_.path(), ": the keyframe of frame ", link.frame,
                     " has a missing frame, a missing parent or a wrong order"));
      }
      before = link.frame;
    }
  }

  bool IsFrame(int index) {
    const auto& frames = state().frames;
    const auto at =
        std::lower_bound(frames.begin(), frames.end(), index,
                         [](const PosedFrame& frame, int wanted) { return frame.index < wanted; });
    return at != frames.end() && at->index == index;
  }

  bool IsParent(const KeyframeLink& of) {
    const auto& links = state().keyframes;
    return of.parent_frame < of.frame &&
           std::any_of(links.begin(), links.end(),
                       [&](const KeyframeLink& link) { return link.frame == of.parent_frame; });
  }

  const std::string& folder_;
  const DamageCallback& tell_;
  Database database_;
  SessionRow facts_;
  Session session_;
  std::int64_t key_ = 0;
};

bool IsSameSensor(const DepthSensor& a, const DepthSensor& b) {
  return a.camera.width == b.camera.width && a.camera.height == b.camera.height &&
         a.camera.fx == b.camera.fx && a.camera.fy == b.camera.fy && a.camera.cx == b.camera.cx &&
         a.camera.cy == b.camera.cy && a.readout_s == b.readout_s &&
         a.noise.inverse_depth_sigma == b.noise.inverse_depth_sigma;
}

std::string Text(const DepthSensor& sensor) {
  const PinholeCamera& camera = sensor.camera;
  return Concat(camera.width, " x ", camera.height, ", fx ", camera.fx, ", fy ", camera.fy, ", cx ",
                camera.cx, ", cy ", camera.cy, ", noise ", sensor.noise.inverse_depth_sigma,
                " 1/m, readout ", sensor.readout_s, " s");
}

[[noreturn]] void Throw(const std::string& damage) { throw InputError(damage); }

void RequireSession(const std::string& folder) {
  if (HasSession(folder)) return;
  throw InputError(folder, " is not a session: session.db is missing");
}

}  // namespace

Session LoadSession(const std::string& folder, const DamageCallback& tell) {
  RequireSession(folder);
  return Loader(folder, tell).Load();
}

Session ReadSession(const std::string& folder) { return LoadSession(folder, Throw); }

std::vector<SessionRun> ReadSessionRuns(const std::string& folder) {
  RequireSession(folder);
  const DamageCallback tell = Throw;
  Loader loader(folder, tell);
  loader.ReadFacts();
  return loader.ReadRuns();
}

bool HasSession(const std::string& folder) {
  std::error_code none;
  return std::filesystem::exists(DatabaseOf(folder), none);
}

int SessionGap(const LoopOptions& options) {
  return 1 + std::max({options.find.min_gap, options.active_frames, options.frames_apart});
}

void RequireSameSensor(const std::string& folder, const DepthSensor& kept,
                       const DepthSensor& given) {
  if (IsSameSensor(kept, given)) return;
  throw InputError(folder, " is a session of another sensor, ", Text(kept), ", must be one of ",
                   Text(given));
}

SessionCounts CountSession(const std::string& folder) {
  RequireSession(folder);
  Database database(DatabaseOf(folder), Database::Mode::kRead);
  RequireSchema(&database);
  database.Run("BEGIN");
  SessionCounts counts;
  const auto count = [&](const char* from) {
    return database.Number(Concat("SELECT count(*) FROM ", from));
  };
  counts.runs = count("runs");
  counts.frames = count("frames");
  counts.keyframes = count("keyframes");
  counts.views = count("views");
  counts.edges = count("edges");
  counts.loops = count("edges WHERE loop");
  counts.tiles = count("tiles");
  counts.surfels = database.Number("SELECT sum(surfels) FROM tiles");
  counts.submaps = database.Number("SELECT count(DISTINCT submap) FROM keyframes");
  counts.saves = database.Number("SELECT saves FROM session");
  std::error_code none;
  for (std::filesystem::recursive_directory_iterator at(folder, none), end; at != end;
       at.increment(none)) {
    if (at->is_regular_file(none)) counts.bytes += static_cast<std::int64_t>(at->file_size(none));
  }
  return counts;
}

}  // namespace surfit
