#pragma once

#include <string>

#include "surfit/core/image.h"

namespace surfit::tools {

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
  // The key that was pressed, waiting for it at least 1 and about wait_ms at most; kNoKey if none.
  int Key(int wait_ms);

 private:
  std::string name_;
};

}  // namespace surfit::tools
