#pragma once

namespace surfit::tools {

// What the mouse does: the pixel, whether it has moved there, and what is held meanwhile.
struct MouseEvent {
  int u = 0, v = 0;
  bool is_move = false;
  bool left = false, middle = false, right = false;  // buttons
  bool shift = false, control = false;
};

// What the library surfit_window can do. A run loads it when it is to be watched: it brings a
// toolkit of many libraries, of which other runs know nothing. Windows are told apart by name.
struct WindowCalls {
  void (*open)(const char* name);  // without a display it throws, or the toolkit ends the process
  void (*close)(const char* name);
  bool (*is_open)(const char* name);
  void (*show)(const char* name, const unsigned char* rgb, int width, int height);
  void (*set_title)(const char* name, const char* title);
  // call(event, user) is called within key().
  void (*on_mouse)(const char* name, void (*call)(const MouseEvent& event, void* user), void* user);
  int (*key)(int wait_ms);  // the key's character, or -1
};

// By this name it is looked for in the library.
inline constexpr char kWindowCallsName[] = "SurfitWindowCalls";
extern "C" const WindowCalls* SurfitWindowCalls();

}  // namespace surfit::tools
