#include "run/kept_views.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "io/image_files.h"
#include "pictures/coloring.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/mapping/blended_view.h"

namespace surfit {
namespace {

constexpr int kQuality = 85;  // of JPEG: differences of pictures stay visible, files small
constexpr Rgb8 kNoDepth = {40, 40, 40};

std::vector<std::string> PictureNames() {
  return {"input_color", "model_color", "input_depth", "model_depth"};
}

// The same colours in both pictures of a view, so that they can be compared.
ColorScale ScaleOf(const Image<float>& depth_m) {
  float low = 0, high = 0;
  for (const float depth : depth_m) {
    if (!(depth > 0)) continue;
    low = low > 0 ? std::min(low, depth) : depth;
    high = std::max(high, depth);
  }
  return ColorScale(low, high, false);
}

std::string DepthJpeg(const Image<float>& depth_m, const ColorScale& scale) {
  Image<Rgb8> image(depth_m.width(), depth_m.height(), kNoDepth);
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    if (depth_m[i] > 0) image[i] = scale.ColorOf(depth_m[i]);
  }
  return EncodeJpeg(image, kQuality);
}

KeptView MakeView(const RgbdFrame& frame, const SurfelMap& map, const DepthSensor& sensor,
                  const Rigid3d& world_from_camera, const char* why) {
  const BlendedView model = DrawBlended(map, sensor, world_from_camera);
  const ColorScale scale = ScaleOf(frame.depth_m);
  KeptView view = {frame.index, frame.stamp_s, why, {}};
  if (!frame.color.empty()) {
    view.pictures.push_back({"input_color", EncodeJpeg(frame.color, kQuality)});
    view.pictures.push_back({"model_color", EncodeJpeg(model.color, kQuality)});
  }
  view.pictures.push_back({"input_depth", DepthJpeg(frame.depth_m, scale)});
  view.pictures.push_back({"model_depth", DepthJpeg(model.depth_m, scale)});
  return view;
}

// In order of their frames; of a frame that was kept twice the first, for both reasons.
std::vector<KeptView> Merge(std::vector<KeptView> views) {
  std::stable_sort(views.begin(), views.end(),
                   [](const KeptView& a, const KeptView& b) { return a.index < b.index; });
  std::vector<KeptView> merged;
  for (KeptView& view : views) {
    if (!merged.empty() && merged.back().index == view.index) {
      merged.back().why += ", " + view.why;
    } else {
      merged.push_back(std::move(view));
    }
  }
  return merged;
}

}  // namespace

bool KeptViews::IsNextOfStride() {
  if (offered_++ % stride_ != 0) return false;
  if (evenly_spread_.size() == kMostEven) {
    for (int i = 1; 2 * i < kMostEven; ++i) {
      evenly_spread_[i] = std::move(evenly_spread_[2 * i]);
    }
    evenly_spread_.resize((kMostEven + 1) / 2);
    stride_ *= 2;
    // kMostEven is even: this frame is a multiple of the new stride as well.
  }
  return true;
}

void KeptViews::Offer(const RgbdFrame& frame, const FrameReport& report, const SurfelMap& map,
                      const DepthSensor& sensor) {
  const bool is_lost = report.state == FrameState::kLost;
  if (is_lost && (first_lost_ || !last_)) return;
  const Rigid3d& pose = is_lost ? last_->world_from_camera : report.world_from_camera;
  const auto make = [&](const char* why) { return MakeView(frame, map, sensor, pose, why); };
  if (is_lost) {
    first_lost_ = make("first that was lost, the model from the pose before");
    return;
  }
  if (IsNextOfStride()) evenly_spread_.push_back(make("evenly spread"));
  const bool is_degenerate = report.state == FrameState::kDegenerate;
  if (is_degenerate && !first_degenerate_) {
    first_degenerate_ = make("first with directions that the data leaves free");
  }
  const bool is_registered = is_degenerate || report.state == FrameState::kTracked;
  if (is_registered && report.icp.rmse_m > worst_rmse_m_) {
    worst_rmse_m_ = report.icp.rmse_m;
    worst_ = make("largest RMSE of registration");
  }
  last_ = {frame, pose};
}

std::vector<KeptView> KeptViews::Finish(const SurfelMap& map, const DepthSensor& sensor) const {
  std::vector<KeptView> views = evenly_spread_;
  for (const auto* view : {&first_lost_, &first_degenerate_, &worst_}) {
    if (*view) views.push_back(**view);
  }
  if (last_) views.push_back(MakeView(last_->frame, map, sensor, last_->world_from_camera, "last"));
  return Merge(std::move(views));
}

std::string KeptViews::FileName(int view, const std::string& picture) {
  return Concat("views/", view, "_", picture, ".jpg");
}

std::vector<std::string> KeptViews::FileNames() {
  std::vector<std::string> names;
  for (int view = 0; view < kMost; ++view) {
    for (const std::string& picture : PictureNames()) names.push_back(FileName(view, picture));
  }
  return names;
}

void KeptViews::Write(const std::vector<KeptView>& views, const std::string& folder) {
  if (views.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder + "/views", error);
  if (error) throw InputError(Concat(folder, "/views: cannot be made: ", error.message()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const KeptView::Picture& picture : views[i].pictures) {
      WriteFileAtomically(folder + "/" + FileName(static_cast<int>(i), picture.name),
                          [&](std::ostream& file) { file << picture.jpeg; });
    }
  }
}

}  // namespace surfit
