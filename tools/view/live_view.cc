#include "view/live_view.h"

#include <array>
#include <csignal>
#include <cstdio>
#include <string>

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

const char* const kTitle = "Surfit";
const char* const kPausedTitle = "Surfit (paused)";

}  // namespace

std::unique_ptr<LiveView> LiveView::Open(const std::atomic<bool>& interrupted) {
  const std::string why_none = Window::WhyNone();
  if (why_none.empty()) return std::unique_ptr<LiveView>(new LiveView(interrupted));
  std::fprintf(stderr, "warning: no live view: %s; the run goes on without\n", why_none.c_str());
  return nullptr;
}

LiveView::LiveView(const std::atomic<bool>& interrupted)
    : interrupted_(interrupted), window_(std::make_unique<Window>(kTitle)) {}

void LiveView::Update(const SlamRunProgress& progress) {
  if (!window_ || !progress.frame) return;
  Note(*progress.frame);
  step_ = false;
  Draw(progress, /*must=*/paused_);
  constexpr int kBriefly = 1, kWhilePaused = 30;  // ms
  do {
    const int key = window_->Key(MayGoOn() ? kBriefly : kWhilePaused);
    if (!window_->IsOpen()) return Close();
    if (key == Window::kNoKey) continue;
    Press(key);
    window_->SetTitle(paused_ ? kPausedTitle : kTitle);
    Draw(progress, /*must=*/true);
  } while (!MayGoOn());
  left_ = Clock::now();
}

void LiveView::Close() {
  std::fprintf(stderr, "\nthe live view is closed; the run goes on\n");
  window_.reset();
}

void LiveView::Note(const SlamRunFrame& frame) {
  constexpr double kNew = 0.1;  // the share of the last frame in the mean
  const double seconds = std::chrono::duration<double>(Clock::now() - left_).count();
  frame_s_ = frame_s_ == 0 ? seconds : frame_s_ + kNew * (seconds - frame_s_);
  if (!picture_) picture_ = std::make_unique<LivePicture>(frame.sensor);
  if (frame.report.state == FrameState::kLost) return;
  path_.push_back({frame.report.stamp_s, frame.report.world_from_camera});
}

void LiveView::Draw(const SlamRunProgress& progress, bool must) {
  map_pace_.DrawIfDue(must, [&] { picture_->ShowMap(progress.frame->map, path_); });
  frame_pace_.DrawIfDue(must, [&] { DrawFrame(progress); });
}

void LiveView::DrawFrame(const SlamRunProgress& progress) {
  picture_->ShowFrame(progress.frame->frame);
  // Of a lost frame nobody knows where it would see the model from: the last pose's view stays.
  if (!path_.empty()) {
    picture_->ShowModel(progress.frame->map, path_.back().world_from_camera, colors_);
  }
  picture_->ShowText(
      Status(progress, 1 / frame_s_),
      std::string(paused_ ? "paused   " : "") +
          "space: pause / go on   s: one frame   n: normals / colour   q: end the run");
  window_->Show(picture_->image());
}

void LiveView::Press(int key) {
  constexpr int kEscape = 27;
  switch (key) {
    case ' ':
      paused_ = !paused_;
      break;
    case 's':
      paused_ = step_ = true;
      break;
    case 'n':
      colors_ = colors_ == ModelColors::kNormals ? ModelColors::kColor : ModelColors::kNormals;
      break;
    case 'q':
    case kEscape:
      std::raise(SIGINT);
      break;
    default:
      break;
  }
}

}  // namespace surfit::tools
