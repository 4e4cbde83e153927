#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/inertial.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"

namespace surfit::tools {

// File layout of a written sequence.
enum class SequenceLayout {
  // rgb.txt, depth.txt, associations.txt (colour first). File names are timestamps.
  kTum,
  // associations.txt (depth first), simulated.gt.freiburg. File names and timestamps are frame
  // numbers. The image y axis points up: fy < 0, and poses are S pose S with S = diag(1, -1, 1).
  kIclNuim,
};

// True values, which camera.yaml may not contain.
struct SequenceTruth {
  RgbdCamera camera;        // its latency delays image timestamps
  InverseDepthField field;  // correction of the depth
  double color_readout_s = 0, exposure_s = 0;
  std::vector<double> color_moments_s;  // middle of exposure and readout per frame
  std::vector<Eigen::Vector3f> gains;   // gains of the colour channels per frame
};

// Writes an RGB-D sequence: rgb/, depth/ (16-bit PNG, 0: missing or above the range), camera.yaml,
// groundtruth.txt and the lists of the layout. Sensors with confidence also have confidence/ (8-bit
// PNG) and confidence.txt.
class SequenceWriter {
 public:
  // Creates the folder, or empties the folder of an earlier simulation. `camera` is written to
  // camera.yaml. In both layouts, the arguments of all functions are upright and right-handed. For
  // kIclNuim, the writer mirrors the camera, the poses and the field, but not the images. Image
  // timestamps are later by latency_s, except for kIclNuim. Throws InputError if the folder
  // contains other files. A null `imu` is not in camera.yaml. All functions
  // throw InputError with the name of the folder or file.
  SequenceWriter(const std::string& folder, SequenceLayout layout, const RgbdCamera& camera,
                 double latency_s, bool has_confidence, const ImuCalibration* imu = nullptr);

  // Writes the lists and the ground truth, with one pose per frame. Independent of WriteFrame().
  void WriteLists(const Trajectory& world_from_camera) const;
  // Writes truth_camera.yaml and truth_color.txt. The vectors of `truth` have one entry per pose.
  void WriteTruth(const Trajectory& world_from_camera, const SequenceTruth& truth) const;
  // Writes inertial measurements to the file `name`, in the form of EuRoC.
  void WriteImu(const std::string& name, const std::vector<ImuSample>& samples) const;
  // Hard-links all images of another folder with the same layout into this folder. Returns their
  // number.
  int LinkImages(const std::string& folder) const;
  // Number of images per frame.
  int ImagesPerFrame() const { return static_cast<int>(Kinds().size()); }
  // Writes the images of frame i. Calls for different frames may run in parallel. Requires a
  // confidence image if the sensor has confidence.
  void WriteFrame(int i, double stamp_s, const Image<Rgb8>& color, const Image<float>& depth_m,
                  const Image<std::uint8_t>& confidence) const;

 private:
  double StampOf(int i, double stamp_s) const;
  double ImageStamp(double stamp_s) const { return stamp_s + latency_s_; }
  std::string NameOf(int i, double stamp_s) const;
  std::vector<std::string> Kinds() const;  // names of the folders of images

  std::string folder_;
  SequenceLayout layout_;
  RgbdCamera camera_;
  double latency_s_;
  bool has_confidence_;
};

}  // namespace surfit::tools
