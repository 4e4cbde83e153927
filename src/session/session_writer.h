#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/files/output_folder.h"
#include "session/changed_tiles.h"
#include "session/schema.h"
#include "surfit/session/session.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Content of a session except views and calibration frames. References must be valid during the
// call.
struct SessionContent {
  const std::vector<PosedFrame>& frames;
  const std::vector<KeyframeLink>& keyframes;
  std::vector<StoredEdge> edges;
  std::size_t settled_keyframes = 0;
  bool is_calibrating = false;                  // Backend::is_calibrating()
  std::optional<DepthCalibration> calibration;  // std::nullopt: input calibration
  double color_latency_s = 0;                   // beyond the input latency
  const SurfelMap& map;
  int map_corrections = 0;  // Slam::corrections_of_map()
};

// Content of a Slam with loop closure. Requires Slam::backend(). The result refers to `slam`, and
// is valid until the next frame.
SessionContent ContentOf(const Slam& slam);

// Saves a session during SLAM, in a background thread. The content does not depend on the writing
// speed. Not thread-safe: call all functions from one thread. Order: Begin(), then KeepViews() if
// needed, SaveIfDue() per frame, Finish(), and at last Replace(). The destructor waits for the
// running save and logs its error.
class SessionWriter {
 public:
  // Creates the folder if missing, and locks it until destruction. Throws InputError with the path
  // if another program has locked it, or if mode is kNew and the folder has a session.
  enum class Mode { kNew, kContinue };
  SessionWriter(const std::string& folder, Mode mode);
  ~SessionWriter();
  SessionWriter& operator=(SessionWriter&&) = delete;

  // Opens or creates the session. Call before the first frame of the last of `new_runs`. Sets a
  // keyframe callback of `slam`, so this object must outlive `slam` or its last frame. Throws
  // InputError if the session is damaged or has another sensor.
  void Begin(const std::vector<SessionRun>& new_runs, const DepthSensor& sensor, Slam* slam);
  // Adds views from another session that this session does not have. `views[k]` belongs to
  // `keyframes[k]`, an empty view is skipped. Keyframes are in ascending order of frames.
  void KeepViews(const std::vector<KeyframeLink>& keyframes, const std::vector<PlaceView>& views);

  // Call after each frame. Saves after 0.5 s of recording time or 15 frames. Waits for the previous
  // save, so at most 1 s of the recording is unsaved. Throws InputError if the previous save
  // failed. Does nothing before the first frame with a pose.
  void SaveIfDue(const Slam& slam, double stamp_s);

  // Saves the final state, and syncs it to the disk. Marks the new runs as ended. Waits for the
  // disk, and throws InputError if a save fails.
  void Finish(const Slam& slam) { Finish(ContentOf(slam)); }

  // Replaces map, poses and edges after Finish(), and syncs them to the disk. Requires the frames
  // and keyframes of the last save.
  void Replace(const SessionContent& content);

  // Number of saves that waited for the previous save.
  std::int64_t waits() const { return waits_; }

 private:
  struct UnsavedView {
    int frame = 0;
    ViewOfKeyframe view;
    std::shared_ptr<const RgbdFrame> calibration_frame;
  };
  struct Update;

  void Open(const DepthSensor& sensor);
  void Finish(const SessionContent& content);
  void Save(const SessionContent& content);
  Update Difference(const SessionContent& content);
  void Wait();
  void Write(Update update);
  void WriteTiles(const Update& update);

  const std::string folder_;
  OutputFolder lock_;
  std::unique_ptr<Database> database_;
  SessionRow facts_;

  // State of the last save of this process.
  std::vector<PosedFrame> frames_;
  std::vector<StoredEdge> edges_;
  std::size_t keyframes_ = 0;
  ChangedTiles changed_tiles_;
  bool has_saved_ = false;
  std::vector<UnsavedView> new_views_;
  std::vector<SessionRun> runs_;  // new runs
  std::int64_t first_run_ = 0;
  bool are_runs_saved_ = false;

  int frames_since_save_ = 0;
  double saved_stamp_s_ = 0;
  std::int64_t waits_ = 0;

  // Used by the writing thread while writing_ is valid.
  std::map<std::int64_t, TileRow> tiles_;
  std::vector<std::string> superseded_, removable_;  // tile files
  std::int64_t views_ = 0, calibration_frames_ = 0, saves_ = 0;
  std::future<void> writing_;
};

}  // namespace surfit
