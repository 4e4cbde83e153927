#include "session/merge_sessions.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "io/files/output_folder.h"
#include "session/schema.h"
#include "session/session_writer.h"
#include "session/tile_rows.h"
#include "surfit/core/error.h"
#include "surfit/mapping/move_map.h"

namespace surfit {
namespace {

void Shift(int shift, int keyframes, int stretches, int submaps, SlamState* state) {
  for (PosedFrame& frame : state->frames) {
    frame.index += shift;
    frame.keyframe += keyframes;
    frame.segment += stretches;
  }
  for (KeyframeLink& link : state->keyframes) {
    link.frame += shift;
    if (link.parent_frame != KeyframeLink::kNone) link.parent_frame += shift;
    link.submap += submaps;
  }
  for (PoseGraphEdge& edge : state->edges) {
    edge.a += static_cast<std::size_t>(keyframes);
    edge.b += static_cast<std::size_t>(keyframes);
  }
}

// Transforms all poses of a session. Returns the correction for its surfels.
FrameCorrections MoveTo(const Rigid3d& new_from_old, SlamState* state) {
  for (PosedFrame& frame : state->frames) {
    frame.world_from_camera = new_from_old * frame.world_from_camera;
  }
  return {state->frames.front().index, {new_from_old}};
}

// Sessions are placed beside each other with this gap, until a loop closure connects them.
constexpr double kGap_m = 1;

// Bounding box of cameras and surfels in world coordinates, m.
Eigen::AlignedBox3d BoxOf(const SlamState& state) {
  Eigen::AlignedBox3d box;
  for (const PosedFrame& frame : state.frames) box.extend(frame.world_from_camera.translation);
  for (const std::int32_t id : state.map.Ids()) {
    box.extend(state.map[id].position_in_world.cast<double>());
  }
  return box;
}

// Sorts loop closures by their later keyframe, after all odometry edges. The back end adds edges in
// this order.
void SortLoops(SlamState* state) {
  std::vector<std::pair<PoseGraphEdge, bool>> loops;
  std::vector<PoseGraphEdge> odometry;
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : state->edges) {
    if (edge.loop) {
      loops.emplace_back(edge, state->loops_in_graph[loop++]);
    } else {
      odometry.push_back(edge);
    }
  }
  std::stable_sort(loops.begin(), loops.end(), [](const auto& x, const auto& y) {
    return std::max(x.first.a, x.first.b) < std::max(y.first.a, y.first.b);
  });
  state->edges = std::move(odometry);
  state->loops_in_graph.clear();
  for (const auto& [edge, in_graph] : loops) {
    state->edges.push_back(edge);
    state->loops_in_graph.push_back(in_graph);
  }
}

template <typename T>
void Append(std::vector<T> from, std::vector<T>* to) {
  to->insert(to->end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

class Merger {
 public:
  Merger(Session first, int gap) : gap_(gap), all_(std::move(first)) {
    all_.state.settled_keyframes = all_.state.keyframes.size();
    first_keyframe_.push_back(0);
  }

  void Add(Session other) {
    SlamState &state = all_.state, &added = other.state;
    const int shift = state.frames.back().index + gap_ - added.frames.front().index;
    const int submaps = 1 + MostSubmap();
    first_keyframe_.push_back(state.keyframes.size());
    Shift(shift, static_cast<int>(state.keyframes.size()), 1 + state.frames.back().segment, submaps,
          &added);
    const double beside_m = std::max(0., BoxOf(state).max().x() + kGap_m - BoxOf(added).min().x());
    const Rigid3d moved(Eigen::Quaterniond::Identity(), {beside_m, 0, 0});
    for (SessionRun& run : other.runs) run.shift += shift;
    MoveMap(MoveTo(moved, &added), &added.map);
    if (!state.calibration) state.calibration = added.calibration;
    SortLoops(&added);
    Append(std::move(other.runs), &all_.runs);
    Append(std::move(added.frames), &state.frames);
    Append(std::move(added.keyframes), &state.keyframes);
    Append(std::move(added.views), &state.views);
    Append(std::move(added.edges), &state.edges);
    state.loops_in_graph.insert(state.loops_in_graph.end(), added.loops_in_graph.begin(),
                                added.loops_in_graph.end());
    AppendSurfels(added.map, shift, &state.map);
  }

  Session& all() { return all_; }
  std::size_t SessionOf(int frame) const {
    std::size_t session = 0;
    while (session + 1 < first_frame_.size() && first_frame_[session + 1] <= frame) ++session;
    return session;
  }
  void Begin() {
    all_.state.calibration_frames.clear();
    for (const std::size_t keyframe : first_keyframe_) {
      first_frame_.push_back(all_.state.keyframes[keyframe].frame);
    }
  }

 private:
  int MostSubmap() const {
    int most = 0;
    for (const KeyframeLink& link : all_.state.keyframes) most = std::max(most, link.submap);
    return most;
  }

  const int gap_;
  Session all_;
  std::vector<std::size_t> first_keyframe_;
  std::vector<int> first_frame_;
};

// Gap between the frame indices of two sessions. The gap exceeds the index range of each session.
int GapBetween(const std::vector<Session>& sessions, const LoopOptions& options) {
  int gap = SessionGap(options);
  for (const Session& session : sessions) {
    const std::vector<PosedFrame>& frames = session.state.frames;
    gap = std::max(gap, frames.back().index - frames.front().index + 1);
  }
  return gap;
}

std::vector<Session> ReadSessions(const std::vector<std::string>& folders) {
  std::vector<Session> sessions;
  for (const std::string& folder : folders) {
    sessions.push_back(ReadSession(folder));
    ThrowIf(sessions.back().state.frames.empty(), folder,
            " has no frames, must have at least one for merging");
    RequireSameSensor(folder, sessions.back().sensor, sessions.front().sensor);
  }
  return sessions;
}

}  // namespace

MergeSummary MergeSessions(const std::vector<std::string>& folders, const SlamOptions& options,
                           const std::string& output) {
  SessionWriter writer(output, SessionWriter::Mode::kNew);
  std::vector<Session> sessions = ReadSessions(folders);
  const int gap = GapBetween(sessions, options.loops);
  Merger merger(std::move(sessions.front()), gap);
  const DepthSensor sensor = merger.all().sensor;
  for (std::size_t i = 1; i < sessions.size(); ++i) merger.Add(std::move(sessions[i]));
  merger.Begin();
  const std::vector<SessionRun> runs = merger.all().runs;
  const std::vector<KeyframeLink> keyframes = merger.all().state.keyframes;
  const std::vector<PlaceView> views = merger.all().state.views;
  SlamOptions slam_options = options;
  slam_options.loops.enabled = true;
  // The gap limits the search to loop closures between sessions.
  slam_options.loops.find.min_gap = gap;
  Slam slam(sensor, slam_options, std::move(merger.all().state), StateUse::kContinue);
  writer.Begin(runs, sensor, &slam);
  writer.KeepViews(keyframes, views);
  slam.Finish();
  writer.Finish(slam);

  MergeSummary summary;
  summary.sessions = folders.size();
  std::vector<std::set<std::size_t>> joined(folders.size());
  for (const LoopRecord& loop : slam.backend()->poses().loops()) {
    const std::size_t a = merger.SessionOf(loop.source_frame);
    const std::size_t b = merger.SessionOf(loop.target_frame);
    if (!loop.in_graph || a == b) continue;
    ++summary.loops_between;
    joined[a].insert(b);
    joined[b].insert(a);
  }
  std::set<std::size_t> found = {0}, next = {0};
  while (!next.empty()) {
    std::set<std::size_t> reached;
    for (const std::size_t session : next) {
      for (const std::size_t other : joined[session]) {
        if (found.insert(other).second) reached.insert(other);
      }
    }
    next = std::move(reached);
  }
  for (std::size_t i = 0; i < folders.size(); ++i) {
    if (found.count(i) == 0) summary.apart.push_back(folders[i]);
  }
  summary.frames = slam.backend()->poses().frames().size();
  summary.keyframes = keyframes.size();
  summary.surfels = slam.map().size();
  summary.merged_duplicates = slam.merged_duplicates();
  return summary;
}

void CompactSession(const std::string& folder) {
  ReadSession(folder);  // throws for a damaged session
  const OutputFolder lock(folder, {});
  Database database(DatabaseOf(folder), Database::Mode::kWrite);
  RemoveStrayTiles(folder, ReadTileRows(&database));
  database.Run("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)");
}

}  // namespace surfit
