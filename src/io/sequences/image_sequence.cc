#include "io/sequences/image_sequence.h"

#include <utility>

#include "core/trace.h"
#include "surfit/core/error.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {
namespace {

template <typename T>
void RequireSize(const Image<T>& image, const PinholeCamera& camera, const char* whose,
                 const std::string& name) {
  if (image.width() == camera.width && image.height() == camera.height) return;
  throw InputError(name, " is ", image.width(), " x ", image.height(), " pixels, must be ",
                   camera.width, " x ", camera.height, " as ", whose);
}

}  // namespace

void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images) {
  std::visit(
      [&](const auto& depth) {
        RequireSize(depth, camera.depth, "the depth camera", images.depth_name);
      },
      images.depth);
  if (images.color.empty()) return;
  if (camera.color_is_registered) {
    RequireSize(images.color, camera.depth,
                "depth, to which colour is registered; else tell the camera of its own that it "
                "has: color_camera and color_from_depth in a camera.yaml, or color_intrinsics",
                images.color_name);
  } else {
    RequireSize(images.color, camera.color, "the colour camera", images.color_name);
  }
}

FrameStamps MomentsOf(const FrameStamps& stamps, const RgbdCamera& camera) {
  return {stamps.depth_s - camera.latency_s,
          stamps.color_s - camera.latency_s - camera.color_latency_s};
}

RgbdFrame MakeFrame(const RgbdCamera& camera, const FramePreparer& preparer, FrameImages images,
                    int index, const FrameStamps& moments) {
  RequireSizeOf(camera, images);
  RgbdFrame frame = preparer.Prepare(images.depth, std::move(images.color));
  frame.index = index;
  frame.stamp_s = moments.depth_s;
  frame.color_stamp_s = moments.color_s;
  return frame;
}

ImageSequence::ImageSequence(std::unique_ptr<Recording> recording, std::vector<int> indices)
    : recording_(std::move(recording)), indices_(std::move(indices)) {}

std::vector<FrameImages> ImageSequence::FirstImages() {
  constexpr std::size_t kImages = 8, kApart = 15;
  std::vector<FrameImages> images;
  std::string first_error;
  for (std::size_t i = 0; i < indices_.size() && images.size() < kImages;
       i += images.empty() ? 1 : kApart) {
    try {
      images.push_back(recording_->Read(indices_[i]));
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  ThrowIf(images.empty(), "no frame can be read: ", first_error);
  return images;
}

std::optional<RawFrame> ImageSequence::Next() {
  if (next_ == indices_.size()) return std::nullopt;
  RawFrame frame;
  frame.head.index = indices_[next_++];
  frame.stamps = recording_->stamps(frame.head.index);
  return frame;
}

}  // namespace surfit
