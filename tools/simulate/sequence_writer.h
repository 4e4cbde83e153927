#pragma once

#include <string>

#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"

namespace surfit::tools {

// How a sequence's folder looks.
enum class SequenceLayout {
  kTum,      // rgb.txt, depth.txt, associations.txt (colour first); files named after their stamps
  kIclNuim,  // associations.txt (depth first), simulated.gt.freiburg; files named after, and stamps
             // equal to, the frame's number; the image y axis points up: fy < 0, poses S pose S
};

// Writes an RGB-D sequence: rgb/, depth/ (16 bit PNG, 0 = missing), camera.yaml, groundtruth.txt
// and the lists of the layout.
class SequenceWriter {
 public:
  // The camera and the poses are upright and right-handed in both layouts; the writer mirrors what
  // the layout wants mirrored. Makes the folder, or empties that of a former run; a folder that
  // holds anything else is refused.
  // Throws InputError naming the folder or file, as do all others.
  SequenceWriter(const std::string& folder, SequenceLayout layout, const RgbdCamera& camera);

  // All but the images: the lists and the poses.
  void WriteLists(const Trajectory& world_from_camera) const;
  // The images of frame i; different frames may be written at the same time.
  void WriteFrame(int i, double stamp_s, const Image<Rgb8>& color,
                  const Image<float>& depth_m) const;

 private:
  double StampOf(int i, double stamp_s) const;
  std::string NameOf(int i, double stamp_s) const;

  std::string folder_;
  SequenceLayout layout_;
  RgbdCamera camera_;
};

}  // namespace surfit::tools
