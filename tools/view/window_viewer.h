#pragma once

#include <memory>
#include <optional>
#include <string>

#include "surfit/live/live_run.h"
#include "surfit/pictures/pictures.h"
#include "view/window.h"

namespace surfit::tools {

// A run in a window. With the mouse the map is turned (left button), moved (right button, or with
// shift) and brought nearer (middle button, or with control). Keys: space pauses and goes on, s
// does one frame, n changes between the model's colours and normals, f follows the camera, + and -
// zoom, a and d turn, w and x tilt, r shows all of the map again, q ends the run as Ctrl-C does.
// Closing the window leaves the run alone.
class WindowViewer : public RunViewer {
 public:
  // Says on stderr why, and gives none, where no window can be opened. To be called before there
  // are threads. The run outlives it.
  static std::unique_ptr<WindowViewer> Open(LiveRun* run);

  void Show(const SlamRunFrame& frame) override;
  void Wait(const SlamRunFrame& frame, int wait_ms) override;
  void ShowWork() override;
  void Keep(const SlamRunResult& result) override;
  // Until the window is closed, or q is pressed. Not where the run was interrupted.
  void Stay() override;

 private:
  explicit WindowViewer(LiveRun* run);
  void Close();
  void LookForInput(int wait_ms);
  void Draw(const SurfelMap& map, const SlamRunFrame* frame, bool must);
  void DrawFrame(const SurfelMap& map, const SlamRunFrame* frame);
  std::string LoopText() const;
  void Move(const Window::Mouse& mouse);
  void Press(int key);
  bool Orbit(int key);

  LiveRun& run_;
  std::unique_ptr<Window> window_;        // none once it is closed
  std::unique_ptr<LivePicture> picture_;  // from the first frame on
  std::optional<SurfelMap> final_map_;
  ModelColors colors_ = ModelColors::kColor;
  bool ends_ = false;        // Stay(), as q was pressed
  bool is_pressed_ = false;  // a key, since it was drawn
  bool is_turned_ = false;   // the map, since it was drawn
  bool is_coarse_ = false;   // as the map is drawn
  Pace frame_pace_{0.05, 0.1}, map_pace_{0.5, 0.1};
};

}  // namespace surfit::tools
