#include "apps/live/live_server.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "apps/live/http_rules.h"
#include "apps/live/http_server.h"
#include "apps/live/live_data.h"
#include "apps/live/live_pages.h"
#include "output/pictures/pictures.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kSlotsAtOnce = 8192;
constexpr std::size_t kMaxSurfels = 131072;  // maximum number of surfels on the page
constexpr std::array kViews = {Shown::kFrame, Shown::kModel, Shown::kNormals};

// Subsampled path with its last pose, and the last kMaxLoops loop closures.
LivePath Thinned(const LiveRun& run) {
  constexpr std::size_t kMaxPlaces = 2000, kMaxLoops = 1000;
  LivePath thin;
  const Trajectory& path = run.path();
  const std::size_t step = path.size() / kMaxPlaces + 1;
  for (std::size_t i = 0; i < path.size(); i += step) {
    thin.positions.emplace_back(path[i].world_from_camera.translation.cast<float>());
  }
  if (!path.empty()) {
    thin.positions.emplace_back(path.back().world_from_camera.translation.cast<float>());
  }
  const std::vector<LoopSegment>& loops = run.loops();
  const std::size_t count = std::min(kMaxLoops, loops.size());
  thin.loops.assign(loops.end() - static_cast<std::ptrdiff_t>(count), loops.end());
  return thin;
}

std::string HostOf(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

// Port, or address and port, as in a URL. An IPv6 address is in brackets.
class ListenText final : public OptionText {
 public:
  explicit ListenText(ServeOptions* options) : options_(options) {}
  std::string Get() const override {
    if (options_->port < 0) return "";
    const bool is_default = options_->address == ServeOptions().address;
    return is_default ? std::to_string(options_->port)
                      : Concat(HostOf(options_->address), ":", options_->port);
  }
  void Set(const std::string& text) override {
    *options_ = {-1, ServeOptions().address};
    if (text.empty()) return;
    const std::size_t colon = text.rfind(':');
    const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
    const bool is_port = !port.empty() && port.size() <= 5 &&
                         port.find_first_not_of("0123456789") == std::string::npos &&
                         std::stoi(port) <= 65535;
    ThrowIf(!is_port || colon == 0, "[ADDRESS:]PORT with a port from 0 to 65535");
    options_->port = std::stoi(port);
    if (colon == std::string::npos) return;
    options_->address = text.substr(0, colon);
    if (options_->address.front() == '[' && options_->address.back() == ']') {
      options_->address = options_->address.substr(1, options_->address.size() - 2);
    }
  }
  const std::type_info& type() const override { return typeid(ListenText); }
  void* field() override { return options_; }

 private:
  ServeOptions* options_;
};

}  // namespace

void ServeOptions::Visit(OptionVisitor& v) {
  ListenText listen(this);
  v.AddText(listen,
            Option("listen",
                   "[ADDRESS:]PORT of the live web page, whose address is printed on stderr; port "
                   "0: any free port; address 127.0.0.1: this machine only (default), 0.0.0.0: all "
                   "network interfaces; empty: no web page",
                   AsFlag("serve"), Everyday()));
  v.Check([this] {
    ThrowIf(port < -1 || port > 65535, "port is ", port, ", must be from -1 to 65535");
    ThrowIf(address.empty(), "address is missing, must be set");
  });
}

struct LiveServer::Parts {
  Parts(const ServeOptions& options, LiveRun* of_run)
      : run(*of_run),
        shown(kMaxSurfels),
        token(RandomToken()),
        pages(token, of_run, &shown),
        server(
            options.address, options.port, HttpLimits(),
            [this](const HttpRequest& request, bool must) { return pages.Answer(request, must); }) {
  }

