#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "run/run_session.h"
#include "surfit/frame/frame_source.h"
#include "surfit/run/slam_run.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Opens the sequence of a run: a live source, or a recording that is read ahead or offered at a
// frame rate. `interrupted` must outlive the source. Throws InputError like OpenSequence() and
// OpenLive().
std::unique_ptr<FrameSource> OpenSource(const SlamRunOptions& options,
                                        const std::atomic<bool>& interrupted);

// Replaces the ground truth by the file of the options, or by the poses of the device. Throws
// InputError if the options need ground truth and there is none.
SequenceInfo WithGroundTruth(SequenceInfo info, const SlamRunOptions& options);

// Sets the photometric weight for the depth of phones, unless options have one, or exclude it
// (weakly_constrained_photometric_weight of 0, solver svd). Phones interpolate few measurements by
// the colour image. The errors of neighbouring pixels are correlated, so depth has less information
// than its number of pixels, and colour has more details. Depth with a measured noise below 0.0003
// 1/m is exact, so colour gets no weight. `has_color`: the first frame has colour.
void WeighColor(const SequenceInfo& info, const NoiseReport& noise, bool has_color,
                SlamOptions* options);

// Switches the calibration off for phones, unless the camera file has a prior. A phone calibrates
// itself, and smooth interpolated depth looks like a wrong calibration.
void KeepCalibrationOfPhones(const SequenceInfo& info, SlamOptions* options);

// Creates the Slam of a run. It continues from the session if that has a state, else it starts at
// InitialPose(). `options.dump_failures` enables dumps of lost frames. `session` may be null.
// `options` and `session` must outlive the result. Throws InputError for invalid options, for a
// session of another sensor, and for an inertial sensor or prior poses that cannot be read. Also
// starts saving (RunSession::Begin()). `first_stamp_s`: timestamp of the first frame. An inertial
// sensor needs timestamps of a clock.
std::unique_ptr<Slam> StartSlam(const SlamRunOptions& options, const SequenceInfo& info,
                                RunSession* session, double first_stamp_s);

// Warns about frames without a prior pose, and about rejected prior poses. `path`: file of the
// prior poses.
void WarnOfPriorPoses(const std::string& path, const PriorPoseSummary& prior);

}  // namespace surfit
