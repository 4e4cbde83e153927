#include "run/results/evaluate_run.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>

namespace surfit {
namespace {

// Piece of each frame in the trajectory.
std::vector<int> PieceOfFrame(const std::vector<int>& frames, const PoseStore* poses) {
  std::vector<int> pieces(frames.size(), 0);
  if (!poses) return pieces;
  const std::vector<int> piece_of_keyframe = poses->PieceOfKeyframe();
  std::map<int, int> piece_of_frame;
  for (const PosedFrame& frame : poses->frames()) {
    piece_of_frame[frame.index] = piece_of_keyframe[frame.keyframe];
  }
  // A lost frame with a pose is in the piece of the frame before it.
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto next = piece_of_frame.upper_bound(frames[i]);
    if (next != piece_of_frame.begin()) pieces[i] = std::prev(next)->second;
  }
  return pieces;
}

// The ground truth has no pose at the time of a frame.
void WarnOfTruthTimes(const std::vector<double>& stamps_s, const Trajectory& truth) {
  if (stamps_s.empty()) return;
  const auto [first, last] = std::minmax_element(stamps_s.begin(), stamps_s.end());
  LOG(WARNING) << "no frame has ground truth: the timestamps of the frames are from "
               << std::to_string(*first) << " to " << std::to_string(*last)
               << " s and those of the ground truth from " << std::to_string(truth.front().stamp_s)
               << " to " << std::to_string(truth.back().stamp_s) << " s";
}

}  // namespace

TrajectoryPieces SplitIntoPieces(const RunTrajectory& trajectory, const PoseStore* poses,
                                 const Trajectory& truth, const std::vector<double>& stamps_s) {
  const std::vector<int>& frames = trajectory.frames();
  const std::vector<int> piece_of_frame = PieceOfFrame(frames, poses);
  std::map<int, std::pair<TrajectoryPiece, Trajectory>> by_number;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto& [piece, piece_poses] = by_number[piece_of_frame[i]];
    if (piece_poses.empty()) piece.first_frame = frames[i];
    piece.last_frame = frames[i];
    ++piece.frames;
    piece_poses.push_back(trajectory.poses()[i]);
  }
  TrajectoryPieces pieces;
  int most = 0;
  for (auto& [number, piece] : by_number) {
    if (!truth.empty()) {
      piece.first.evaluation = EvaluateTrajectory(truth, piece.second, stamps_s, {});
    }
    pieces.all.push_back(piece.first);
    if (piece.first.frames > most) {
      most = piece.first.frames;
      pieces.largest = std::move(piece.second);
    }
  }
  return pieces;
}

std::vector<std::size_t> GapsOf(const RunTrajectory& trajectory, const PoseStore* poses,
                                const std::set<int>& lost) {
  constexpr int kMaxLostFrames = 10;
  const std::vector<int>& frames = trajectory.frames();
  const std::vector<int> pieces = PieceOfFrame(frames, poses);
  std::vector<std::size_t> gaps;
  for (std::size_t p = 0; p + 1 < frames.size(); ++p) {
    const auto between =
        std::distance(lost.upper_bound(frames[p]), lost.lower_bound(frames[p + 1]));
    if (between > 0 && between <= kMaxLostFrames && pieces[p] == pieces[p + 1]) gaps.push_back(p);
  }
  return gaps;
}

void AddBridgedFrames(const std::vector<Slam::BridgedFrame>& bridged,
                      const RunTrajectory& trajectory, std::vector<PoseBetween>* found) {
  std::set<int> known;
  for (const PoseBetween& pose : *found) known.insert(pose.frame);
  const std::vector<int>& frames = trajectory.frames();
  for (const Slam::BridgedFrame& frame : bridged) {
    const auto before = std::lower_bound(frames.begin(), frames.end(), frame.before);
    if (known.count(frame.index) > 0 || before == frames.end() || *before != frame.before) continue;
    const auto position = static_cast<std::size_t>(before - frames.begin());
    found->push_back({frame.index, frame.stamp_s,
                      trajectory.poses()[position].world_from_camera * frame.before_from_camera,
                      position});
  }
  std::sort(found->begin(), found->end(),
            [](const PoseBetween& a, const PoseBetween& b) { return a.frame < b.frame; });
}

void EvaluateRun(const Trajectory& estimate, const Trajectory& truth,
                 const std::vector<double>& stamps_s, const SlamRunOptions& options,
                 SlamRunSummary* summary) {
  summary->evaluation = EvaluateTrajectory(truth, estimate, stamps_s, {});
  const bool is_own_file = !options.groundtruth.empty();  // OpenSequence() checks other files
  if (is_own_file && summary->evaluation->expected == 0) WarnOfTruthTimes(stamps_s, truth);
  const auto without = EvaluateTimeOffset(truth, estimate, summary->sensor_latency_s, {});
  if (without) summary->ate_without_latency = without->ate;
  summary->time_offset = EstimateTimeOffset(truth, estimate, {});
  if (options.fit_mount) summary->mount = FitMount(MatchPoses(truth, estimate, {}), false);
}

}  // namespace surfit