  template <typename Act>
  void Give(Shown what, RateLimiter* pace, bool must, const Act& act);
  void UpdateState(bool must);
  void GiveStateIfDue(bool must);
  Image<Rgb8> ModelPicture(const SurfelMap& map, ModelColors colors);
  bool GiveViews(const RgbdFrame& frame, const SurfelMap& map, const std::vector<Shown>& wanted,
                 bool must);
  void GiveViewsIfDue(const SlamRunFrame& frame, bool must);
  void GiveAll(const SlamRunFrame& frame, bool must);

  LiveRun& run;
  LiveData shown;
  std::string token;
  LivePages pages;
  std::optional<LivePictures> pictures;  // empty before the first frame
  PinholeCamera camera;
  // Limits of update intervals, s, and of the ratio of run time. The ratios sum to 4 %.
  RateLimiter state_pace{0.1, 0.005}, path_pace{1, 0.003}, views_pace{0.1, 0.024},
      map_pace{0, 0.008};
  std::array<bool, kShownCount> is_exact{};  // true: the shown data belong to the last frame
  bool is_state_exact = false;
  int map_rounds = 0;  // complete map updates since the last frame
  std::optional<Clock::time_point> last_turn;
  HttpServer server;  // last member: it uses the members above
};

// Updates requested data if an update is due. During a pause (`must`), the data are updated once.
template <typename Act>
void LiveServer::Parts::Give(Shown what, RateLimiter* pace, bool must, const Act& act) {
  bool& exact = is_exact[static_cast<std::size_t>(what)];
  if (exact || !shown.IsRequested(what)) return;
  pace->ActIfDue(must, [&] { exact = act() && must; });
  if (exact) server.Wake();
}

// Updates the state even without requests, so that new clients get it at once.
void LiveServer::Parts::GiveStateIfDue(bool must) {
  const bool is_new = must && !std::exchange(is_state_exact, true);
  state_pace.ActIfDue(is_new, [&] { UpdateState(is_new); });
}

void LiveServer::Parts::UpdateState(bool must) {
  ShownState state;
  state.status = run.Status();
  state.frame_state = run.state();
  state.progress = run.progress();
  state.frames_per_second = run.frames_per_second();
  state.is_at_result = run.is_at_result();
  state.is_done = run.is_done();
  state.advice = run.advice();
  state.loops = run.loops().size();
  state.last_loop = run.last_loop();
  if (!run.path().empty()) state.world_from_camera = run.path().back().world_from_camera;
  state.camera = camera;
  shown.UpdateState(state, must);
  server.Wake();
}

// Model view at the last pose. If tracking is lost, the last frame with a pose, which shows the
// operator where to return.
Image<Rgb8> LiveServer::Parts::ModelPicture(const SurfelMap& map, ModelColors colors) {
  if (run.is_lost() && !run.is_done()) return pictures->OfLost(run.last_good());
  const Trajectory& path = run.path();
  return pictures->OfModel(map, path.empty() ? Rigid3d() : path.back().world_from_camera, colors);
}

// Frame and model views have the same pose. Returns false if the update was skipped.
bool LiveServer::Parts::GiveViews(const RgbdFrame& frame, const SurfelMap& map,
                                  const std::vector<Shown>& wanted, bool must) {
  std::map<Shown, Image<Rgb8>> views;
  for (const Shown which : wanted) {
    if (which == Shown::kFrame) {
      views[which] = pictures->OfFrame(frame);
    } else {
      views[which] =
          ModelPicture(map, which == Shown::kModel ? ModelColors::kColor : ModelColors::kNormals);
    }
  }
  return shown.UpdatePictures(views, must);
}

void LiveServer::Parts::GiveViewsIfDue(const SlamRunFrame& frame, bool must) {
  std::vector<Shown> wanted;
  bool all_exact = true;
  for (const Shown which : kViews) {
    if (!shown.IsRequested(which)) continue;
    wanted.push_back(which);
    all_exact &= is_exact[static_cast<std::size_t>(which)];
  }
  if (all_exact) return;
  views_pace.ActIfDue(must, [&] {
    if (!GiveViews(frame.frame, frame.map, wanted, must) || !must) return;
    for (const Shown which : wanted) is_exact[static_cast<std::size_t>(which)] = true;
    server.Wake();
  });
}

