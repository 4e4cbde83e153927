#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "finishing/posed_sequence.h"
#include "session/session_writer.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/run/slam_run.h"
#include "surfit/session/session.h"

namespace surfit {

// Session of a run: saved, continued, or used for localisation. Order: MakeSlam() or a new Slam,
// then Begin(), Shift() and SaveIfDue() per frame, Finish(), Improve(). Not thread-safe.
class RunSession {
 public:
  // Opens the session, and enables loop closure in the options. Keeps a reference to the options.
  // Sets `options->sequence.first` to skip the frames that a continued session already has. If the
  // session to continue does not exist, creates it with a warning. Throws InputError like
  // ReadSession() and SessionWriter. Also throws if no frame remains, and for localisation in an
  // empty session.
  explicit RunSession(SlamRunOptions* options);

  // Converts frame indices of the sequence to indices of the session.
  void Shift(ReadResult* result) const;
  // Session index of the first frame of this run; 0 for a new session.
  int first_index() const { return first_index_; }
  bool is_localized() const { return options_.localize; }
  // Returns whether the session has frames. Call before MakeSlam().
  bool has_state() const { return state_.has_value(); }

  // Creates a Slam that continues from the session. Requires has_state(). Call once, because the
  // state is moved. Throws InputError for a session of another sensor.
  std::unique_ptr<Slam> MakeSlam(const SequenceInfo& info, const SlamOptions& options);
  // Starts saving. Call before the first frame. Saving functions do nothing in localisation.
  void Begin(const SequenceInfo& info, Slam* slam);
  // Call after each frame. Saves periodically.
  void SaveIfDue(const Slam& slam, double stamp_s);
  // Saves the final state. Requires Begin().
  void Finish(const Slam& slam);
  // Replaces poses, calibration and map after Finish(). `frames`: session index of each pose.
  // Residuals of the pose graph do not change. Frames without an entry move with the frame before
  // them.
  void Improve(const Slam& slam, const Trajectory& trajectory, const std::vector<int>& frames,
               const EstimatedSensor& found, const SurfelMap& map);
  // Number of saves that waited for the previous save.
  std::int64_t waits() const { return writer_ ? writer_->waits() : 0; }

 private:
  void ContinueAfter(const std::vector<SessionRun>& runs, SequenceOptions* sequence);

  const SlamRunOptions& options_;
  std::unique_ptr<SessionWriter> writer_;  // null for localisation
  std::optional<SlamState> state_;
  DepthSensor sensor_;
  bool is_contiguous_ = false;  // the run follows the last frame of the session directly
  int first_index_ = 0, shift_ = 0;
};

}  // namespace surfit
