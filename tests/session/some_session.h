#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "session/session_writer.h"
#include "slam/simulated_sequence.h"
#include "surfit/session/session.h"

namespace surfit::testing {

inline SlamOptions SessionSlamOptions() {
  SlamOptions options;
  options.loops.enabled = true;
  return options;
}

inline SessionRun SomeRun() {
  SessionRun run;
  run.sequence = "/recordings/room";
  run.format = "tum";
  return run;
}

// Writes a session of the first frames of a room. Returns the Slam with the same state.
inline std::unique_ptr<Slam> KeepSession(const SimulatedSequence& sequence, int frames,
                                         const std::string& folder) {
  const DepthSensor sensor = {sequence.camera, {}};
  auto slam = std::make_unique<Slam>(sensor, SessionSlamOptions(), sequence.world_from_camera[0]);
  SessionWriter writer(folder, SessionWriter::Mode::kNew);
  writer.Begin({SomeRun()}, sensor, slam.get());
  for (int i = 0; i < frames; ++i) {
    slam->Process(sequence.frames[i]);
    writer.SaveIfDue(*slam, sequence.frames[i].stamp_s);
  }
  slam->Finish();
  writer.Finish(*slam);
  return slam;
}

}  // namespace surfit::testing
