#include "io/sequences/sequence_info.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>

#include "io/depth/depth_encoding.h"
#include "io/sequences/raw_frames.h"
#include "io/sequences/sequence_camera.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

template <typename T>
void TakeSizeIfUnknown(const Image<T>& image, PinholeCamera* camera) {
  if (camera->width != 0) return;
  camera->width = image.width();
  camera->height = image.height();
}

// Throws InputError if the camera is guessed and the image has another size.
void RequireGuessedSize(const FrameImages& first, const SequenceInfo& info) {
  const PinholeCamera& guess = info.camera.depth;
  std::visit(
      [&](const auto& depth) {
        if (!info.camera_is_guessed || guess.width == 0 ||
            (depth.width() == guess.width && depth.height() == guess.height)) {
          return;
        }
        const std::string presets = PresetsOfSize(depth.width(), depth.height());
        throw InputError(
            first.depth_name, " is ", depth.width(), " x ", depth.height(),
            " pixels, and its camera is unknown (the default camera has ", guess.width, " x ",
            guess.height, "): set camera to a camera.yaml or a preset, or set intrinsics ",
            "and depth_scale", presets.empty() ? "" : " (presets of this size: " + presets + ")");
      },
      first.depth);
}

// First image with colour, otherwise the first image.
const FrameImages& FirstWithColor(const std::vector<FrameImages>& images) {
  const auto found = std::find_if(images.begin(), images.end(),
                                  [](const FrameImages& image) { return !image.color.empty(); });
  return found == images.end() ? images[0] : *found;
}

void CompleteCamera(const FrameImages& first, const Image<Rgb8>& color, SequenceInfo* info) {
  RequireGuessedSize(first, *info);
  RgbdCamera* const camera = &info->camera;
  std::visit([&](const auto& depth) { TakeSizeIfUnknown(depth, &camera->depth); }, first.depth);
  if (!camera->color_is_registered) {
    if (color.empty()) camera->color_is_registered = true;
    TakeSizeIfUnknown(color, &camera->color);
  }
  RequireSizeOf(*camera, first);
}

// Throws InputError for intrinsics that are ratios of the image size, as some programs write them.
// A focal length below kMaxFocal_px is a field of view of at least 150 degrees. A principal point
// below 1 px is the corner of the image.
void RequirePixelUnits(const PinholeCamera& camera, const char* whose, const std::string& from) {
  constexpr double kMaxFocal_px = 4;
  constexpr int kMinWidth_px = 32;  // smaller images can have focal lengths of a few px
  if (camera.width < kMinWidth_px) return;
  const auto is_ratio = [](double center) { return center > 0 && center < 1; };
  const bool has_focal_px = std::max(std::abs(camera.fx), std::abs(camera.fy)) > kMaxFocal_px;
  if (has_focal_px && !(is_ratio(camera.cx) && is_ratio(camera.cy))) return;
  throw InputError("the intrinsics of ", whose, " (", from, ") are fx ", camera.fx, ", fy ",
                   camera.fy, ", cx ", camera.cx, ", cy ", camera.cy, ", must be in px of the ",
                   camera.width, " x ", camera.height,
                   " images: multiply fx and cx by the width, fy and cy by the height");
}

// Sets SequenceInfo::confidence_range and low_confidence_ratio.
void CompleteConfidence(const std::vector<FrameImages>& images, SequenceInfo* info) {
  LowConfidence sum;
  for (const FrameImages& image : images) {
    sum.range = std::max(sum.range, image.low_confidence.range);
    sum.depths += image.low_confidence.depths;
    sum.removed += image.low_confidence.removed;
  }
  info->confidence_range = sum.range;
  if (sum.range == 0) return;
  info->low_confidence_ratio =
      sum.depths == 0 ? 0 : static_cast<double>(sum.removed) / static_cast<double>(sum.depths);
}

// Text with the confidence range and the ratio of removed depth. "" without confidence images.
std::string ConfidenceFigures(const SequenceInfo& info) {
  const int range = info.confidence_range;
  if (range == 0) return "";
  return Concat(", confidence 0 to ", range, ": low confidence (below ", (range + 2) / 3,
                ") removes ", 0.1 * std::round(1000 * info.low_confidence_ratio.value_or(0)),
                " % of depth in the first images");
}

std::string Assumed(bool has_color, const SequenceInfo& info) {
  const RgbdCamera& c = info.camera;
  std::string frames = info.frame_count < 0 ? "live frames" : Concat(info.frame_count, " frames");
  std::string color = "no colour";
  if (has_color) {
    color = c.color_is_registered
                ? "colour registered to depth"
                : Concat("separate colour camera, ", c.color.width, " x ", c.color.height);
  }
  return Concat("format ", info.format, ", ", frames, ", depth ", c.depth.width, " x ",
                c.depth.height, ", ", color, ConfidenceFigures(info), "\ndepth camera ",
                FormatDepthCamera(c), ": ", info.camera_from);
}

void Mirror(Trajectory* trajectory) {
  for (StampedPose& pose : *trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
}

// Logs the assumptions, unless they are equal to the last logged assumptions.
void Tell(const std::string& assumed) {
  static std::mutex mutex;
  static auto* const told = new std::string;
  const std::lock_guard<std::mutex> lock(mutex);
  if (assumed == *told) return;
  *told = assumed;
  std::istringstream lines(assumed);
  for (std::string line; std::getline(lines, line);) LOG(INFO) << line;
}

}  // namespace

FrameRectifier CompleteInfo(const std::vector<FrameImages>& images, const RectifyOptions& options,
                            bool scale_is_given, SequenceInfo* info,
                            std::optional<RegistrationFit>* registration) {
  const FrameImages& first = images[0];
  const FrameImages& colored = FirstWithColor(images);
  CompleteCamera(first, colored.color, info);
  RequirePixelUnits(info->camera.depth, "the depth camera", info->camera_from);
  if (!info->camera.color_is_registered)
    RequirePixelUnits(info->camera.color, "the colour camera", info->camera_from);
  CompleteConfidence(images, info);
  info->assumed = Assumed(!colored.color.empty(), *info);
  if (!info->camera.disparity.IsGiven()) {
    if (auto warning = DepthScaleWarning(first.depth, info->camera.depth_units_per_metre,
                                         first.depth_name, scale_is_given))
      info->warnings.push_back(*warning);
  }
  if (auto warning = FarDepthWarning(images, info->camera, options.max_depth_m))
    info->warnings.push_back(*warning);
  if (info->camera.color_is_registered) {
    *registration = FitRegistration(images, info->camera.depth);
    if (*registration) {
      if (auto doubt = RegistrationWarning(**registration, info->camera.depth))
        info->warnings.push_back(*doubt);
    }
  }
  info->mirrored = info->camera.depth.fy < 0;
  if (info->mirrored) Mirror(&info->ground_truth);
  const RgbdCamera upright = info->mirrored ? Mirrored(info->camera) : info->camera;
  if (!upright.color_is_registered) {
    if (auto doubt = ColorCameraWarning(images, upright, options, registration))
      info->warnings.push_back(*doubt);
  }
  FrameRectifier rectifier(upright, options);
  info->pinhole = rectifier.pinhole();
  Tell(info->assumed);
  for (const std::string& warning : info->warnings) LOG(WARNING) << warning;
  return rectifier;
}

}  // namespace surfit
