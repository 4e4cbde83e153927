#pragma once

#include <memory>
#include <vector>

#include "io/recording.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/io/frame_source.h"

namespace surfit {

// Throws InputError naming the image, its size and the camera's if they differ.
void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images);

// Checks the sizes and prepares the frame. Throws InputError as RequireSizeOf().
RgbdFrame MakeFrame(const RgbdCamera& camera, const FramePreparer& preparer, FrameImages images,
                    int index, double stamp_s);

// Reads and prepares chosen frames of a recording one after the other.
class ImageSequence : public FrameSource {
 public:
  // The preparer may have the mirrored camera; info.camera is the files'.
  ImageSequence(SequenceInfo info, std::unique_ptr<Recording> recording, std::vector<int> indices,
                FramePreparer preparer);

  const SequenceInfo& info() const override { return info_; }
  std::optional<ReadResult> Next() override;

 private:
  SequenceInfo info_;
  std::unique_ptr<Recording> recording_;
  std::vector<int> indices_;
  FramePreparer preparer_;
  std::size_t next_ = 0;
};

}  // namespace surfit
