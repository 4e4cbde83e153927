#include "view/window.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <opencv2/highgui.hpp>
#include <opencv2/imgproc.hpp>

namespace surfit::tools {
namespace {

// In the child: exits with 0 if a window can be opened, and does not return.
[[noreturn]] void TryToOpen() {
  constexpr int kPatienceSeconds = 10;  // a display elsewhere may never answer
  alarm(kPatienceSeconds);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);  // the toolkit's own complaint, of many lines
  try {
    // Not to be taken for the window that is looked for by its name.
    cv::namedWindow("is there a display?", cv::WINDOW_AUTOSIZE | cv::WINDOW_GUI_NORMAL);
  } catch (...) {
    _exit(1);
  }
  _exit(0);
}

}  // namespace

std::string Window::WhyNone() {
  const pid_t child = fork();
  if (child == 0) TryToOpen();
  int status = -1;
  if (child > 0) waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  const char* const display = std::getenv("DISPLAY");
  if (display == nullptr) return "there is no display (DISPLAY is not set)";
  return std::string("no window can be opened on the display '") + display + "'";
}

Window::Window(const std::string& title) : name_(title) {
  cv::namedWindow(name_, cv::WINDOW_AUTOSIZE | cv::WINDOW_GUI_NORMAL);
}

Window::~Window() {
  if (IsOpen()) cv::destroyWindow(name_);
}

bool Window::IsOpen() const { return cv::getWindowProperty(name_, cv::WND_PROP_VISIBLE) >= 1; }

void Window::Show(const Image<Rgb8>& image) {
  const cv::Mat rgb(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  cv::imshow(name_, bgr);
}

void Window::SetTitle(const std::string& title) { cv::setWindowTitle(name_, title); }

int Window::Key(int wait_ms) { return cv::waitKey(wait_ms); }

}  // namespace surfit::tools
