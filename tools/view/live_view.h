#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>

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

// A run in a window, with keys: space pauses and goes on, s does one frame, n changes between the
// model's normals and colours, q ends the run as Ctrl-C does. Closing the window leaves the run
// alone.
class LiveView {
 public:
  // Says on stderr why, and gives none, where no window can be opened. To be called before there
  // are threads. `interrupted` ends a pause.
  static std::unique_ptr<LiveView> Open(const std::atomic<bool>& interrupted);

  // To be called after each frame. Returns only when the next one is to be done.
  void Update(const SlamRunProgress& progress);

 private:
  explicit LiveView(const std::atomic<bool>& interrupted);
  void Close();
  void Note(const SlamRunFrame& frame);
  void Draw(const SlamRunProgress& progress, bool must);
  void DrawFrame(const SlamRunProgress& progress);
  void Press(int key);
  bool MayGoOn() const { return !paused_ || step_ || interrupted_; }

  using Clock = std::chrono::steady_clock;
  const std::atomic<bool>& interrupted_;
  std::unique_ptr<Window> window_;        // none once it is closed
  std::unique_ptr<LivePicture> picture_;  // from the first frame on
  Trajectory path_;
  ModelColors colors_ = ModelColors::kNormals;
  bool paused_ = false;
  bool step_ = false;
  double frame_s_ = 0;  // lately, without the time spent here
  Clock::time_point left_ = Clock::now();
  Pace frame_pace_{0.05}, map_pace_{0.5};
};

}  // namespace surfit::tools
