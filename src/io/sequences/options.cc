// The options of this module.
#include "surfit/core/options.h"

#include "core/shared_options.h"
#include "io/sequences/folder.h"
#include "io/sequences/klg_writer.h"
#include "surfit/core/error.h"
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
  ThrowIf(!(rotation.norm() > 1e-6), "with a quaternion that is not zero");
  *pose = Rigid3d(rotation.normalized(), {n[0], n[1], n[2]});
}

void SequenceOptions::Visit(OptionVisitor& v) {
  v.Group("sequence");
  v.Add(path, SharedOption("sequence", InField("path"), Required(), Everyday()));
  v.Add(format, "format",
        "format of the sequence; watch: wait for frames to come; openni2: a camera",
        OneOf(Formats()), Everyday());
  v.Add(camera, "camera",
        "camera preset, of a data set (tum_fr1, tum_fr2, tum_fr3, icl_nuim, seven_scenes, redwood, "
        "replica, klg) or a sensor (kinect_v1, xtion, kinect_v2, azure_kinect, realsense_d415, "
        "realsense_d435, realsense_d455), or a camera.yaml; empty: the sequence's camera.yaml, "
        "else what the recording tells, else the format's "
        "usual camera",
        Everyday());
  v.Add(intrinsics, "intrinsics", "the depth camera's fx,fy,cx,cy", InUnit("px"), AsFlag());
  v.Add(distortion, "distortion", "the depth camera's k1,k2,p1,p2,k3", AsFlag());
  v.Add(depth_units_per_metre, "depth_units_per_metre", "counts of the depth images per metre",
        AsFlag("depth_scale"));
  v.Add(inverse_depth_sigma, SharedOption("inverse_depth_sigma"));
  v.Add(color_intrinsics, "color_intrinsics", "fx,fy,cx,cy of a separate colour camera",
        InUnit("px"), AsFlag());
  v.Add(color_distortion, "color_distortion", "k1,k2,p1,p2,k3 of a separate colour camera",
        AsFlag());
  v.Add(color_from_depth, "color_from_depth",
        "pose tx,ty,tz,qx,qy,qz,qw of the depth in the colour camera", InUnit("m"), AsFlag());
  v.Add(frames_per_second, "frames_per_second", "frames per second of files without time stamps",
        AsFlag("fps"));
  v.Add(latency_s, SharedOption("latency_s"));
  v.Add(color_latency_s, SharedOption("color_latency_s"));
  v.Add(readout_s, SharedOption("readout_s"));
  v.Add(depth_topic, "depth_topic", "of a ROS bag: the topic of depth images; empty: the only one",
        AsFlag());
  v.Add(color_topic, "color_topic",
        "of a ROS bag: the topic of colour images, or none; empty: the only one, if any", AsFlag());
  v.Add(device_width, "device_width", "of a camera: width of its images", InUnit("px"), AtLeast(1),
        AsFlag());
  v.Add(device_height, "device_height", "of a camera: height of its images", InUnit("px"),
        AtLeast(1), AsFlag());
  v.Add(device_fps, "device_fps", "of a camera: frames per second", AtLeast(1), AsFlag());
  v.Add(device_registration, "device_registration",
        "of a camera: it registers depth to colour; of an .oni recording: it did", AsFlag());
  v.Add(device_lock_exposure, "device_lock_exposure",
        "of a camera: lock exposure and white balance after 60 images", AsFlag());
  v.Add(openni2_library, "openni2_library",
        "the library of OpenNI2 to load, as a vendor's with its drivers", AsFlag());
  v.Add(first, "first", "index of the first frame to read", AtLeast(0), Everyday());
  v.Add(last, "last", "index of the last frame to read, inclusive; -1 = to the end", AtLeast(-1),
        Everyday());
  v.Add(stride, "stride", "read every n-th frame", AtLeast(1), Everyday());
  v.AddPart(prepare, "prepare", "how images become frames");
  v.Check([this] {
    if (last == -1 || last >= first) return;
    throw InputError("last is ", last, ", must be at least first, ", first, ", or -1");
  });
}

void KlgOptions::Visit(OptionVisitor& v) {
  v.Add(compress_depth, "compress_depth", "compress depth in .klg", AsFlag());
  v.Add(jpeg_quality, "jpeg_quality", "JPEG quality of colour in .klg", Between(0, 100),
        ZeroIs("raw"), AsFlag());
}

}  // namespace surfit
