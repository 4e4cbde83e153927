#pragma once

#include <memory>
#include <string>

#include "io/images/image_files.h"
#include "surfit/core/image.h"

namespace surfit {

// Frames of a video file. The videoio library of OpenCV is loaded when a video is opened, because
// its 200 libraries would slow down the start of all programs. Not thread-safe.
class VideoFile {
 public:
  // Throws InputError that names the file, or the library that is missing.
  explicit VideoFile(const std::string& path);
  ~VideoFile();

  const std::string& path() const { return path_; }
  ImageSize size() const { return size_; }
  // Number of frames that the file has after the hidden frames.
  int frame_count() const { return frame_count_; }
  // Number of frames before the first decoded frame, see Mp4Samples.
  int hidden_frames() const { return hidden_; }

  // Decodes a frame, 0 to frame_count() - 1. Fast for ascending frames: other frames are decoded
  // from the start, because positions of compressed frames are not exact. Throws InputError with
  // the path and the frame if it cannot be decoded.
  Image<Rgb8> Read(int frame);

 private:
  struct Capture;

  std::string path_;
  std::unique_ptr<Capture> capture_;
  ImageSize size_;
  int frame_count_ = 0, hidden_ = 0;
  int next_ = 0;  // frame that the next grab decodes
};

}  // namespace surfit
