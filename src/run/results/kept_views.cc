#include "run/results/kept_views.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "io/images/image_files.h"
#include "mapping/rendering/blended_view.h"
#include "output/pictures/canvas.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kQuality = 85;  // JPEG quality; differences of views remain visible
constexpr Rgb8 kNoDepth = {40, 40, 40};

std::vector<std::string> PictureNames() {
  return {"input_color", "model_color", "input_depth", "model_depth"};
}

// Colour scale of both depth pictures of a view, from the depth range of the frame.
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

// Sorts views by frame. Merges views of the same frame and their reasons.
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

// Paths of all pictures that Kept::Write() may create. `Kept`: KeptViews or Thumbnails.
template <typename Kept>
std::vector<std::string> AllFileNames(const std::vector<std::string>& pictures) {
  std::vector<std::string> names;
  for (int view = 0; view < Kept::kMost; ++view) {
    for (const std::string& picture : pictures) names.push_back(Kept::FileName(view, picture));
  }
  return names;
}

template <typename Kept>
void WritePictures(const std::vector<KeptView>& views, const std::string& folder) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const KeptView::Picture& picture : views[i].pictures) {
      const std::filesystem::path path =
          folder + "/" + Kept::FileName(static_cast<int>(i), picture.name);
      std::error_code error;
      std::filesystem::create_directories(path.parent_path(), error);
      if (error) {
        throw InputError(
            Concat(path.parent_path().string(), ": cannot create the folder: ", error.message()));
      }
      WriteFileAtomically(path.string(), [&](std::ostream& file) { file << picture.jpeg; });
    }
  }
}

int FactorOf(int width) { return std::max(1, width / Thumbnails::kWidth_px); }

Image<Rgb8> Smaller(const Image<Rgb8>& image, int factor) {
  Image<Rgb8> small((image.width() + factor - 1) / factor, (image.height() + factor - 1) / factor);
  const cv::Mat whole(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat target = AsMat(&small);
  cv::resize(whole, target, target.size(), 0, 0, cv::INTER_AREA);
  return small;
}

// Takes every factor-th pixel. Mean depths across depth edges would not be on a surface.
Image<float> EveryOf(const Image<float>& depth_m, int factor) {
  Image<float> some((depth_m.width() + factor - 1) / factor,
                    (depth_m.height() + factor - 1) / factor);
  for (int v = 0; v < some.height(); ++v) {
    for (int u = 0; u < some.width(); ++u) some(u, v) = depth_m(factor * u, factor * v);
  }
  return some;
}

std::string Small(const Image<Rgb8>& image) {
  constexpr int kSmallQuality = 75;
  return EncodeJpeg(image, kSmallQuality);
}

}  // namespace

void KeptViews::Offer(const RgbdFrame& frame, const FrameReport& report, const SurfelMap& map,
                      const DepthSensor& sensor) {
  const bool is_lost = !report.HasPose();
  if (is_lost && (first_lost_ || !last_)) return;
  const Rigid3d& pose = is_lost ? last_->world_from_camera : report.world_from_camera;
  const auto make = [&](const char* why) { return MakeView(frame, map, sensor, pose, why); };
  if (is_lost) {
    first_lost_ = make("first lost frame, model view at the last pose");
    return;
  }
  if (evenly_spread_.TakesNext()) evenly_spread_.Keep(make("evenly spread"));
  const bool is_degenerate = report.state == FrameState::kDegenerate;
  if (is_degenerate && !first_degenerate_) {
    first_degenerate_ = make("first degenerate frame");
  }
  const bool is_registered = is_degenerate || report.state == FrameState::kTracked;
  if (is_registered && report.icp.rmse_m > worst_rmse_m_) {
    worst_rmse_m_ = report.icp.rmse_m;
    worst_ = make("largest registration RMSE");
  }
  last_ = {frame, pose};
}

std::vector<KeptView> KeptViews::Finish(const SurfelMap& map, const DepthSensor& sensor) const {
  std::vector<KeptView> views = evenly_spread_.kept();
  for (const auto* view : {&first_lost_, &first_degenerate_, &worst_}) {
    if (*view) views.push_back(**view);
  }
  if (last_) views.push_back(MakeView(last_->frame, map, sensor, last_->world_from_camera, "last"));
  return Merge(std::move(views));
}

std::string KeptViews::FileName(int view, const std::string& picture) {
  return Concat("views/", view, "_", picture, ".jpg");
}

std::vector<std::string> KeptViews::FileNames() { return AllFileNames<KeptViews>(PictureNames()); }

void KeptViews::Write(const std::vector<KeptView>& views, const std::string& folder) {
  WritePictures<KeptViews>(views, folder);
}

void Thumbnails::Offer(const RgbdFrame& frame) {
  if (!kept_.TakesNext()) return;
  const int factor = FactorOf(frame.depth_m.width());
  Kept kept = {frame.index, frame.stamp_s, {}, {}};
  if (frame.color.empty()) {
    kept.depth_m = EveryOf(frame.depth_m, factor);
  } else {
    kept.color = Smaller(frame.color, factor);
  }
  kept_.Keep(std::move(kept));
}

std::vector<KeptView> Thumbnails::Finish(const SurfelMap& map, const DepthSensor& sensor,
                                         const std::map<int, Rigid3d>& world_from_camera) const {
  const DepthSensor small = {sensor.camera.Subsampled(FactorOf(sensor.camera.width)), sensor.noise};
  std::vector<KeptView> thumbnails;
  for (const Kept& kept : kept_.kept()) {
    KeptView view = {kept.index, kept.stamp_s, "", {}};
    const bool has_color = !kept.color.empty();
    const ColorScale scale = ScaleOf(kept.depth_m);
    view.pictures.push_back(has_color
                                ? KeptView::Picture{"input_color", Small(kept.color)}
                                : KeptView::Picture{"input_depth", DepthJpeg(kept.depth_m, scale)});
    const auto pose = world_from_camera.find(kept.index);
    if (pose != world_from_camera.end()) {
      const BlendedView model = DrawBlended(map, small, pose->second);
      view.pictures.push_back(
          has_color ? KeptView::Picture{"model_color", Small(model.color)}
                    : KeptView::Picture{"model_depth", DepthJpeg(model.depth_m, scale)});
    }
    thumbnails.push_back(std::move(view));
  }
  return thumbnails;
}

std::string Thumbnails::FileName(int thumbnail, const std::string& picture) {
  return Concat("thumbnails/", thumbnail, "_", picture, ".jpg");
}

std::vector<std::string> Thumbnails::FileNames() {
  return AllFileNames<Thumbnails>(PictureNames());
}

void Thumbnails::Write(const std::vector<KeptView>& thumbnails, const std::string& folder) {
  WritePictures<Thumbnails>(thumbnails, folder);
}

}  // namespace surfit
