#pragma once

#include <optional>
#include <string>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/frame_source.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/far_registration.h"
#include "surfit/run/refine_run.h"

namespace surfit {

// Reads "tx,ty,tz,qx,qy,qz,qw" (metres, quaternion of any length but zero).
// Throws InputError naming the option and the text.
Rigid3d ParsePose(const std::string& option, const std::string& text);

// The pose that a run begins at: "identity", "groundtruth" (the true pose at that time) or numbers,
// these in the source's convention. Throws InputError naming the constraint that fails.
Rigid3d InitialPose(const std::string& initial_pose, const SequenceInfo& info,
                    double first_stamp_s);

// An estimated trajectory of the sequence, from a file (TUM format) in the source's convention.
// Throws InputError naming the file.
Trajectory ReadEstimate(const std::string& path, const SequenceInfo& info);

// One frame of a sequence, ready to be registered.
struct PosedView {
  ColoredView view;
  std::optional<Rigid3d> world_from_camera;  // true pose
};

// The frame with this index; the options' first, last and stride are not used. Throws InputError
// where there is none or it cannot be read.
PosedView ReadPosedView(const SequenceOptions& options, int index,
                        const PreprocessOptions& preprocess);

// Two frames to be registered.
struct PosedPair {
  PosedView source, target;

  // The true pose, where it is known.
  std::optional<Rigid3d> TargetFromSource() const;
};

// With intensities where the error model uses them. Throws like ReadPosedView().
PosedPair ReadPosedPair(const SequenceOptions& options, int source, int target,
                        const PreprocessOptions& preprocess, const ErrorModel& error_model);

// The median of |n . (p' - q)| over projected pixels, in metres. Nothing if there is no pair of
// points within the default gates.
std::optional<double> MedianSurfaceDistance(const FrameLevel& source, const FrameLevel& target,
                                            const Rigid3d& target_from_source);

// The keyframes of a run, as refinement needs them.
struct RunKeyframes {
  SequenceInfo info;
  Trajectory trajectory;           // of the run, in the convention of the sequence's frames
  std::vector<double> stamps_s;    // of all frames
  std::vector<std::size_t> poses;  // of the trajectory: the keyframes'
  std::vector<RefinementKeyframe> keyframes;
  int frames_without_pose = 0, frames_unreadable = 0;  // of those read
  std::vector<std::size_t> frame_poses;                // of the trajectory: those with a frame,
  std::vector<int> frames;                             // and their frames' indices
};

// Reads them. Throws InputError for files that cannot be read, or a trajectory of other frames.
RunKeyframes ReadRunKeyframes(const RefineRunOptions& options);

}  // namespace surfit
