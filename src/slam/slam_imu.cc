// The inertial sensor of Slam: smoothed poses, and poses of lost frames.
#include <utility>
#include <vector>

#include "surfit/core/error.h"
#include "surfit/slam/backend.h"
#include "surfit/slam/slam.h"
#include "tracking/tracker.h"

namespace surfit {

void Slam::UseImu(ImuRecording recording) {
  ThrowIf(frame_count_ != 0, "an inertial sensor must be set before the first frame");
  tracker_->UseImu(std::move(recording));
}

ImuReport Slam::imu_report() const { return tracker_->imu_report(); }

void Slam::NoteLost(const RgbdFrame& frame) {
  if (tracker_->imu()) lost_.emplace_back(frame.index, frame.stamp_s);
}

// Poses of frame-to-frame tracking drift, so they do not hold the place in a map.
void Slam::SmoothByImu() {
  if (!tracker_->imu() || options_.IsFrameToFrame()) return;
  const std::vector<PosedFrame>& posed = keeper()->poses().frames();
  std::vector<ImuTracking::FramePose> frames;
  std::vector<std::size_t> posed_at;
  auto lost = lost_.begin();
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const PosedFrame& frame = posed[i];
    const bool is_bridge = i > 0 && frame.segment == posed[i - 1].segment &&
                           frame.stamp_s - posed[i - 1].stamp_s <= kMaxImuBridge_s;
    for (; lost != lost_.end() && lost->first <= frame.index; ++lost) {
      if (!is_bridge || lost->first == frame.index || lost->first <= posed[i - 1].index) continue;
      const Trajectory ends = {{posed[i - 1].stamp_s, posed[i - 1].world_from_camera},
                               {frame.stamp_s, frame.world_from_camera}};
      const auto pose = InterpolatePose(ends, lost->second, kMaxImuBridge_s);
      if (pose) frames.push_back({lost->first, lost->second, *pose, frame.segment});
    }
    posed_at.push_back(frames.size());
    frames.push_back({frame.index, frame.stamp_s, frame.world_from_camera, frame.segment});
  }
  const auto poses = tracker_->imu()->Smooth(frames);
  if (!poses) return;
  std::vector<Rigid3d> moved;
  moved.reserve(posed_at.size());
  for (std::size_t k = 0; k < posed_at.size(); ++k) {
    const std::size_t at = posed_at[k];
    moved.push_back((*poses)[at]);
    const std::size_t next = k + 1 < posed_at.size() ? posed_at[k + 1] : at + 1;
    for (std::size_t i = at + 1; i < next; ++i) {
      bridged_.push_back({frames[i].frame, frames[i].stamp_s, frames[at].frame,
                          (*poses)[at].Inverse() * (*poses)[i]});
    }
  }
  Apply(keeper()->MoveFrames(moved), posed.back().index);
}

}  // namespace surfit
