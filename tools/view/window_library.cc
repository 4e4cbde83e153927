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

int Key(int wait_ms) { return cv::waitKey(wait_ms); }

}  // namespace

const WindowCalls* SurfitWindowCalls() {
  static constexpr WindowCalls kCalls = {Open, Close, IsOpen, Show, SetTitle, Key};
  return &kCalls;
}

}  // namespace surfit::tools
