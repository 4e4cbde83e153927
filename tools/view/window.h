#pragma once

#include <functional>
#include <string>

#include "surfit/core/image.h"

namespace surfit::tools {

struct MouseEvent;

// A window on the screen, by the library surfit_window, which is loaded here. One at a time.
class Window {
 public:
  static constexpr int kNoKey = -1;

  // Why no window can be opened; empty where one can. Toolkits end the process when they find no
  // display, so a child process tries. To be called before there are threads.
  static std::string WhyNone();

  // The title that it has at first is also its name here: no two at a time have the same.
  explicit Window(const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // False once the user has closed it; it stays closed.
  bool IsOpen() const;
  void Show(const Image<Rgb8>& image);
  // Changes what the screen calls the window.
  void SetTitle(const std::string& title);
  // Called, while Key() waits, with what the mouse does.
  // Wheels are the toolkit's: it enlarges the picture.
  struct Mouse {
    int u = 0, v = 0;                   // the pixel
    int right_px = 0, down_px = 0;      // moved since the last call
    bool turns = false;                 // the left button is held
    bool moves = false, zooms = false;  // the right one, or with shift; the middle one, or control
  };
  void OnMouse(std::function<void(const Mouse&)> call);
  // The key that was pressed, waiting for it at least 1 and about wait_ms at most; kNoKey if none.
  int Key(int wait_ms);

 private:
  static void Handle(const MouseEvent& event, void* window);

  std::string name_;
  std::function<void(const Mouse&)> on_mouse_;
  int last_u_ = 0, last_v_ = 0;
};

}  // namespace surfit::tools
