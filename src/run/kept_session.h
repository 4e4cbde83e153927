#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "finishing/known_sequence.h"
#include "session/session_writer.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/run/slam_run.h"
#include "surfit/session/session.h"

namespace surfit {

// The session that a run keeps, goes on in, or is localised in.
class KeptSession {
 public:
  // Opens it as the options say, and has the sequence begin after the last frame that the session
  // has of it. Throws InputError as ReadSession() and SessionWriter do.
  explicit KeptSession(SlamRunOptions* options);

  // Makes a frame's index one of the session.
  void Shift(ReadResult* result) const;
  int first_index() const { return first_index_; }  // of the run's first frame
  bool is_localized() const { return options_.localize; }
  // Whether there is something to go on from.
  bool has_state() const { return state_.has_value(); }

  // A Slam that goes on from the session. Once.
  std::unique_ptr<Slam> MakeSlam(const SequenceInfo& info);
  // The frames that come next go through this Slam.
  void Begin(const SequenceInfo& info, Slam* slam);
  void Offer(const Slam& slam, double stamp_s);
  void Finish(const Slam& slam);
  // Replaces poses, sensor and map after Finish(). `frames` are the frame indices of the poses. The
  // residuals of the pose graph stay the same.
  void Improve(const Slam& slam, const Trajectory& trajectory, const std::vector<int>& frames,
               const FoundSensor& found, const SurfelMap& map);
  std::int64_t waits() const { return writer_ ? writer_->waits() : 0; }

 private:
  void GoOnAfter(const std::vector<SessionRun>& runs, SequenceOptions* sequence);

  const SlamRunOptions& options_;
  std::unique_ptr<SessionWriter> writer_;  // null where the camera is only localised
  std::optional<SlamState> state_;
  DepthSensor sensor_;    // as given
  bool goes_on_ = false;  // the sequence follows the session's last frame
  int first_index_ = 0, shift_ = 0;
};

}  // namespace surfit
