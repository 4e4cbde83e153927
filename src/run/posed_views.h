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
#include "surfit/registration/far_registration.h"

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

// The part of the ground truth from the first to the last stamp, with a margin for interpolation.
Trajectory TruthDuring(const std::vector<double>& stamps_s, const Trajectory& ground_truth);

}  // namespace surfit
