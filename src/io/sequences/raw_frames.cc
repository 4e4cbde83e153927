#include "io/sequences/raw_frames.h"

#include <cmath>
#include <functional>
#include <utility>

#include "core/trace.h"
#include "io/checks/color_faults.h"
#include "io/checks/static_parts.h"
#include "io/depth/depth_encoding.h"
#include "io/sequences/sequence_info.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

template <typename T>
void RequireSize(const Image<T>& image, const PinholeCamera& camera, const char* whose,
                 const std::string& name) {
  if (image.width() == camera.width && image.height() == camera.height) return;
  throw InputError(name, " is ", image.width(), " x ", image.height(), " pixels, must be ",
                   camera.width, " x ", camera.height, ", the size of ", whose);
}

using ImageChange = std::function<void(FrameImages*)>;

// Frames with changed images.
class ChangedFrames : public RawFrames {
 public:
  ChangedFrames(std::unique_ptr<RawFrames> frames, ImageChange change)
      : frames_(std::move(frames)), change_(std::move(change)) {}

  std::vector<FrameImages> FirstImages() override {
    std::vector<FrameImages> images = frames_->FirstImages();
    for (FrameImages& image : images) change_(&image);
    return images;
  }
  std::optional<RawFrame> Next() override { return frames_->Next(); }
  FrameImages Read() override {
    FrameImages images = frames_->Read();
    change_(&images);
    return images;
  }

 private:
  std::unique_ptr<RawFrames> frames_;
  ImageChange change_;
};

void RemoveColor(FrameImages* images) { images->color = {}; }

class SequenceSource : public FrameSource {
 public:
  explicit SequenceSource(RawSequence sequence) : sequence_(std::move(sequence)) {}

  const SequenceInfo& info() const override { return sequence_.info; }

  std::optional<ReadResult> Next() override {
    std::optional<RawFrame> raw = sequence_.frames->Next();
    if (!raw) return std::nullopt;
    ReadResult result = raw->head;
    result.stamp_s = CaptureTimes(raw->stamps, info().camera).depth_s;
    if (!result.error.empty()) return result;
    try {
      const StageTimer timer("read", result.index, &result.read_ms);
      result.frame = sequence_.MakeFrame(*raw, sequence_.frames->Read());
    } catch (const InputError& error) {
      result.error = error.what();
    }
    return result;
  }

 private:
  RawSequence sequence_;
};

}  // namespace

RgbdFrame RawSequence::MakeFrame(const RawFrame& raw, FrameImages images) const {
  RgbdFrame frame =
      RectifyFrame(info.camera, rectifier, std::move(images), raw.head.index, raw.stamps);
  if (!field.IsZero()) CorrectDepth(info.pinhole, field, &frame.depth_m);
  return frame;
}

FrameStamps CaptureTimes(const FrameStamps& stamps, const RgbdCamera& camera) {
  return {stamps.depth_s - camera.latency_s,
          stamps.color_s - camera.latency_s - camera.color_latency_s};
}

void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images) {
  std::visit(
      [&](const auto& depth) {
        RequireSize(depth, camera.depth, "the depth camera", images.depth_name);
      },
      images.depth);
  if (images.color.empty()) return;
  if (camera.color_is_registered) {
    RequireSize(images.color, camera.depth,
                "the depth image, because colour is registered to depth; for a separate colour "
                "camera set color_camera and color_from_depth in camera.yaml, or color_intrinsics",
                images.color_name);
  } else {
    RequireSize(images.color, camera.color, "the colour camera", images.color_name);
  }
}

RgbdFrame RectifyFrame(const RgbdCamera& camera, const FrameRectifier& rectifier,
                       FrameImages images, int index, const FrameStamps& stamps) {
  RequireSizeOf(camera, images);
  RgbdFrame frame = rectifier.Rectify(images.depth, std::move(images.color));
  const FrameStamps captured = CaptureTimes(stamps, camera);
  frame.index = index;
  frame.stamp_s = captured.depth_s;
  frame.color_stamp_s = captured.color_s;
  return frame;
}

RawSequence MakeRawSequence(SequenceInfo info, std::unique_ptr<RawFrames> frames,
                            const SequenceOptions& options, bool scale_is_given) {
  std::vector<FrameImages> images = frames->FirstImages();
  const auto change_all = [&](const ImageChange& change) {
    for (FrameImages& image : images) change(&image);
    frames = std::make_unique<ChangedFrames>(std::move(frames), change);
  };
  const DepthEncoding encoding = DetectDepthEncoding(images, info.camera, &info.warnings);
  if (!encoding.IsPlain())
    change_all([encoding](FrameImages* image) { DecodeDepth(encoding, &image->depth); });
  if (const std::optional<StaticParts> parts = FindStaticParts(images)) {
    info.warnings.push_back(Concat(
        std::lround(100 * parts->ratio),
        " % of the depth at the rim of the view does not change while the rest moves: it is part "
        "of the robot or of the camera mount, and is missing depth in all frames"));
    change_all(
        [mask = parts->mask](FrameImages* image) { RemoveStaticParts(mask, &image->depth); });
  }
  if (const auto fault = ColorFault(images)) {
    info.warnings.push_back(*fault + ": colour is not used");
    change_all(RemoveColor);
  }
  std::optional<RegistrationFit> registration;
  FrameRectifier rectifier =
      CompleteInfo(images, options.rectify, scale_is_given, &info, &registration);
  if (registration && registration->turn != ImageTurn::kNone)
    frames = std::make_unique<ChangedFrames>(std::move(frames), RemoveColor);
  InverseDepthField field = ReadDepthField(options, info.format);
  return {std::move(info), std::move(frames), std::move(rectifier),
          field,           scale_is_given,    registration};
}

std::unique_ptr<FrameSource> MakeFrameSource(RawSequence sequence) {
  return std::make_unique<SequenceSource>(std::move(sequence));
}

}  // namespace surfit
