// Where OpenCV was built without highgui.

#include "view/window.h"

namespace surfit::tools {

std::string Window::WhyNone() { return "this program was built without OpenCV's highgui"; }
Window::Window(const std::string& title) : name_(title) {}
Window::~Window() = default;
bool Window::IsOpen() const { return false; }
void Window::Show(const Image<Rgb8>&) {}
void Window::SetTitle(const std::string&) {}
int Window::Key(int) { return kNoKey; }

}  // namespace surfit::tools
