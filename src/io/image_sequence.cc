#include "io/image_sequence.h"

#include <utility>

#include "surfit/core/error.h"
#include "surfit/core/trace.h"
#include "surfit/frame/prepare_frame.h"

namespace surfit {
namespace {

template <typename T>
void RequireSize(const Image<T>& image, const PinholeCamera& camera, const char* whose,
                 const std::string& name) {
  if (image.width() == camera.width && image.height() == camera.height) return;
  throw InputError(Concat(name, " is ", image.width(), " x ", image.height(), " pixels, must be ",
                          camera.width, " x ", camera.height, " as ", whose));
}

class Corrected : public FrameSource {
 public:
  Corrected(std::unique_ptr<FrameSource> source, const InverseDepthField& field)
      : source_(std::move(source)), field_(field) {}

  const SequenceInfo& info() const override { return source_->info(); }

  std::optional<ReadResult> Next() override {
    std::optional<ReadResult> result = source_->Next();
    if (result && result->frame) {
      CorrectDepth(source_->info().pinhole, field_, &result->frame->depth_m);
    }
    return result;
  }

 private:
  std::unique_ptr<FrameSource> source_;
  InverseDepthField field_;
};

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

ImageSequence::ImageSequence(SequenceInfo info, std::unique_ptr<Recording> recording,
                             std::vector<int> indices, FramePreparer preparer)
    : info_(std::move(info)),
      recording_(std::move(recording)),
      indices_(std::move(indices)),
      preparer_(std::move(preparer)) {}

std::optional<ReadResult> ImageSequence::Next() {
  if (next_ == indices_.size()) return std::nullopt;
  ReadResult result;
  result.index = indices_[next_++];
  const FrameStamps moments = MomentsOf(recording_->stamps(result.index), info_.camera);
  result.stamp_s = moments.depth_s;
  try {
    const StageTimer timer("decode", result.index, &result.decode_ms);
    result.frame =
        MakeFrame(info_.camera, preparer_, recording_->Read(result.index), result.index, moments);
  } catch (const InputError& error) {
    result.error = error.what();
  }
  return result;
}

std::unique_ptr<FrameSource> CorrectedSource(std::unique_ptr<FrameSource> source,
                                             const InverseDepthField& field) {
  if (field.IsZero()) return source;
  return std::make_unique<Corrected>(std::move(source), field);
}

}  // namespace surfit
