#include "loop_closure/correct_frames.h"

namespace surfit {
namespace {

Rigid3d Between(const Rigid3d& from, const Rigid3d& to, double share,
                const Eigen::Vector3d& point) {
  const Eigen::Quaterniond rotation = from.rotation.slerp(share, to.rotation);
  const Eigen::Vector3d moved = (1 - share) * (from * point) + share * (to * point);
  return {rotation.normalized(), moved - rotation.normalized() * point};
}

class KeyframeCorrections {
 public:
  KeyframeCorrections(const std::vector<PosedFrame>& frames,
                      const std::vector<int>& frame_of_keyframe,
                      const std::vector<Rigid3d>& new_from_old_of_keyframe)
      : frames_(frames),
        frame_of_keyframe_(frame_of_keyframe),
        of_keyframe_(new_from_old_of_keyframe) {}

  Rigid3d Of(const PosedFrame& frame) const {
    const auto last = static_cast<std::size_t>(frame.keyframe);
    const std::size_t next = last + 1;
    if (next >= of_keyframe_.size()) return of_keyframe_[last];
    const PosedFrame& begin = frames_[frame_of_keyframe_[last]];
    const PosedFrame& end = frames_[frame_of_keyframe_[next]];
    if (end.segment != frame.segment) return of_keyframe_[last];
    const double share = static_cast<double>(frame.index - begin.index) / (end.index - begin.index);
    return Between(of_keyframe_[last], of_keyframe_[next], share,
                   frame.world_from_camera.translation);
  }

 private:
  const std::vector<PosedFrame>& frames_;
  const std::vector<int>& frame_of_keyframe_;
  const std::vector<Rigid3d>& of_keyframe_;
};

// Values for all frame indices from the first to the last frame. An index without a frame has the
// value of the previous frame.
template <typename ValueOf>
std::vector<Rigid3d> OfIndices(const std::vector<PosedFrame>& frames, const ValueOf& value_of) {
  std::vector<Rigid3d> of_index;
  for (const PosedFrame& frame : frames) {
    const std::size_t before = frame.index - frames.front().index;
    if (of_index.size() < before) of_index.resize(before, of_index.back());
    of_index.push_back(value_of(frame));
  }
  return of_index;
}

}  // namespace

FrameCorrections CorrectionsOfFrames(const std::vector<PosedFrame>& frames,
                                     const std::vector<int>& frame_of_keyframe,
                                     const std::vector<Rigid3d>& new_from_old_of_keyframe) {
  const KeyframeCorrections of_keyframes(frames, frame_of_keyframe, new_from_old_of_keyframe);
  return {frames.front().index,
          OfIndices(frames, [&](const PosedFrame& frame) { return of_keyframes.Of(frame); })};
}

std::vector<Rigid3d> PosesOfIndices(const std::vector<PosedFrame>& frames) {
  return OfIndices(frames, [](const PosedFrame& frame) { return frame.world_from_camera; });
}

}  // namespace surfit
