#include "common/sequence_flags.h"

#include <gflags/gflags.h>

#include <array>
#include <optional>
#include <sstream>
#include <string>

#include "surfit/core/error.h"

namespace {

const surfit::SequenceOptions kSequence;

}  // namespace

DEFINE_string(sequence, kSequence.path, "the sequence: a folder, or a .klg or .sens file");
DEFINE_string(format, kSequence.format,
              "auto, tum, icl_nuim, seven_scenes, redwood, replica, klg, sens, or watch: "
              "wait for frames to come (surfit_slam)");
DEFINE_string(
    camera, kSequence.camera,
    "camera preset: tum_fr1, tum_fr2, tum_fr3, icl_nuim, seven_scenes, redwood, "
    "replica or klg; empty: the folder's camera.yaml (F.klg.yaml of a file), else what the "
    "recording tells, else the format's usual camera");
DEFINE_string(intrinsics, "", "depth camera's fx,fy,cx,cy in px");
DEFINE_string(distortion, "", "depth camera's k1,k2,p1,p2,k3");
DEFINE_string(depth_scale, "", "counts of the depth images per metre");
DEFINE_string(color_intrinsics, "", "fx,fy,cx,cy in px of a colour camera of its own");
DEFINE_string(color_distortion, "", "k1,k2,p1,p2,k3 of a colour camera of its own");
DEFINE_string(color_from_depth, "",
              "tx,ty,tz,qx,qy,qz,qw from the depth to the colour camera's frame, metres");
DEFINE_string(fps, "", "frames per second of files without time stamps");
DEFINE_int32(downsample, kSequence.prepare.downsample,
             "keep every downsample-th column and row, 1 to 16");
DEFINE_double(max_depth_m, kSequence.prepare.max_depth_m, "depth beyond is missing");

namespace surfit::tools {
namespace {

// N numbers between commas, or nothing for an empty text.
template <std::size_t N>
std::optional<std::array<double, N>> Numbers(const char* flag, const std::string& text) {
  if (text.empty()) return std::nullopt;
  std::array<double, N> numbers;
  std::istringstream stream(text);
  for (std::size_t i = 0; i < N; ++i) {
    if (i > 0 && stream.get() != ',') stream.setstate(std::ios::failbit);
    stream >> numbers[i];
  }
  if (!stream || stream.peek() != std::char_traits<char>::eof()) {
    throw InputError(Concat(flag, " is '", text, "', must be ", N, N == 1 ? " number" : " numbers",
                            N == 1 ? "" : " with commas between them"));
  }
  return numbers;
}

std::optional<double> Number(const char* flag, const std::string& text) {
  const auto numbers = Numbers<1>(flag, text);
  return numbers ? std::optional<double>((*numbers)[0]) : std::nullopt;
}

std::optional<Rigid3d> Pose(const char* flag, const std::string& text) {
  const auto n = Numbers<7>(flag, text);
  if (!n) return std::nullopt;
  const Eigen::Quaterniond rotation((*n)[6], (*n)[3], (*n)[4], (*n)[5]);
  if (!(rotation.norm() > 1e-6)) {
    throw InputError(Concat(flag, " is '", text, "', must have a quaternion that is not zero"));
  }
  return Rigid3d(rotation.normalized(), {(*n)[0], (*n)[1], (*n)[2]});
}

}  // namespace

SequenceOptions SequenceOptionsFromFlags() {
  SequenceOptions options;
  options.path = FLAGS_sequence;
  options.format = FLAGS_format;
  options.camera = FLAGS_camera;
  options.intrinsics = Numbers<4>("intrinsics", FLAGS_intrinsics);
  options.distortion = Numbers<5>("distortion", FLAGS_distortion);
  options.depth_units_per_metre = Number("depth_scale", FLAGS_depth_scale);
  options.color_intrinsics = Numbers<4>("color_intrinsics", FLAGS_color_intrinsics);
  options.color_distortion = Numbers<5>("color_distortion", FLAGS_color_distortion);
  options.color_from_depth = Pose("color_from_depth", FLAGS_color_from_depth);
  options.frames_per_second = Number("fps", FLAGS_fps);
  options.prepare.downsample = FLAGS_downsample;
  options.prepare.max_depth_m = FLAGS_max_depth_m;
  return options;
}

}  // namespace surfit::tools
