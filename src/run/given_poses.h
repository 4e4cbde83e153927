#pragma once

#include <optional>
#include <string>

#include "surfit/geometry/trajectory.h"
#include "surfit/io/frame_source.h"

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

}  // namespace surfit
