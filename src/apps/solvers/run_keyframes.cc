#include "apps/solvers/run_keyframes.h"

#include <algorithm>
#include <optional>

#include "core/repeated_warning.h"
#include "finishing/posed_sequence.h"
#include "run/posed_views.h"
#include "surfit/core/error.h"

namespace surfit {

RunKeyframes ReadRunKeyframes(const RefineRunOptions& options) {
  constexpr double kKeyframeRotation_rad = 0.15;
  const auto source = ReopenSequence(options.sequence);
  RunKeyframes run;
  run.info = source->info();
  run.trajectory = ReadEstimate(options.trajectory, run.info);
  const std::vector<std::size_t> chosen = ChooseKeyframes(
      run.trajectory, options.keyframe_translation_m, kKeyframeRotation_rad, options.max_keyframes);
  RepeatedWarning skipped("frames skipped");
  while (const std::optional<ReadResult> read = source->Next()) {
    run.stamps_s.push_back(read->stamp_s);
    const std::optional<std::size_t> pose = PoseAt(run.trajectory, read->stamp_s);
    if (pose) {
      run.frame_poses.push_back(*pose);
      run.frames.push_back(read->index);
    } else {
      ++run.frames_without_pose;
    }
    if (!read->frame) {
      skipped.Tell(Concat("frame ", read->index, " skipped: ", read->error));
      ++run.frames_unreadable;
    }
    if (!pose || !read->frame || !std::binary_search(chosen.begin(), chosen.end(), *pose)) {
      continue;
    }
    run.poses.push_back(*pose);
    run.keyframes.push_back(
        {run.trajectory[*pose].world_from_camera,
         MakeKeyframeImages(*read->frame, run.info.sensor(),
                            MotionAt(run.trajectory, read->frame->stamp_s), options.preprocess)});
  }
  if (run.keyframes.empty()) {
    throw InputError(
        Concat(options.trajectory, " has no pose at a frame timestamp of ", options.sequence.path));
  }
  return run;
}

}  // namespace surfit
