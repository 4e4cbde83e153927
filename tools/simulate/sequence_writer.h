#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"

namespace surfit::tools {

// How a sequence's folder looks.
enum class SequenceLayout {
  kTum,      // rgb.txt, depth.txt, associations.txt (colour first); files named after their stamps
  kIclNuim,  // associations.txt (depth first), simulated.gt.freiburg; files named after, and stamps
             // equal to, the frame's number; the image y axis points up: fy < 0, poses S pose S
};

// What is true of a sequence and its camera.yaml may not tell.
struct SequenceTruth {
  RgbdCamera camera;        // stamps of images are later than poses by its latency
  InverseDepthField field;  // what its depth needs to be right
  double color_readout_s = 0, exposure_s = 0;
  std::vector<double> color_moments_s;  // the middle of each frame's exposure and readout
  std::vector<Eigen::Vector3f> gains;   // what the channels of its light are multiplied by
};

// Writes an RGB-D sequence: rgb/, depth/ (16 bit PNG, 0 = missing), camera.yaml, groundtruth.txt
// and the lists of the layout.
class SequenceWriter {
 public:
  // `camera` is what camera.yaml tells. It and the poses are upright and right-handed in both
  // layouts; the writer mirrors what the layout wants mirrored. Makes the folder, or empties that
  // of a former run; a folder that holds anything else is refused. Images have stamps that are
  // later by latency_s; not so in the layout that numbers them. Throws InputError naming the folder
  // or file, as do all others.
  SequenceWriter(const std::string& folder, SequenceLayout layout, const RgbdCamera& camera,
                 double latency_s);

  // All but the images: the lists and the poses.
  void WriteLists(const Trajectory& world_from_camera) const;
  // truth_camera.yaml and truth_color.txt.
  void WriteTruth(const Trajectory& world_from_camera, const SequenceTruth& truth) const;
  // All images of another folder of the layout are here as well, as links. Returns their number.
  int LinkImages(const std::string& folder) const;
  // The images of frame i; different frames may be written at the same time.
  void WriteFrame(int i, double stamp_s, const Image<Rgb8>& color,
                  const Image<float>& depth_m) const;

 private:
  double StampOf(int i, double stamp_s) const;
  double ImageStamp(double stamp_s) const { return stamp_s + latency_s_; }
  std::string NameOf(int i, double stamp_s) const;

  std::string folder_;
  SequenceLayout layout_;
  RgbdCamera camera_;
  double latency_s_;
};

}  // namespace surfit::tools
