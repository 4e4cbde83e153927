#include "view/window_viewer.h"

#include <cmath>
#include <cstdio>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

const char* const kTitle = "Surfit";
const char* const kPausedTitle = "Surfit (paused)";
const char* const kDoneTitle = "Surfit (done)";
const char* const kKeys =
    "space: pause   s: one frame   n: normals   f: follow   + -: zoom   drag: turn, move   r: all  "
    " "
    "q: end";
constexpr int kBriefly = 1, kWhileWaiting = 30;  // ms

}  // namespace

std::unique_ptr<WindowViewer> WindowViewer::Open(LiveRun* run) {
  const std::string why_none = Window::WhyNone();
  if (why_none.empty()) return std::unique_ptr<WindowViewer>(new WindowViewer(run));
  std::fprintf(stderr, "warning: no live view: %s; the run goes on without\n", why_none.c_str());
  return nullptr;
}

WindowViewer::WindowViewer(LiveRun* run) : run_(*run), window_(std::make_unique<Window>(kTitle)) {
  window_->OnMouse([this](const Window::Mouse& mouse) { Move(mouse); });
}

void WindowViewer::Show(const SlamRunFrame& frame) {
  if (!window_) return;
  if (!picture_) picture_ = std::make_unique<LivePicture>(frame.sensor);
  Draw(frame.map, &frame, /*must=*/run_.is_paused());
  LookForInput(kBriefly);
  if (window_) Draw(frame.map, &frame, /*must=*/false);
}

void WindowViewer::Wait(const SlamRunFrame& frame, int wait_ms) {
  if (!window_) return;
  LookForInput(wait_ms);
  if (window_) Draw(frame.map, &frame, /*must=*/false);
}

void WindowViewer::ShowWork() {
  if (!window_ || !picture_) return;
  picture_->ShowText(run_.Status(), kKeys);
  window_->Show(picture_->image());
  LookForInput(kBriefly);
}

void WindowViewer::Keep(const SlamRunResult& result) {
  if (window_ && picture_) final_map_ = result.map;
}

void WindowViewer::Stay() {
  if (!window_ || !final_map_ || run_.is_interrupted()) return;
  std::fprintf(stderr, "the live view stays open: q in its window ends it\n");
  window_->SetTitle(kDoneTitle);
  const Image<Rgb8>& last_good = run_.last_good();
  if (!last_good.empty()) picture_->ShowFrame({0, 0, 0, {}, last_good});  // of the last pose
  Draw(*final_map_, nullptr, /*must=*/true);
  while (window_ && !ends_ && !run_.is_interrupted()) {
    LookForInput(kWhileWaiting);
    if (window_) Draw(*final_map_, nullptr, /*must=*/false);
  }
}

// For a key, and whatever the mouse does meanwhile.
void WindowViewer::LookForInput(int wait_ms) {
  const int key = window_->Key(wait_ms);
  if (!window_->IsOpen()) return Close();
  if (key != Window::kNoKey) Press(key);
}

// Who has closed it cannot end a pause.
void WindowViewer::Close() {
  if (!final_map_) std::fprintf(stderr, "\nthe live view is closed; the run goes on\n");
  window_.reset();
  run_.GoOn();
}

std::string WindowViewer::LoopText() const {
  if (!run_.last_loop()) return "";
  return Concat("   ", run_.loops().size(), " loops, last of frames ", run_.last_loop()->first,
                " and ", run_.last_loop()->second);
}

// Without a frame what the run has come to. While the map is turned it is drawn coarsely, and
// finely again when that is over.
void WindowViewer::Draw(const SurfelMap& map, const SlamRunFrame* frame, bool must) {
  const bool has_time = final_map_ || !run_.MayGoOn();
  const bool refines = is_coarse_ && !is_turned_ && has_time;
  must = must || is_pressed_;
  is_pressed_ = false;
  map_pace_.ActIfDue(must || is_turned_ || refines, [&] {
    is_coarse_ = is_turned_;
    is_turned_ = false;
    picture_->ShowMap(map, run_.path(), run_.loops(), is_coarse_);
    window_->Show(picture_->image());
  });
  frame_pace_.ActIfDue(must, [&] { DrawFrame(map, frame); });
}

void WindowViewer::DrawFrame(const SurfelMap& map, const SlamRunFrame* frame) {
  if (frame) picture_->ShowFrame(frame->frame);
  if (frame && run_.is_lost()) {
    picture_->ShowLost(run_.last_good());
  } else if (!run_.path().empty()) {
    picture_->ShowModel(map, run_.path().back().world_from_camera, colors_);
  }
  picture_->ShowText((run_.is_paused() ? "paused   " : "") + run_.Status() + LoopText(), kKeys);
  window_->Show(picture_->image());
}

void WindowViewer::Move(const Window::Mouse& mouse) {
  if (!picture_ || !LivePicture::IsInMap(mouse.u, mouse.v)) return;
  if (!mouse.turns && !mouse.moves && !mouse.zooms) return;
  constexpr double kRadPerPixel = 0.008, kZoomPerPixel = 0.01;
  is_turned_ = true;
  if (mouse.moves) return picture_->DragMap(mouse.right_px, mouse.down_px);
  MapOrbit orbit = picture_->orbit();
  if (mouse.zooms) {
    orbit.distance *= std::exp(kZoomPerPixel * mouse.down_px);
  } else {
    orbit.right_rad -= kRadPerPixel * mouse.right_px;
    orbit.up_rad += kRadPerPixel * mouse.down_px;
  }
  picture_->SetOrbit(orbit);
}

// Whether the key is one of those that turn the map.
bool WindowViewer::Orbit(int key) {
  constexpr double kStep_rad = 0.15, kPerStep = 0.85;
  if (!picture_) return false;
  MapOrbit orbit = picture_->orbit();
  switch (key) {
    case 'a':
      orbit.right_rad -= kStep_rad;
      break;
    case 'd':
      orbit.right_rad += kStep_rad;
      break;
    case 'w':
      orbit.up_rad += kStep_rad;
      break;
    case 'x':
      orbit.up_rad -= kStep_rad;
      break;
    case '+':
    case '=':
      orbit.distance *= kPerStep;
      break;
    case '-':
      orbit.distance /= kPerStep;
      break;
    case 'f':
      orbit.follows = !orbit.follows;
      orbit.shift_m.setZero();
      break;
    case 'r':
      orbit = MapOrbit();
      break;
    default:
      return false;
  }
  picture_->SetOrbit(orbit);
  is_turned_ = true;
  return true;
}

void WindowViewer::Press(int key) {
  constexpr int kEscape = 27;
  if (Orbit(key)) return;
  switch (key) {
    case ' ':
      run_.is_paused() ? run_.GoOn() : run_.Pause();
      break;
    case 's':
      run_.Step();
      break;
    case 'n':
      colors_ = colors_ == ModelColors::kNormals ? ModelColors::kColor : ModelColors::kNormals;
      break;
    case 'q':
    case kEscape:
      ends_ = true;
      if (!final_map_) run_.Stop();
      break;
    default:
      return;
  }
  if (!final_map_) window_->SetTitle(run_.is_paused() ? kPausedTitle : kTitle);
  is_pressed_ = true;
}

}  // namespace surfit::tools
