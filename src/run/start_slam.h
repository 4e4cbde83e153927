#pragma once

#include <memory>

#include "run/run_session.h"
#include "surfit/frame/frame_source.h"
#include "surfit/run/slam_run.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Creates the Slam of a run. It continues from the session if the session has a state. Otherwise it
// starts at InitialPose(). If options.dump_failures is set, it writes a dump of each lost frame.
// `session` may be null. `options` and `session` must outlive the result. Throws InputError for bad
// options, or for a session of another sensor.
std::unique_ptr<Slam> StartSlam(const SlamRunOptions& options, const SequenceInfo& info,
                                RunSession* session, double first_stamp_s);

}  // namespace surfit
