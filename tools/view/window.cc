#include "view/window.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "view/window_calls.h"

namespace surfit::tools {
namespace {

// Beside the program, as it is built, or where it is installed.
const WindowCalls* Load() {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* const file : {"surfit_window.so", SURFIT_WINDOW_FROM_PROGRAM}) {
    void* const library = dlopen((folder / file).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) continue;
    void* const calls = dlsym(library, kWindowCallsName);
    if (calls != nullptr) return reinterpret_cast<const WindowCalls* (*)()>(calls)();
  }
  return nullptr;
}

// Null where the library is not there.
const WindowCalls* Calls() {
  static const WindowCalls* const calls = Load();
  return calls;
}

// In the child: exits with 0 if a window can be opened, and does not return.
[[noreturn]] void TryToOpen() {
  constexpr int kPatienceSeconds = 10;  // a display elsewhere may never answer
  alarm(kPatienceSeconds);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);  // the toolkit's own complaint, of many lines
  try {
    // Not to be taken for the window that is looked for by its name.
    Calls()->open("is there a display?");
  } catch (...) {
    _exit(1);
  }
  _exit(0);
}

}  // namespace

std::string Window::WhyNone() {
  if (Calls() == nullptr) {
    const char* const reason = dlerror();
    return std::string("the library surfit_window cannot be loaded: ") +
           (reason != nullptr ? reason : "it is another's");
  }
  const pid_t child = fork();
  if (child == 0) TryToOpen();
  int status = -1;
  if (child > 0) waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  const char* const display = std::getenv("DISPLAY");
  if (display == nullptr) return "there is no display (DISPLAY is not set)";
  return std::string("no window can be opened on the display '") + display + "'";
}

Window::Window(const std::string& title) : name_(title) { Calls()->open(name_.c_str()); }

Window::~Window() {
  if (IsOpen()) Calls()->close(name_.c_str());
}

bool Window::IsOpen() const { return Calls()->is_open(name_.c_str()); }

void Window::Show(const Image<Rgb8>& image) {
  static_assert(sizeof(Rgb8) == 3, "images are shared with the library");
  Calls()->show(name_.c_str(), &image.data()->r, image.width(), image.height());
}

void Window::SetTitle(const std::string& title) {
  Calls()->set_title(name_.c_str(), title.c_str());
}

void Window::OnMouse(std::function<void(const Mouse&)> call) {
  on_mouse_ = std::move(call);
  Calls()->on_mouse(name_.c_str(), Handle, this);
}

void Window::Handle(const MouseEvent& event, void* window) {
  Window& self = *static_cast<Window*>(window);
  Mouse mouse;
  mouse.u = event.u;
  mouse.v = event.v;
  mouse.right_px = event.u - std::exchange(self.last_u_, event.u);
  mouse.down_px = event.v - std::exchange(self.last_v_, event.v);
  if (event.is_move) {
    mouse.moves = event.right || (event.left && event.shift);
    mouse.zooms = event.middle || (event.left && event.control);
    mouse.turns = event.left && !mouse.moves && !mouse.zooms;
  }
  self.on_mouse_(mouse);
}

int Window::Key(int wait_ms) { return Calls()->key(wait_ms); }

}  // namespace surfit::tools
