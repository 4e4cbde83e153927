#pragma once

#include <memory>

#include "run/kept_session.h"
#include "surfit/frame/frame_source.h"
#include "surfit/run/slam_run.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Makes the Slam of a run. It continues from the session if that has a state; else the first camera
// pose is that of the options, at the time of the first frame. With options.dump_failures it writes
// a dump of each lost frame. `session` may be null. Options and session must outlive the result.
// Throws InputError for bad options, or a session of another sensor.
std::unique_ptr<Slam> StartSlam(const SlamRunOptions& options, const SequenceInfo& info,
                                KeptSession* session, double first_stamp_s);

}  // namespace surfit
