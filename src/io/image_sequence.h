#pragma once

#include <vector>

#include "io/sequence_files.h"
#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/io/frame_source.h"

namespace surfit {

// The images of one frame as the files have them.
struct FrameImages {
  RawDepth depth;
  Image<Rgb8> color;  // empty where the sequence has no colour
};

// Throws InputError naming the file that cannot be read.
FrameImages ReadFrameImages(const FrameFiles& files);

// Throws InputError naming the file, its size and the camera's if they differ.
void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images, const FrameFiles& files);

struct IndexedFrame {
  int index = 0;  // position in the whole sequence
  FrameFiles files;
};

// Reads and prepares the listed frames one after the other.
class ImageSequence : public FrameSource {
 public:
  // The preparer may have the mirrored camera; info.camera is the files'.
  ImageSequence(SequenceInfo info, std::vector<IndexedFrame> frames, FramePreparer preparer);

  const SequenceInfo& info() const override { return info_; }
  std::optional<ReadResult> Next() override;

 private:
  RgbdFrame Read(const IndexedFrame& frame) const;

  SequenceInfo info_;
  std::vector<IndexedFrame> frames_;
  FramePreparer preparer_;
  std::size_t next_ = 0;
};

}  // namespace surfit
