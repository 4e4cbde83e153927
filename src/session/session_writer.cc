#include "session/session_writer.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include "core/files.h"
#include "core/trace.h"
#include "session/load_session.h"
#include "session/tile_file.h"
#include "session/tile_rows.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

constexpr double kPeriod_s = 0.5;
constexpr int kPeriodFrames = 15;

bool AreSame(const PosedFrame& a, const PosedFrame& b) {
  return a.index == b.index && a.keyframe == b.keyframe && a.segment == b.segment &&
         a.stamp_s == b.stamp_s && a.world_from_camera == b.world_from_camera;
}

// Measurements of stored edges change only by calibrations, and each calibration changes a_from_b.
bool AreSame(const StoredEdge& a, const StoredEdge& b) {
  return a.in_graph == b.in_graph && a.edge.a_from_b == b.edge.a_from_b;
}

std::vector<StoredEdge> EdgesOf(const Backend& backend) {
  std::vector<StoredEdge> edges;
  const std::vector<bool> in_graph = backend.poses().loops_in_graph();
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : backend.poses().edges()) {
    edges.push_back({edge, edge.loop && in_graph[loop++]});
  }
  return edges;
}

template <typename Kept, typename RowOfOne>
std::vector<Row> Changed(const std::vector<Kept>& now, const std::vector<Kept>& saved,
                         const RowOfOne& row_of) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (i < saved.size() && AreSame(now[i], saved[i])) continue;
    rows.push_back(row_of(static_cast<std::int64_t>(i), now[i]));
  }
  return rows;
}

void WriteNewFile(const std::string& path, const std::string& bytes) {
  const int file = CreateFileExclusively(path);
  if (file < 0) ThrowCannotWrite(path);
  const bool is_written = WriteAll(file, bytes.data(), bytes.size());
  if (!is_written) {
    const int reason = errno;
    close(file);
    errno = reason;
    ThrowCannotWrite(path);
  }
  if (close(file) != 0) ThrowCannotWrite(path);
}

}  // namespace

SessionContent ContentOf(const Slam& slam) {
  const Backend& backend = *slam.backend();
  SessionContent content = {backend.poses().frames(),  backend.poses().keyframes(),
                            EdgesOf(backend),          backend.settled_keyframes(),
                            backend.is_calibrating(),  std::nullopt,
                            backend.color_latency_s(), slam.map(),
                            slam.corrections_of_map()};
  if (backend.is_recalibrated()) content.calibration = *backend.calibration();
  return content;
}

struct SessionWriter::Update {
  SessionRow facts;  // without the counts of views and tiles
  std::vector<Row> runs, frames, keyframes, edges;
  std::vector<std::pair<std::int64_t, UnsavedView>> views;  // key: keyframe index
  bool keeps_calibration = true;
  std::vector<ChangedTile> tiles;
  bool is_all = false;  // `tiles` has all tiles
};

SessionWriter::SessionWriter(const std::string& folder, Mode mode)
    : folder_(folder), lock_(folder, {}) {
  ThrowIf(HasSession(folder_) && mode == Mode::kNew, folder_,
          " contains a session already: continue this session or choose another folder");
}

void SessionWriter::Open(const DepthSensor& sensor) {
  fs::create_directories(TilesOf(folder_));
  if (!HasSession(folder_)) {
    SessionRow first;
    first.sensor = sensor;
    MakeDatabase(DatabaseOf(folder_), RowOf(first));
  }
  database_ = std::make_unique<Database>(DatabaseOf(folder_), Database::Mode::kWrite);
  RequireSchema(database_.get());
  database_->Run("PRAGMA journal_mode = WAL");
  ForEachIntact(database_.get(), "session", [&](RowReader* row) { facts_ = TakeSession(row); });
  RequireSameSensor(folder_, facts_.sensor, sensor);
  tiles_ = ReadTileRows(database_.get());
  views_ = facts_.views;
  calibration_frames_ = facts_.calibration_frames;
  saves_ = facts_.saves;
  RemoveStrayTiles(folder_, tiles_);
}

SessionWriter::~SessionWriter() {
  try {
    Wait();
  } catch (const std::exception& error) {
    LOG(WARNING) << folder_ << ": the last save of the session failed: " << error.what();
  }
}

void SessionWriter::Begin(const std::vector<SessionRun>& new_runs, const DepthSensor& sensor,
                          Slam* slam) {
  Open(sensor);
  runs_ = new_runs;
  first_run_ = facts_.runs;
  facts_.runs += static_cast<std::int64_t>(runs_.size());
  slam->OnKeyframe([this](int frame, const ViewOfKeyframe& view,
                          const std::shared_ptr<const RgbdFrame>& calibration_frame) {
    new_views_.push_back({frame, view, calibration_frame});
  });
}

void SessionWriter::KeepViews(const std::vector<KeyframeLink>& keyframes,
                              const std::vector<PlaceView>& views) {
  for (std::size_t k = 0; k < views.size(); ++k) {
    if (views[k].empty()) continue;
    new_views_.push_back({keyframes[k].frame, [view = views[k]] { return view; }, nullptr});
  }
}

void SessionWriter::SaveIfDue(const Slam& slam, double stamp_s) {
  if (slam.backend()->poses().frames().empty()) return;
  ++frames_since_save_;
  const bool is_due = !has_saved_ || frames_since_save_ >= kPeriodFrames ||
                      std::abs(stamp_s - saved_stamp_s_) >= kPeriod_s;
  if (!is_due) return;
  saved_stamp_s_ = stamp_s;
  frames_since_save_ = 0;
  Save(ContentOf(slam));
}

