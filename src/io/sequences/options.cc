#include "surfit/core/options.h"

#include <cstdio>
#include <sstream>

#include "core/shared_options.h"
#include "io/sequences/folder.h"
#include "surfit/core/error.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

std::vector<std::string> Formats() {
  std::vector<std::string> formats = SequenceFormats();
  formats.insert(formats.begin(), "auto");
  return formats;
}

// Both topics of a ROS bag as one text.
class TopicsText final : public OptionText {
 public:
  explicit TopicsText(SequenceOptions* options) : o_(*options) {}
  std::string Get() const override {
    return o_.depth_topic + (o_.color_topic.empty() ? "" : "," + o_.color_topic);
  }
  void Set(const std::string& text) override {
    const std::size_t comma = text.find(',');
    const bool has_color = comma != std::string::npos;
    ThrowIf(has_color && text.find(',', comma + 1) != std::string::npos, "DEPTH,COLOR");
    o_.depth_topic = text.substr(0, comma);
    o_.color_topic = has_color ? text.substr(comma + 1) : "";
  }
  const std::type_info& type() const override { return typeid(TopicsText); }
  void* field() override { return &o_; }

 private:
  SequenceOptions& o_;
};

// The mode of a live camera as one text.
class DeviceText final : public OptionText {
 public:
  explicit DeviceText(SequenceOptions* options) : o_(*options) {}
  std::string Get() const override {
    return Concat(o_.device_width, "x", o_.device_height, "@", o_.device_fps,
                  o_.device_registration ? "" : ",unregistered",
                  o_.device_lock_exposure ? ",lock_exposure" : "");
  }
  void Set(const std::string& text) override {
    o_.device_registration = true;
    o_.device_lock_exposure = false;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');) {
      if (part == "unregistered") {
        o_.device_registration = false;
      } else if (part == "lock_exposure") {
        o_.device_lock_exposure = true;
      } else {
        SetMode(part);
      }
    }
  }
  const std::type_info& type() const override { return typeid(DeviceText); }
  void* field() override { return &o_; }

 private:
  void SetMode(const std::string& mode) {
    int end = 0;
    const int numbers = std::sscanf(mode.c_str(), "%5dx%5d@%4d%n", &o_.device_width,
                                    &o_.device_height, &o_.device_fps, &end);
    ThrowIf(numbers != 3 || end != static_cast<int>(mode.size()),
            "WIDTHxHEIGHT@FPS, unregistered or lock_exposure, separated by commas");
  }

  SequenceOptions& o_;
};

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
  ThrowIf(!(rotation.norm() > 1e-6), "a transform with a nonzero quaternion");
  *pose = Rigid3d(rotation.normalized(), {n[0], n[1], n[2]});
}

void SequenceOptions::Visit(OptionVisitor& v) {
  v.Group("sequence");
  v.Add(path, SharedOption("sequence", InField("path"), Required(), Everyday()));
  v.Add(format, "format",
        "sequence format; watch: folder that is being filled; openni2: live camera",
        OneOf(Formats()), Everyday());
  v.Add(camera, "camera",
        "camera.yaml, or preset of a data set (tum_fr1, tum_fr2, tum_fr3, icl_nuim, seven_scenes, "
        "redwood, replica, klg) or a sensor (kinect_v1, xtion, kinect_v2, azure_kinect, "
        "realsense_d415, realsense_d435, realsense_d455); empty: camera.yaml of the sequence, else "
        "the camera in the recording, else the default of the format",
        Everyday());
  v.Add(intrinsics, "intrinsics", "fx,fy,cx,cy of the depth camera", InUnit("px"), AsFlag());
  v.Add(distortion, "distortion", "k1,k2,p1,p2,k3 of the depth camera");
  v.Add(depth_units_per_metre, "depth_units_per_metre", "depth image counts per metre",
        AsFlag("depth_scale"));
  v.Add(inverse_depth_sigma, SharedOption("inverse_depth_sigma"));
  v.Add(color_intrinsics, "color_intrinsics", "fx,fy,cx,cy of a separate colour camera",
        InUnit("px"));
  v.Add(color_distortion, "color_distortion", "k1,k2,p1,p2,k3 of a separate colour camera");
  v.Add(color_from_depth, "color_from_depth",
        "transform tx,ty,tz,qx,qy,qz,qw from the depth camera to the colour camera", InUnit("m"));
  v.Add(frames_per_second, "frames_per_second",
        "frames per second of sequences without timestamps");
  v.Add(latency_s, "latency_s", "latency_s of camera.yaml", Between(-1, 1));
  v.Add(color_latency_s, "color_latency_s", "color_latency_s of camera.yaml", Between(-1, 1));
  v.Add(readout_s, "readout_s", "readout_s of camera.yaml", Between(0, 1));
  v.Add(confidence, "confidence",
        "use the confidence images of a folder (confidence/ or confidence.txt): depth of low "
        "confidence (0 of 0 to 2, or below 85 of 0 to 255) is missing",
        AsFlag());
  v.Add(imu, "imu",
        "use the inertial sensor of a recording: imu.csv, imu0/data.csv, accelerometer.txt, or Imu "
        "topics",
        AsFlag());
  TopicsText topics(this);
  v.AddText(topics, Option("topics",
                           "DEPTH,COLOR: image topics of a ROS bag; COLOR none: no colour; empty: "
                           "the only topic of a kind",
                           AsFlag()));
  v.Add(depth_topic, "depth_topic", "depth image topic of a ROS bag; empty: the only depth topic");
  v.Add(color_topic, "color_topic",
        "colour image topic of a ROS bag; none: no colour; empty: the only colour topic, if any");
  DeviceText device(this);
  v.AddText(device,
            Option("device",
                   "mode of a live camera: WIDTHxHEIGHT@FPS; ,unregistered: depth is not "
                   "registered to colour (also for .oni); ,lock_exposure: lock exposure and white "
                   "balance after 60 images",
                   AsFlag()));
  v.Add(device_width, "device_width", "image width of a live camera", InUnit("px"), AtLeast(1));
  v.Add(device_height, "device_height", "image height of a live camera", InUnit("px"), AtLeast(1));
  v.Add(device_fps, "device_fps", "frames per second of a live camera", AtLeast(1));
  v.Add(device_registration, "device_registration",
        "register depth to colour in the live camera; .oni: the recording has registered depth");
  v.Add(device_lock_exposure, "device_lock_exposure",
        "lock exposure and white balance of a live camera after 60 images");
  v.Add(openni2_library, "openni2_library",
        "OpenNI2 library to load, for example the library of a vendor with its drivers");
  v.Add(first, "first", "index of the first frame to read", AtLeast(0), Everyday());
  v.Add(last, "last", "index of the last frame to read, inclusive; -1: all frames", AtLeast(-1),
        Everyday());
  v.Add(stride, "stride", "read every n-th frame", AtLeast(1), Everyday());
  v.AddPart(rectify, "rectify", "preparation of frames from images");
  v.Check([this] {
    if (last == -1 || last >= first) return;
    throw InputError("last is ", last, ", must be -1 or at least first (", first, ")");
  });
}

}  // namespace surfit
