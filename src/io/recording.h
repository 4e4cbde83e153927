#pragma once

#include <memory>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// The images of one frame as the recording has them.
struct FrameImages {
  RawDepth depth;
  Image<Rgb8> color;       // empty where the frame has no colour
  std::string depth_name;  // the file, and the place in it, for messages
  std::string color_name;
};

// The frames of a sequence, in a folder of images or in one file. Not thread-safe.
class Recording {
 public:
  virtual ~Recording() = default;
  virtual int frame_count() const = 0;
  virtual double stamp_s(int index) const = 0;
  // Throws InputError naming what cannot be read.
  virtual FrameImages Read(int index) const = 0;
};

// A recording with what stands beside its frames.
struct OpenedRecording {
  std::unique_ptr<Recording> frames;
  Trajectory ground_truth;            // as the files have it
  std::vector<std::string> warnings;  // what the user should know
};

}  // namespace surfit
