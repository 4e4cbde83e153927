#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/preprocess.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

// Parses "tx,ty,tz,qx,qy,qz,qw" (translation in m, non-zero quaternion). Throws InputError with the
// option and the text. Normalises the quaternion.
Rigid3d ParsePose(const std::string& option, const std::string& text);

// world_from_camera of the first frame: "identity", "groundtruth" (pose at the timestamp) or a pose
// as in ParsePose(), in the convention of the sequence. Throws InputError for other texts, or
// without ground truth at the timestamp.
Rigid3d InitialPose(const std::string& initial_pose, const SequenceInfo& info,
                    double first_stamp_s);

// Reads a trajectory (TUM format) in the convention of the sequence. Mirrors it if the sequence is
// mirrored. Throws InputError with the path.
Trajectory ReadEstimate(const std::string& path, const SequenceInfo& info);

// Mirrors the trajectory if the sequence is mirrored.
Trajectory InConvention(Trajectory trajectory, const SequenceInfo& info);

// Frame with its ground-truth pose.
struct PosedView {
  ColoredView view;
  std::optional<Rigid3d> world_from_camera;  // std::nullopt: no ground truth at its time
};

// Reads frame `index` without intensities, regardless of `first`, `last` and `stride`. Throws
// InputError if the frame does not exist or is unreadable.
PosedView ReadPosedView(const SequenceOptions& options, int index,
                        const PreprocessOptions& preprocess);

struct PosedPair {
  PosedView source, target;

  // Ground-truth relative pose; std::nullopt if a pose is unknown.
  std::optional<Rigid3d> TargetFromSource() const;
};

// Reads two frames, with intensities if the error model needs them. Throws like ReadPosedView().
// Intensities need colour images.
PosedPair ReadPosedPair(const SequenceOptions& options, int source, int target,
                        const PreprocessOptions& preprocess, const ErrorModel& error_model);

// Median point-to-plane distance |n . (p' - q)| of projective correspondences, m. std::nullopt
// without correspondences within the default gates. p': source vertex in the target frame, q and n:
// target vertex and normal.
std::optional<double> MedianSurfaceDistance(const FrameLevel& source, const FrameLevel& target,
                                            const Rigid3d& target_from_source);

// Ground truth from the first to the last timestamp, with a margin for interpolation. `stamps_s`
// must not be empty. Timestamps are in ascending order.
Trajectory TruthDuring(const std::vector<double>& stamps_s, const Trajectory& ground_truth);

}  // namespace surfit
