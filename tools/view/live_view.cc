#include "view/live_view.h"

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <map>
#include <string>

#include "surfit/core/error.h"
#include "surfit/slam/backend.h"

namespace surfit::tools {
namespace {

std::string Status(const SlamRunProgress& progress, double fps) {
  std::string total;
  if (progress.frames_total >= 0) total = "/" + std::to_string(progress.frames_total);
  std::array<char, 160> text;
  std::snprintf(text.data(), text.size(), "frame %d%s   %s   %.1f fps   %.2f M surfels",
                progress.frames_done, total.c_str(), ToString(progress.frame->report.state).c_str(),
                fps, static_cast<double>(progress.map_points) * 1e-6);
  return text.data();
}

// While the result is made there are no new frames.
std::string StatusOfResult(const SlamRunProgress& progress) {
  if (progress.frames_fused_anew > 0) {
    return Concat("the map is fused anew: ", progress.frames_fused_anew, "/", progress.frames_done);
  }
  return Concat("poses and camera are refined: round ", progress.refinement_rounds);
}

const char* const kTitle = "Surfit";
const char* const kPausedTitle = "Surfit (paused)";
const char* const kDoneTitle = "Surfit (done)";
const char* const kKeys =
    "space: pause   s: one frame   n: normals   f: follow   + -: zoom   drag: turn, move   r: all  "
    " "
    "q: end";
constexpr int kBriefly = 1, kWhileWaiting = 30;  // ms

}  // namespace

std::unique_ptr<LiveView> LiveView::Open(const std::atomic<bool>& interrupted) {
  const std::string why_none = Window::WhyNone();
  if (why_none.empty()) return std::unique_ptr<LiveView>(new LiveView(interrupted));
  std::fprintf(stderr, "warning: no live view: %s; the run goes on without\n", why_none.c_str());
  return nullptr;
}

LiveView::LiveView(const std::atomic<bool>& interrupted)
    : interrupted_(interrupted), window_(std::make_unique<Window>(kTitle)) {
  window_->OnMouse([this](const Window::Mouse& mouse) { Move(mouse); });
}

void LiveView::Update(const SlamRunProgress& progress) {
  if (!window_) return;
  if (!progress.frame) {
    if (!picture_) return;
    status_ = StatusOfResult(progress);
    picture_->ShowText(status_, kKeys);
    window_->Show(picture_->image());
    return Wait(kBriefly);
  }
  const SlamRunFrame& frame = *progress.frame;
  Note(frame);
  step_ = false;
  status_ = Status(progress, 1 / frame_s_);
  Show(frame.map, &frame, /*must=*/paused_);
  do {
    Wait(MayGoOn() ? kBriefly : kWhileWaiting);
    if (!window_) return;
    Show(frame.map, &frame, /*must=*/false);
  } while (!MayGoOn());
  left_ = Clock::now();
}

void LiveView::Keep(const SlamRunResult& result) {
  if (!window_ || !picture_) return;
  final_map_ = result.map;
  path_ = result.trajectory;
}

void LiveView::Stay() {
  if (!window_ || !final_map_ || interrupted_) return;
  std::fprintf(stderr, "the live view stays open: q in its window ends it\n");
  window_->SetTitle(kDoneTitle);
  status_ = "done";
  if (!last_good_.empty()) picture_->ShowFrame({0, 0, 0, {}, last_good_});  // of the last pose
  paused_ = is_lost_ = false;
  Show(*final_map_, nullptr, /*must=*/true);
  while (window_ && !ends_ && !interrupted_) {
    Wait(kWhileWaiting);
    if (window_) Show(*final_map_, nullptr, /*must=*/false);
  }
}

// For a key, and whatever the mouse does meanwhile.
void LiveView::Wait(int wait_ms) {
  const int key = window_->Key(wait_ms);
  if (!window_->IsOpen()) return Close();
  if (key != Window::kNoKey) Press(key);
}

void LiveView::Close() {
  if (!final_map_) std::fprintf(stderr, "\nthe live view is closed; the run goes on\n");
  window_.reset();
}

void LiveView::Note(const SlamRunFrame& frame) {
  constexpr double kNew = 0.1;  // the share of the last frame in the mean
  const double seconds = std::chrono::duration<double>(Clock::now() - left_).count();
  frame_s_ = frame_s_ == 0 ? seconds : frame_s_ + kNew * (seconds - frame_s_);
  if (!picture_) picture_ = std::make_unique<LivePicture>(frame.sensor);
  if (frame.backend) NoteLoops(*frame.backend);
  is_lost_ = frame.report.state == FrameState::kLost;
  if (is_lost_) return;
  last_good_ = frame.frame.color;
  if (frame.backend) {
    path_ = frame.backend->trajectory();  // as loops have corrected it
  } else {
    path_.push_back({frame.report.stamp_s, frame.report.world_from_camera});
  }
}

void LiveView::NoteLoops(const Backend& backend) {
  std::map<int, Eigen::Vector3d> places;
  loops_.clear();
  for (const LoopRecord& loop : backend.loops()) {
    if (!loop.in_graph) continue;
    if (places.empty()) {
      for (const PosedFrame& frame : backend.frames()) {
        places[frame.index] = frame.world_from_camera.translation;
      }
    }
    loops_.push_back({places.at(loop.source_frame), places.at(loop.target_frame)});
    loop_text_ = Concat("   ", loops_.size(), " loops, last of frames ", loop.source_frame, " and ",
                        loop.target_frame);
  }
}

// Without a frame what the run has come to. While the map is turned it is drawn coarsely, and
// finely again when that is over.
void LiveView::Show(const SurfelMap& map, const SlamRunFrame* frame, bool must) {
  const bool has_time = final_map_ || !MayGoOn();
  const bool refines = is_coarse_ && !is_turned_ && has_time;
  must = must || is_pressed_;
  is_pressed_ = false;
  map_pace_.DrawIfDue(must || is_turned_ || refines, [&] {
    is_coarse_ = is_turned_;
    is_turned_ = false;
    picture_->ShowMap(map, path_, loops_, is_coarse_);
    window_->Show(picture_->image());
  });
  frame_pace_.DrawIfDue(must, [&] { ShowFrame(map, frame); });
}

void LiveView::ShowFrame(const SurfelMap& map, const SlamRunFrame* frame) {
  if (frame) picture_->ShowFrame(frame->frame);
  if (is_lost_) {
    picture_->ShowLost(last_good_);
  } else if (!path_.empty()) {
    picture_->ShowModel(map, path_.back().world_from_camera, colors_);
  }
  picture_->ShowText((paused_ ? "paused   " : "") + status_ + loop_text_, kKeys);
  window_->Show(picture_->image());
}

void LiveView::Move(const Window::Mouse& mouse) {
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
bool LiveView::Orbit(int key) {
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

void LiveView::Press(int key) {
  constexpr int kEscape = 27;
  if (Orbit(key)) return;
  switch (key) {
    case ' ':
      paused_ = !paused_ && !final_map_;
      break;
    case 's':
      paused_ = step_ = !final_map_;
      break;
    case 'n':
      colors_ = colors_ == ModelColors::kNormals ? ModelColors::kColor : ModelColors::kNormals;
      break;
    case 'q':
    case kEscape:
      ends_ = true;
      if (!final_map_) std::raise(SIGINT);
      break;
    default:
      return;
  }
  if (!final_map_) window_->SetTitle(paused_ ? kPausedTitle : kTitle);
  is_pressed_ = true;
}

}  // namespace surfit::tools
