// The options of this room.
#include "surfit/core/options.h"

#include "io/folder.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/klg_writer.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

std::vector<std::string> Formats() {
  std::vector<std::string> formats = SequenceFormats();
  formats.insert(formats.begin(), "auto");
  return formats;
}

}  // namespace

static std::string OptionToText(const std::optional<Rigid3d>& pose) {
  if (!pose) return "";
  const Eigen::Vector3d& t = pose->translation;
  const Eigen::Quaterniond& q = pose->rotation;
  return OptionToText(std::vector<double>{t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
}

static void OptionFromText(const std::string& text, std::optional<Rigid3d>* pose) {
  pose->reset();
  if (text.empty()) return;
  const std::vector<double> n = NumbersFromText(text, 7);
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (!(rotation.norm() > 1e-6)) throw InputError("with a quaternion that is not zero");
  *pose = Rigid3d(rotation.normalized(), {n[0], n[1], n[2]});
}

void SequenceOptions::Visit(OptionVisitor& v) {
  v.Group("sequence");
  v.Add(path, Option("path", "the sequence: a folder, or a .klg or .sens file")
                  .Required()
                  .Flag("sequence")
                  .Everyday());
  v.Add(format, Option("format", "format of the sequence; watch: wait for frames to come")
                    .OneOf(Formats())
                    .Everyday());
  v.Add(camera, Option("camera",
                       "camera preset (tum_fr1, tum_fr2, tum_fr3, icl_nuim, seven_scenes, redwood, "
                       "replica or klg); empty: the sequence's camera.yaml, else what the "
                       "recording tells, else the format's usual camera")
                    .Everyday());
  v.Add(intrinsics, Option("intrinsics", "the depth camera's fx,fy,cx,cy").Unit("px").Flag());
  v.Add(distortion, Option("distortion", "the depth camera's k1,k2,p1,p2,k3").Flag());
  v.Add(
      depth_units_per_metre,
      Option("depth_units_per_metre", "counts of the depth images per metre").Flag("depth_scale"));
  v.Add(inverse_depth_sigma,
        Option("inverse_depth_sigma",
               "noise of the depth sensor: standard deviation of inverse depth")
            .Unit("1/m")
            .Flag());
  v.Add(color_intrinsics,
        Option("color_intrinsics", "fx,fy,cx,cy of a separate colour camera").Unit("px").Flag());
  v.Add(color_distortion,
        Option("color_distortion", "k1,k2,p1,p2,k3 of a separate colour camera").Flag());
  v.Add(color_from_depth,
        Option("color_from_depth", "pose tx,ty,tz,qx,qy,qz,qw of the depth in the colour camera")
            .Unit("m")
            .Flag());
  v.Add(frames_per_second,
        Option("frames_per_second", "frames per second of files without time stamps").Flag("fps"));
  v.Add(latency_s,
        Option("latency_s",
               "how long before its stamp the middle of a depth frame's exposure and readout lies")
            .Unit("s")
            .Flag());
  v.Add(first, Option("first", "index of the first frame to read").AtLeast(0).Everyday());
  v.Add(last, Option("last", "index of the last frame to read, inclusive; -1 = to the end")
                  .AtLeast(-1)
                  .Everyday());
  v.Add(stride, Option("stride", "read every n-th frame").AtLeast(1).Everyday());
  v.AddPart(prepare, Option("prepare", "how images become frames"));
  v.Check([this] {
    if (last == -1 || last >= first) return;
    throw InputError(Concat("last is ", last, ", must be at least first, ", first, ", or -1"));
  });
}

void KlgOptions::Visit(OptionVisitor& v) {
  v.Add(compress_depth, Option("compress_depth", "compress depth in .klg").Flag());
  v.Add(jpeg_quality,
        Option("jpeg_quality", "JPEG quality of colour in .klg").From(0, 100).Zero("raw").Flag());
}

}  // namespace surfit
