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

// What a session holds, except views and calibration frames. The references must outlive the call
// that takes it.
struct SessionContent {
  const std::vector<PosedFrame>& frames;
  const std::vector<KeyframeLink>& keyframes;
  std::vector<KeptEdge> edges;
  std::size_t settled_keyframes = 0;
  bool is_calibrating = false;                  // Backend::is_calibrating()
  std::optional<DepthCalibration> calibration;  // none: as given
  double color_latency_s = 0;
  const SurfelMap& map;
  int map_corrections = 0;  // Slam::corrections_of_map()
};

// The content of a Slam with loops enabled.
SessionContent ContentOf(const Slam& slam);

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
  void Finish(const Slam& slam) { Finish(ContentOf(slam)); }

  // Replaces map, poses and edges after Finish(), and flushes them to the disk. Frames and
  // keyframes must be those of the last save.
  void Replace(const SessionContent& content);

  std::int64_t waits() const { return waits_; }  // saves due before the former was written

 private:
  // A keyframe whose view is still to be made, or made by now.
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

  // As they were saved last; nothing of what another process has saved.
  std::vector<PosedFrame> frames_;
  std::vector<KeptEdge> edges_;
  std::size_t keyframes_ = 0;
  ChangedTiles changed_tiles_;
  bool has_saved_ = false;
  std::vector<UnsavedView> new_views_;
  std::vector<SessionRun> runs_;  // that are new
  std::int64_t first_run_ = 0;    // the key of the first of them
  bool are_runs_saved_ = false;

  int frames_since_save_ = 0;
  double saved_stamp_s_ = 0;
  std::int64_t waits_ = 0;

  // Of the writing thread, while it is at work.
  std::map<std::int64_t, TileRow> tiles_;
  std::vector<std::string> superseded_, removable_;  // files of tiles
  std::int64_t views_ = 0, calibration_frames_ = 0, saves_ = 0;
  std::future<void> writing_;
};

}  // namespace surfit