// Updates requested data. Each call updates only a part of the map. The shown map is exact after
// the second complete round since the last frame.
void LiveServer::Parts::GiveAll(const SlamRunFrame& frame, bool must) {
  if (!pictures) pictures.emplace(frame.sensor);
  Give(Shown::kMap, &map_pace, must, [&] {
    if (shown.UpdateMap(frame.map, kSlotsAtOnce).value_or(false)) ++map_rounds;
    return map_rounds > 1;
  });
  Give(Shown::kPath, &path_pace, must, [&] { return shown.UpdatePath(Thinned(run), must); });
  GiveViewsIfDue(frame, must);
  camera = frame.sensor.camera;
  GiveStateIfDue(must);
}

LiveServer::LiveServer(const ServeOptions& options, LiveRun* run) {
  Validate(options);
  if (options.port < 0) throw InputError("port is -1, must be at least 0 to serve pages");
  parts_ = std::make_unique<Parts>(options, run);
  parts_->UpdateState(/*must=*/true);
}

LiveServer::~LiveServer() = default;

std::string LiveServer::url() const {
  return Concat("http://", HostOf(parts_->server.address()), ":", parts_->server.port(), "/",
                parts_->token, "/");
}

// A frame older than kCameraGap_ms shows that tracking is late. Then map, path and views are
// updated only once per second.
void LiveServer::Show(const SlamRunFrame& frame) {
  constexpr double kCameraGap_ms = 33;
  constexpr std::chrono::seconds kLongest(1);
  parts_->is_exact.fill(false);
  parts_->is_state_exact = false;
  parts_->map_rounds = 0;
  const Clock::time_point now = Clock::now();
  std::optional<Clock::time_point>& last_turn = parts_->last_turn;
  if (!last_turn) last_turn = now;
  if (frame.age_ms > kCameraGap_ms && now - *last_turn < kLongest) {
    return parts_->GiveStateIfDue(/*must=*/false);
  }
  last_turn = now;
  parts_->GiveAll(frame, /*must=*/false);
}

void LiveServer::Wait(const SlamRunFrame& frame, int wait_ms) {
  parts_->GiveAll(frame, /*must=*/true);
  std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
}

void LiveServer::ShowWork() {
  parts_->state_pace.ActIfDue(/*must=*/false, [&] { parts_->UpdateState(/*must=*/false); });
}

// Shows the final results. Tracking has ended, so the server thread gets normal priority.
void LiveServer::Keep(const SlamRunResult& result) {
  Parts& parts = *parts_;
  parts.server.TakePriority();
  const auto is_wanted = [&](Shown which) { return parts.shown.IsRequested(which); };
  if (parts.pictures && std::any_of(kViews.begin(), kViews.end(), is_wanted)) {
    const RgbdFrame last = {0, 0, 0, {}, parts.run.last_good()};
    parts.GiveViews(last, result.map, {kViews.begin(), kViews.end()}, /*must=*/true);
  }
  parts.shown.ResetMap(result.map);
  parts.shown.UpdatePath(Thinned(parts.run), /*must=*/true);
  parts.UpdateState(/*must=*/true);
}

// Serves open pages until they have all data, but at most kMost_s. Pages have all data if no answer
// was sent for kWhile_s.
void LiveServer::Stay() {
  constexpr double kMost_s = 10, kWhile_s = 2;
  Parts& parts = *parts_;
  const auto begin = Clock::now();
  const auto gone_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  while (gone_s() < kMost_s && parts.shown.IsRequested(Shown::kState) &&
         std::min(gone_s(), parts.pages.SinceLastAnswer_s()) < kWhile_s) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    parts.server.Wake();  // for requests above the data limit
  }
}

}  // namespace surfit
