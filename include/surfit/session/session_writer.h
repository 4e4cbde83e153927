#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "surfit/session/session.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Keeps a session on disk while SLAM runs. Saves are written on a thread of their own; what they
// hold does not depend on how fast that is.
class SessionWriter {
 public:
  // Locks the folder, which is made if it is missing, for as long as the object lives. Throws
  // InputError naming it if another program writes into it, or if it holds a session already that
  // is not to be gone on with.
  enum class Mode { kNew, kContinue };
  SessionWriter(const std::string& folder, Mode mode);
  ~SessionWriter();
  SessionWriter& operator=(SessionWriter&&) = delete;

  // Opens or makes the session. To be called once, before the first of the frames of the last of
  // these runs, with the Slam that they go through. Throws InputError if the session is one of
  // another sensor, or damaged.
  void Begin(const std::vector<SessionRun>& new_runs, const DepthSensor& sensor, Slam* slam);
  // Adds the views of a state that the Slam has taken up and the session does not have.
  void KeepViews(const std::vector<KeyframeLink>& keyframes, const std::vector<PlaceView>& views);

  // To be called after each frame. Saves where half a second of the recording, or 15 frames, have
  // come since the last save; waits for that if it is still being written. So at most a second is
  // not on disk. Throws InputError if the former save could not be written.
  void Offer(const Slam& slam, double stamp_s);

  // Saves what there is, and flushes it to the disk.
  void Finish(const Slam& slam);

  std::int64_t waits() const;  // saves that were due before the former was written

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace surfit
