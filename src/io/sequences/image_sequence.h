#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/sequences/raw_frames.h"
#include "io/sequences/recording.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/prepare_frame.h"

namespace surfit {

// Throws InputError naming the image, its size and the camera's if they differ.
void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images);

// The moments that a frame with these stamps shows.
FrameStamps MomentsOf(const FrameStamps& stamps, const RgbdCamera& camera);

// Checks the sizes and prepares the frame. Throws InputError as RequireSizeOf().
RgbdFrame MakeFrame(const RgbdCamera& camera, const FramePreparer& preparer, FrameImages images,
                    int index, const FrameStamps& moments);

// Chosen frames of a recording one after the other.
class ImageSequence : public RawFrames {
 public:
  ImageSequence(std::unique_ptr<Recording> recording, std::vector<int> indices);

  // The first that can be read, and some that follow.
  std::vector<FrameImages> FirstImages() override;
  std::optional<RawFrame> Next() override;
  FrameImages Read() override { return recording_->Read(indices_[next_ - 1]); }

 private:
  std::unique_ptr<Recording> recording_;
  std::vector<int> indices_;
  std::size_t next_ = 0;
};

// Adds to the camera, ground truth and warnings in `info` what only images tell: the camera's sizes
// where they are unknown, doubts about the depth scale and the registration of colour, and with
// them the frames' camera. Mirrors the ground truth where the camera is, and logs what is assumed
// and the warnings. Returns what prepares the frames. Throws InputError naming the image whose size
// is not the camera's; of all images but the first no size is looked at.
FramePreparer CompleteInfo(const std::vector<FrameImages>& first, const PrepareOptions& options,
                           SequenceInfo* info);

// A sentence of warning if the median of the valid depth, or nearly all of it, is hardly that of a
// scene before a depth camera, with the scale in common use that would make it one. Depth in metres
// has no scale.
std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path);

}  // namespace surfit
