#include <cmath>
#include <vector>

#include "io/checks/recording_warnings.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// A separate colour camera is in the same device.
constexpr double kFarthestCamera_m = 0.5;
constexpr double kMinVisible = 0.3;      // of depth that the colour camera sees
constexpr double kMinInverseGain = 0.3;  // of RegistrationFit::given_score

// Colour of the first images as seen by a colour camera.
struct ColorView {
  double visible = 0;  // ratio of depth with colour
  std::optional<RegistrationFit> fit;
};

ColorView ViewOf(const std::vector<FrameImages>& images, const RgbdCamera& camera,
                 const RectifyOptions& options) {
  const FrameRectifier rectifier(camera, options);
  std::vector<FrameImages> frames;
  std::size_t depths = 0, visible = 0;
  for (const FrameImages& image : images) {
    if (image.color.empty()) continue;
    RgbdFrame frame = rectifier.Rectify(image.depth, image.color);
    for (std::size_t i = 0; i < frame.depth_m.size(); ++i) {
      if (!(frame.depth_m[i] > 0)) continue;
      const Rgb8 c = frame.color[i];
      ++depths;
      visible += c.r != 0 || c.g != 0 || c.b != 0;
    }
    frames.push_back({std::move(frame.depth_m), std::move(frame.color), "", ""});
  }
  ColorView view;
  if (depths == 0) return {1, std::nullopt};
  view.visible = static_cast<double>(visible) / static_cast<double>(depths);
  view.fit = FitRegistration(frames, rectifier.pinhole());
  return view;
}

}  // namespace

std::optional<std::string> ColorCameraWarning(const std::vector<FrameImages>& images,
                                              const RgbdCamera& camera,
                                              const RectifyOptions& options,
                                              std::optional<RegistrationFit>* registration) {
  const ColorView given = ViewOf(images, camera, options);
  *registration = given.fit;
  const double distance_m = camera.color_from_depth.translation.norm();
  if (distance_m > kFarthestCamera_m) {
    return Concat("the colour camera is ", distance_m,
                  " m from the depth camera, must be in the same device: color_from_depth has "
                  "its translation in m",
                  distance_m > 1 ? Concat(", and these may be mm (", distance_m, " mm)") : "");
  }
  RgbdCamera inverse = camera;
  inverse.color_from_depth = camera.color_from_depth.Inverse();
  const bool is_unseen = given.visible < kMinVisible;
  const double given_score = given.fit ? given.fit->given_score : 0;
  if (!is_unseen && (!given.fit || given.fit->scale == 1)) {
    const bool is_matched = !given.fit || (!given.fit->is_doubtful && given.fit->right_px == 0 &&
                                           given.fit->down_px == 0);
    if (is_matched) return std::nullopt;
  }
  const ColorView other = ViewOf(images, inverse, options);
  const double other_score = other.fit ? other.fit->given_score : 0;
  const bool inverse_is_seen = is_unseen && other.visible > 2 * kMinVisible;
  if (inverse_is_seen || (!is_unseen && other_score > given_score + kMinInverseGain)) {
    return Concat(
        "the colour camera is probably at the inverse place: edges of colour match "
        "edges of depth better with the inverse of color_from_depth (score ",
        other_score, " for ", given_score,
        "), which maps points of the depth camera to the colour camera");
  }
  if (is_unseen) {
    return Concat("the colour camera sees only ", std::lround(100 * given.visible),
                  " % of the depth: check color_camera and color_from_depth, which maps points of "
                  "the depth camera to the colour camera, in m");
  }
  if (!given.fit || !given.fit->is_doubtful) return std::nullopt;
  return Concat(
      "edges of registered colour do not lie on edges of depth: the best match has "
      "colour at ",
      std::lround(100 * given.fit->scale), " % of the size of depth, ", given.fit->right_px,
      " px to the right and ", given.fit->down_px,
      " px down. Check color_camera and color_from_depth");
}

}  // namespace surfit