void SessionWriter::Replace(const SessionContent& content) {
  changed_tiles_ = ChangedTiles();
  has_saved_ = false;
  Finish(content);
}

void SessionWriter::Finish(const SessionContent& content) {
  if (content.frames.empty()) return Wait();
  for (SessionRun& run : runs_) run.ended = true;
  are_runs_saved_ = false;
  Save(content);
  Wait();
  RemoveStrayTiles(folder_, tiles_);
  database_->Run("PRAGMA wal_checkpoint(TRUNCATE)");
  const int opened = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return;
  syncfs(opened);
  close(opened);
}

void SessionWriter::Wait() {
  if (writing_.valid()) writing_.get();
}

void SessionWriter::Save(const SessionContent& content) {
  waits_ +=
      writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
  Wait();
  writing_ = std::async(std::launch::async, [this, update = Difference(content)]() mutable {
    Write(std::move(update));
  });
}

SessionWriter::Update SessionWriter::Difference(const SessionContent& content) {
  const TraceSlice slice("save_session");
  Update update;
  update.is_all = !has_saved_;
  for (std::size_t i = 0; i < runs_.size() && !are_runs_saved_; ++i) {
    update.runs.push_back(RowOf(first_run_ + static_cast<std::int64_t>(i), runs_[i]));
  }
  update.frames = Changed(content.frames, frames_,
                          [](std::int64_t, const PosedFrame& frame) { return RowOf(frame); });
  frames_ = content.frames;
  update.edges = Changed(content.edges, edges_,
                         [](std::int64_t key, const StoredEdge& edge) { return RowOf(key, edge); });
  edges_ = content.edges;
  const std::vector<KeyframeLink>& links = content.keyframes;
  for (; keyframes_ < links.size(); ++keyframes_) {
    update.keyframes.push_back(RowOf(static_cast<std::int64_t>(keyframes_), links[keyframes_]));
  }
  for (UnsavedView& view : new_views_) {
    const auto at =
        std::lower_bound(links.begin(), links.end(), view.frame,
                         [](const KeyframeLink& link, int frame) { return link.frame < frame; });
    update.views.emplace_back(at - links.begin(), std::move(view));
  }
  new_views_.clear();
  update.keeps_calibration = content.is_calibrating;
  update.tiles = changed_tiles_.Take(content.map, content.map_corrections, frames_.back().index);
  facts_.calibration = content.calibration;
  facts_.color_latency_s = content.color_latency_s;
  facts_.frames = static_cast<std::int64_t>(frames_.size());
  facts_.keyframes = static_cast<std::int64_t>(links.size());
  facts_.edges = static_cast<std::int64_t>(edges_.size());
  facts_.settled_keyframes = static_cast<std::int64_t>(content.settled_keyframes);
  update.facts = facts_;
  has_saved_ = are_runs_saved_ = true;
  return update;
}

void SessionWriter::Write(Update update) {
  const TraceSlice slice("write_session");
  ++saves_;
  std::vector<Row> views, calibration;
  for (const auto& [keyframe, fresh] : update.views) {
    views.push_back(RowOf(keyframe, fresh.view()));
    if (fresh.calibration_frame && update.keeps_calibration) {
      calibration.push_back(RowOf(keyframe, *fresh.calibration_frame));
    }
  }
  database_->Transact([&] {
    database_->Put("runs", update.runs);
    database_->Put("frames", update.frames);
    database_->Put("keyframes", update.keyframes);
    database_->Put("edges", update.edges);
    database_->Put("views", views);
    views_ += static_cast<std::int64_t>(views.size());
    if (!update.keeps_calibration && calibration_frames_ > 0) {
      database_->Run("DELETE FROM calibration");
      calibration_frames_ = 0;
    }
    database_->Put("calibration", calibration);
    calibration_frames_ += static_cast<std::int64_t>(calibration.size());
    WriteTiles(update);
    update.facts.views = views_;
    update.facts.calibration_frames = calibration_frames_;
    update.facts.tiles = static_cast<std::int64_t>(tiles_.size());
    update.facts.saves = saves_;
    database_->Put("session", {RowOf(update.facts)});
  });
  // Tile files of the previous save may still be in use, so they are removed one save later.
  std::error_code none;
  for (const std::string& file : removable_) fs::remove(file, none);
  removable_ = std::exchange(superseded_, {});
}

void SessionWriter::WriteTiles(const Update& update) {
  std::set<std::int64_t> gone;
  if (update.is_all) {
    for (const auto& [key, tile] : tiles_) gone.insert(key);
  }
  std::vector<Row> rows;
  const auto path_of = [&](std::int64_t key, std::int64_t save) {
    return TilesOf(folder_) + "/" + TileName(key, save);
  };
  for (const ChangedTile& changed : update.tiles) {
    gone.erase(changed.key);
    const auto former = tiles_.find(changed.key);
    if (changed.surfels == 0) {
      if (former != tiles_.end()) gone.insert(changed.key);
      continue;
    }
    if (former != tiles_.end()) superseded_.push_back(path_of(changed.key, former->second.save));
    WriteNewFile(path_of(changed.key, saves_), changed.bytes);
    const TileRow tile = {changed.key, saves_, static_cast<std::int64_t>(changed.bytes.size()),
                          Crc(changed.bytes.data(), changed.bytes.size()), changed.surfels};
    tiles_[changed.key] = tile;
    rows.push_back(RowOf(tile));
  }
  database_->Put("tiles", rows);
  for (const std::int64_t key : gone) {
    superseded_.push_back(path_of(key, tiles_[key].save));
    database_->Delete("tiles", key);
    tiles_.erase(key);
  }
}

}  // namespace surfit
