#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "surfit/frame/prepare_frame.h"
#include "surfit/io/frame_source.h"

namespace surfit {

class OptionVisitor;

// Which frames of which sequence to read, and with what camera.
struct SequenceOptions {
  std::string path;  // the sequence's folder, or file
  // auto, tum, icl_nuim, seven_scenes, redwood, replica, klg, sens, or watch (RunSlam() only).
  std::string format = "auto";

  // A preset's name (see camera_presets.h). If empty: the folder's camera.yaml (of a file
  // F.klg: F.klg.yaml), else what the recording tells (redwood: camera_intrinsic.json or
  // intrinsic.json; replica: cam_params.json; sens: its header), else the format's usual camera.
  std::string camera;

  // What takes the place of that camera's figures. After intrinsics from here, the image size is
  // the images'. Any of the three of the colour camera makes it a camera of its own, which needs
  // color_intrinsics unless it is one already.
  std::optional<std::array<double, 4>> intrinsics;  // depth: fx fy cx cy, px
  std::optional<std::array<double, 5>> distortion;  // depth: k1 k2 p1 p2 k3
  std::optional<double> depth_units_per_metre;
  std::optional<double> inverse_depth_sigma;              // 1/m: DepthNoise
  std::optional<std::array<double, 4>> color_intrinsics;  // fx fy cx cy, px
  std::optional<std::array<double, 5>> color_distortion;  // k1 k2 p1 p2 k3
  std::optional<Rigid3d> color_from_depth;
  std::optional<double> frames_per_second;  // stamps of files that have none

  int first = 0;   // index of the first frame, from 0 over all that the folder lists
  int last = -1;   // index of the last frame, inclusive; -1, or beyond the end: to the end
  int stride = 1;  // read every stride-th frame

  PrepareOptions prepare;

  void Visit(OptionVisitor& visitor);
};

// Opens a folder of images, or a recording in one file, as a sequence. Stamps are the source's own:
// seconds in TUM folders, and in .klg and .sens files, frame numbers in ICL-NUIM's (as in
// *.gt.freiburg), index / frames_per_second where files have none. Frames are mirrored where fy <
// 0, see SequenceInfo. Throws InputError naming the folder, file or option at fault; also if not
// one frame can be read, or the first readable one has another size than the camera. Frames that
// cannot be read later are ReadResults with an error.
std::unique_ptr<FrameSource> OpenSequence(const SequenceOptions& options);

}  // namespace surfit
