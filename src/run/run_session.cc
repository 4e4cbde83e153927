#include "run/run_session.h"

#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "finishing/final_map.h"
#include "surfit/core/error.h"
#include "surfit/poses/pose_store.h"

namespace surfit {
namespace {

std::string FullPath(const std::string& path) {
  std::error_code none;
  const std::filesystem::path full = std::filesystem::weakly_canonical(path, none);
  return full.empty() ? path : full.string();
}

// Last frame of a run as index of its recording; -1: no frame. `end_index`: first session index of
// the next run.
int LastFrameOf(const SessionRun& run, int end_index, const SlamState& state) {
  int last = -1;
  for (const auto& frame : state.frames) {
    const int index = frame.index - run.shift;
    if (index >= run.first && frame.index < end_index) last = std::max(last, index);
  }
  return last;
}

std::vector<Rigid3d> PosesOfKeyframes(const std::vector<PosedFrame>& frames,
                                      const std::vector<KeyframeLink>& keyframes) {
  std::vector<Rigid3d> poses;
  std::size_t frame = 0;
  for (const KeyframeLink& link : keyframes) {
    while (frames[frame].index != link.frame) ++frame;
    poses.push_back(frames[frame].world_from_camera);
  }
  return poses;
}

// Sets the poses of the frames in `world_from_camera`. Other frames move rigidly with the previous
// frame.
void MoveFrames(const std::map<int, Rigid3d>& world_from_camera, std::vector<PosedFrame>* frames) {
  Rigid3d new_from_old;
  for (PosedFrame& frame : *frames) {
    const auto known = world_from_camera.find(frame.index);
    if (known != world_from_camera.end()) {
      new_from_old = known->second * frame.world_from_camera.Inverse();
    }
    frame.world_from_camera = new_from_old * frame.world_from_camera;
  }
}

// Adapts edge measurements to the new keyframe poses, so that the residuals do not change.
void MoveEdges(const std::vector<Rigid3d>& world_from_keyframe_before,
               const std::vector<Rigid3d>& world_from_keyframe_after,
               std::vector<StoredEdge>* edges) {
  std::vector<PoseGraphEdge> moved;
  for (const StoredEdge& kept : *edges) moved.push_back(kept.edge);
  Recalibrate(world_from_keyframe_before, world_from_keyframe_after, &moved);
  for (std::size_t i = 0; i < moved.size(); ++i) (*edges)[i].edge = moved[i];
}

}  // namespace

RunSession::RunSession(SlamRunOptions* options) : options_(*options) {
  using Mode = SessionWriter::Mode;
  if (!options->localize) {
    const Mode mode = options->continue_session ? Mode::kContinue : Mode::kNew;
    writer_ = std::make_unique<SessionWriter>(options->session, mode);
  }
  options->slam.loops.enabled = true;
  if (!options->localize && !options->continue_session) return;
  if (options->continue_session && !HasSession(options->session)) {
    LOG(WARNING) << options->session << " has no session: starting a new session";
    return;
  }
  Session session = ReadSession(options->session);
  sensor_ = session.sensor;
  if (session.state.frames.empty()) {
    if (options->localize)
      throw InputError(options->session +
                       " has no frames: localisation needs a session with frames");
    return;
  }
  state_ = std::move(session.state);
  if (options->continue_session) ContinueAfter(session.runs, &options->sequence);
  first_index_ =
      state_->frames.back().index + (is_contiguous_ ? 1 : SessionGap(options->slam.loops));
  shift_ = first_index_ - options->sequence.first;
}

void RunSession::ContinueAfter(const std::vector<SessionRun>& runs, SequenceOptions* sequence) {
  const std::string path = FullPath(sequence->path);
  const int newest = state_->frames.back().index;
  int newest_here = -1;  // index of the newest frame in this recording; -1: other recording
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const SessionRun& run = runs[i];
    if (run.sequence != path) continue;
    const int end = i + 1 == runs.size() ? newest + 1 : runs[i + 1].first + runs[i + 1].shift;
    const int last = LastFrameOf(run, end, *state_);
    if (last >= 0 && last + run.shift == newest) newest_here = last;
    if (last < sequence->first) continue;
    LOG(WARNING) << options_.session << " has frames of " << sequence->path << " up to " << last
                 << ": the run continues with the next frame";
    sequence->first = last + 1;
  }
  const int step = sequence->first - newest_here;
  is_contiguous_ = newest_here >= 0 && step > 0 && step <= sequence->stride;
  if (sequence->last >= 0 && sequence->last < sequence->first) {
    throw InputError(Concat(options_.session, ": all frames of ", sequence->path, " up to ",
                            sequence->last, " are already in the session"));
  }
}

void RunSession::Shift(ReadResult* result) const {
  result->index += shift_;
  if (result->frame) result->frame->index += shift_;
}

std::unique_ptr<Slam> RunSession::MakeSlam(const SequenceInfo& info, const SlamOptions& options) {
  RequireSameSensor(options_.session, sensor_, info.sensor());
  const StateUse use = options_.localize ? StateUse::kLocalize : StateUse::kContinue;
  SlamState state = *std::move(state_);
  return std::make_unique<Slam>(info.sensor(), options, std::move(state), use);
}

void RunSession::Begin(const SequenceInfo& info, Slam* slam) {
  if (!writer_) return;
  sensor_ = info.sensor();
  SessionRun run;
  run.sequence = FullPath(options_.sequence.path);
  run.format = info.format;
  run.first = options_.sequence.first;
  run.stride = options_.sequence.stride;
  run.shift = shift_;
  run.mirrored = info.mirrored;
  writer_->Begin({run}, info.sensor(), slam);
}

void RunSession::SaveIfDue(const Slam& slam, double stamp_s) {
  if (writer_) writer_->SaveIfDue(slam, stamp_s);
}

void RunSession::Finish(const Slam& slam) {
  if (writer_) writer_->Finish(slam);
}

void RunSession::Improve(const Slam& slam, const Trajectory& trajectory,
                         const std::vector<int>& frames, const EstimatedSensor& found,
                         const SurfelMap& map) {
  if (!writer_) return;
  std::map<int, Rigid3d> world_from_camera;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    world_from_camera[frames[i]] = trajectory[i].world_from_camera;
  }
  const SessionContent tracked = ContentOf(slam);
  std::vector<PosedFrame> moved = tracked.frames;
  MoveFrames(world_from_camera, &moved);
  std::vector<StoredEdge> edges = tracked.edges;
  MoveEdges(PosesOfKeyframes(tracked.frames, tracked.keyframes),
            PosesOfKeyframes(moved, tracked.keyframes), &edges);
  writer_->Replace({moved, tracked.keyframes, std::move(edges), tracked.settled_keyframes,
                    tracked.is_calibrating, found.calibration, found.color_latency_s,
                    WithoutStereo(map), tracked.map_corrections});
}

}  // namespace surfit
