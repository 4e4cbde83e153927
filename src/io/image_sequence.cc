#include "io/image_sequence.h"

#include <utility>

#include "io/read_image.h"
#include "surfit/core/error.h"
#include "surfit/core/trace.h"

namespace surfit {
namespace {

template <typename T>
void RequireSize(const Image<T>& image, const PinholeCamera& camera, const char* whose,
                 const std::string& path) {
  if (image.width() == camera.width && image.height() == camera.height) return;
  throw InputError(Concat(path, " is ", image.width(), " x ", image.height(), " pixels, must be ",
                          camera.width, " x ", camera.height, " as ", whose));
}

}  // namespace

FrameImages ReadFrameImages(const FrameFiles& files) {
  FrameImages images;
  images.depth = ReadDepthImage(files.depth_path);
  if (!files.color_path.empty()) images.color = ReadColorImage(files.color_path);
  return images;
}

void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images, const FrameFiles& files) {
  std::visit(
      [&](const auto& depth) {
        RequireSize(depth, camera.depth, "the depth camera", files.depth_path);
      },
      images.depth);
  if (images.color.empty()) return;
  if (camera.color_is_registered) {
    RequireSize(images.color, camera.depth, "depth, to which colour is registered",
                files.color_path);
  } else {
    RequireSize(images.color, camera.color, "the colour camera", files.color_path);
  }
}

ImageSequence::ImageSequence(SequenceInfo info, std::vector<IndexedFrame> frames,
                             FramePreparer preparer)
    : info_(std::move(info)), frames_(std::move(frames)), preparer_(std::move(preparer)) {}

RgbdFrame ImageSequence::Read(const IndexedFrame& indexed) const {
  FrameImages images = ReadFrameImages(indexed.files);
  RequireSizeOf(info_.camera, images, indexed.files);
  RgbdFrame frame = preparer_.Prepare(images.depth, std::move(images.color));
  frame.index = indexed.index;
  frame.stamp_s = indexed.files.stamp_s;
  return frame;
}

std::optional<ReadResult> ImageSequence::Next() {
  if (next_ == frames_.size()) return std::nullopt;
  const IndexedFrame& indexed = frames_[next_++];
  ReadResult result;
  result.index = indexed.index;
  result.stamp_s = indexed.files.stamp_s;
  try {
    const StageTimer timer("decode", indexed.index, &result.decode_ms);
    result.frame = Read(indexed);
  } catch (const InputError& error) {
    result.error = error.what();
  }
  return result;
}

}  // namespace surfit
