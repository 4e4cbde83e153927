#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "surfit/pictures/pictures.h"
#include "surfit/run/slam_run.h"
#include "view/window.h"

namespace surfit::tools {

// When it is time to draw again: not more often than every min_gap_s, and so seldom that drawing
// takes no more than about a tenth of the time.
class Pace {
 public:
  explicit Pace(double min_gap_s) : min_gap_(min_gap_s) {}

  // Calls draw() if it is time, or if it must be.
  template <typename Draw>
  void DrawIfDue(bool must, const Draw& draw) {
    const Clock::time_point begin = Clock::now();
    if (!must && begin < next_) return;
    draw();
    const Clock::time_point end = Clock::now();
    constexpr int kGapPerDrawing = 9;
    next_ = end + std::max(std::chrono::duration_cast<Clock::duration>(min_gap_),
                           kGapPerDrawing * (end - begin));
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::chrono::duration<double> min_gap_;
  Clock::time_point next_;
};

// A run in a window. With the mouse the map is turned (left button), moved (right button, or with
// shift) and brought nearer (middle button, or with control). Keys: space pauses and goes on, s
// does one frame, n changes between the model's colours and normals, f follows the camera, + and -
// zoom, a and d turn, w and x tilt, r shows all of the map again, q ends the run as Ctrl-C does.
// Closing the window leaves the run alone.
class LiveView {
 public:
  // Says on stderr why, and gives none, where no window can be opened. To be called before there
  // are threads. `interrupted` ends a pause.
  static std::unique_ptr<LiveView> Open(const std::atomic<bool>& interrupted);

  // To be called after each frame, and while the result is made. Returns only when the run is to go
  // on.
  void Update(const SlamRunProgress& progress);
  // Keeps what the run has come to, for Stay().
  void Keep(const SlamRunResult& result);
  // Shows it until the window is closed, or q is pressed. Not where the run was interrupted.
  void Stay();

 private:
  explicit LiveView(const std::atomic<bool>& interrupted);
  void Close();
  void Note(const SlamRunFrame& frame);
  void NoteLoops(const Backend& backend);
  void Wait(int wait_ms);
  void Show(const SurfelMap& map, const SlamRunFrame* frame, bool must);
  void ShowFrame(const SurfelMap& map, const SlamRunFrame* frame);
  void Move(const Window::Mouse& mouse);
  void Press(int key);
  bool Orbit(int key);
  bool MayGoOn() const { return !paused_ || step_ || interrupted_; }

  using Clock = std::chrono::steady_clock;
  const std::atomic<bool>& interrupted_;
  std::unique_ptr<Window> window_;        // none once it is closed
  std::unique_ptr<LivePicture> picture_;  // from the first frame on
  Trajectory path_;
  std::vector<LoopSegment> loops_;
  std::string loop_text_;  // of those that have been closed
  Image<Rgb8> last_good_;  // the last image whose pose is known
  bool is_lost_ = false;
  std::optional<SurfelMap> final_map_;
  std::string status_;
  ModelColors colors_ = ModelColors::kColor;
  bool paused_ = false;
  bool step_ = false;
  bool ends_ = false;        // Stay(), as q was pressed
  bool is_pressed_ = false;  // a key, since it was drawn
  bool is_turned_ = false;   // the map, since it was drawn
  bool is_coarse_ = false;   // as the map is drawn
  double frame_s_ = 0;       // lately, without the time spent here
  Clock::time_point left_ = Clock::now();
  Pace frame_pace_{0.05}, map_pace_{0.5};
};

}  // namespace surfit::tools
