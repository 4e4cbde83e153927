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

// Session of a run: the run saves it, continues it, or localises the camera in it.
class RunSession {
 public:
  // Opens the session, and enables loop closure in the options. Keeps a reference to the options.
  // If a continued session already has frames of this sequence, `sequence.first` is set to the next
  // frame. Throws InputError like ReadSession() and SessionWriter. Also throws if the session
  // already has all frames of the sequence, and for localisation without frames.
  explicit RunSession(SlamRunOptions* options);

  // Converts the frame index from the sequence to the session.
  void Shift(ReadResult* result) const;
  int first_index() const { return first_index_; }  // session index of the run's first frame
  bool is_localized() const { return options_.localize; }
  // False for a new session.
  bool has_state() const { return state_.has_value(); }

  // Creates a Slam that continues from the session. Requires has_state(). Call it once, as it moves
  // the state. Throws InputError if the session was recorded by another sensor.
  std::unique_ptr<Slam> MakeSlam(const SequenceInfo& info);
  // Starts saving. Call it before `slam` processes the first frame. The functions that save do
  // nothing for localisation.
  void Begin(const SequenceInfo& info, Slam* slam);
  // Saves periodically. Call it after each frame.
  void Offer(const Slam& slam, double stamp_s);
  // Saves after the last frame.
  void Finish(const Slam& slam);
  // Replaces poses, calibration and map after Finish(). `frames` are the session indices of the
  // poses. The residuals of the pose graph do not change.
  void Improve(const Slam& slam, const Trajectory& trajectory, const std::vector<int>& frames,
               const EstimatedSensor& found, const SurfelMap& map);
  // Number of saves that were due before the previous save was written.
  std::int64_t waits() const { return writer_ ? writer_->waits() : 0; }

 private:
  void ContinueAfter(const std::vector<SessionRun>& runs, SequenceOptions* sequence);

  const SlamRunOptions& options_;
  std::unique_ptr<SessionWriter> writer_;  // null for localisation
  std::optional<SlamState> state_;
  DepthSensor sensor_;          // input sensor of the session
  bool is_contiguous_ = false;  // the run starts directly after the session's last frame
  int first_index_ = 0, shift_ = 0;
};

}  // namespace surfit
