// The library surfit_window: windows by OpenCV's highgui.
#include <opencv2/highgui.hpp>
#include <opencv2/imgproc.hpp>

#include "view/window_calls.h"

namespace surfit::tools {
namespace {

void Open(const char* name) { cv::namedWindow(name, cv::WINDOW_AUTOSIZE | cv::WINDOW_GUI_NORMAL); }

void Close(const char* name) { cv::destroyWindow(name); }

bool IsOpen(const char* name) { return cv::getWindowProperty(name, cv::WND_PROP_VISIBLE) >= 1; }

void Show(const char* name, const unsigned char* rgb, int width, int height) {
  const cv::Mat image(height, width, CV_8UC3, const_cast<unsigned char*>(rgb));
  cv::Mat bgr;
  cv::cvtColor(image, bgr, cv::COLOR_RGB2BGR);
  cv::imshow(name, bgr);
}

void SetTitle(const char* name, const char* title) { cv::setWindowTitle(name, title); }

// The one window's.
void (*mouse_call)(const MouseEvent&, void*) = nullptr;

void HandleMouse(int event, int u, int v, int flags, void* user) {
  const auto has = [&](int flag) { return (flags & flag) != 0; };
  MouseEvent mouse;
  mouse.u = u;
  mouse.v = v;
  mouse.is_move = event == cv::EVENT_MOUSEMOVE;
  mouse.left = has(cv::EVENT_FLAG_LBUTTON);
  mouse.middle = has(cv::EVENT_FLAG_MBUTTON);
  mouse.right = has(cv::EVENT_FLAG_RBUTTON);
  mouse.shift = has(cv::EVENT_FLAG_SHIFTKEY);
  mouse.control = has(cv::EVENT_FLAG_CTRLKEY);
  mouse_call(mouse, user);
}

void OnMouse(const char* name, void (*call)(const MouseEvent&, void*), void* user) {
  mouse_call = call;
  cv::setMouseCallback(name, HandleMouse, user);
}

int Key(int wait_ms) { return cv::waitKey(wait_ms); }

}  // namespace

const WindowCalls* SurfitWindowCalls() {
  static constexpr WindowCalls kCalls = {Open, Close, IsOpen, Show, SetTitle, OnMouse, Key};
  return &kCalls;
}

}  // namespace surfit::tools
