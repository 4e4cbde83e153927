#include "run/kept_views.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "io/jpeg.h"
#include "pictures/color_scale.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

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

KeptView MakeView(const RgbdFrame& frame, const SurfelMap& map, const PinholeCamera& camera,
                  const Rigid3d& world_from_camera) {
  const ModelView model = ModelRenderer(RenderOptions()).Render(map, camera, world_from_camera);
  const ColorScale scale = ScaleOf(frame.depth_m);
  KeptView view = {frame.index, frame.stamp_s, {}};
  if (!frame.color.empty()) {
    view.pictures.push_back({"input_color", EncodeJpeg(frame.color, kQuality)});
    view.pictures.push_back({"model_color", EncodeJpeg(ColorsOf(model, map), kQuality)});
  }
  view.pictures.push_back({"input_depth", DepthJpeg(frame.depth_m, scale)});
  view.pictures.push_back({"model_depth", DepthJpeg(model.surface.vertex.z, scale)});
  return view;
}

}  // namespace

void KeptViews::Offer(const RgbdFrame& frame, const SurfelMap& map, const PinholeCamera& camera,
                      const Rigid3d& world_from_camera) {
  if (offered_++ % stride_ != 0) return;
  if (views_.size() == kMost) {
    for (int i = 1; 2 * i < kMost; ++i) views_[i] = std::move(views_[2 * i]);
    views_.resize((kMost + 1) / 2);
    stride_ *= 2;
    // kMost is even: this frame is a multiple of the new stride as well.
  }
  views_.push_back(MakeView(frame, map, camera, world_from_camera));
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

void KeptViews::Write(const std::string& folder) const {
  if (views_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder + "/views", error);
  if (error) throw InputError(Concat(folder, "/views: cannot be made: ", error.message()));
  for (std::size_t i = 0; i < views_.size(); ++i) {
    for (const KeptView::Picture& picture : views_[i].pictures) {
      WriteFileAtomically(folder + "/" + FileName(static_cast<int>(i), picture.name),
                          [&](std::ostream& file) { file << picture.jpeg; });
    }
  }
}

}  // namespace surfit
