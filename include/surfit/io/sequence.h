#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "surfit/frame/frame_source.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

class OptionVisitor;

// Which frames of which sequence to read, and with what camera.
struct SequenceOptions {
  std::string path;  // the sequence's folder, or file
  // auto, tum, icl_nuim, seven_scenes, redwood, replica, klg, sens, bag, db3, mcap, oni, or one of
  // those whose frames are still to come (OpenLive()): watch, openni2.
  std::string format = "auto";

  // A preset's name (see CameraPreset()), or a camera.yaml by its path. If empty: the folder's
  // camera.yaml (of a file F.klg: F.klg.yaml), else what the recording tells (tum: the head of
  // rgb.txt or depth.txt, which names freiburg1, 2 or 3; redwood: camera_intrinsic.json or
  // intrinsic.json; replica: cam_params.json; sens: its header; bag, db3, mcap: CameraInfo and tf),
  // else the format's usual camera.
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
  std::optional<double> latency_s;          // RgbdCamera; for files with stamps of a clock only
  std::optional<double> color_latency_s;    // RgbdCamera
  std::optional<double> readout_s;          // RgbdCamera

  // Of a ROS bag (bag, db3, mcap): the topics of depth and of colour. Empty: the only ones; "none":
  // no colour.
  std::string depth_topic, color_topic;

  // Of a camera (openni2): what it is to send, which must be one of its modes.
  int device_width = 640, device_height = 480;  // px
  int device_fps = 30;
  // The camera registers depth to colour; of a recording (oni): it did.
  bool device_registration = true;
  // Exposure and white balance are locked at what they are after 60 images of colour.
  bool device_lock_exposure = false;
  // Of openni2 and oni: the library, as for dlopen(), with the drivers that it has beside it.
  std::string openni2_library = "libOpenNI2.so.0";

  int first = 0;   // index of the first frame, from 0 over all that the folder lists
  int last = -1;   // index of the last frame, inclusive; -1, or beyond the end: to the end
  int stride = 1;  // read every stride-th frame

  PrepareOptions prepare;

  void Visit(OptionVisitor& visitor);
};

// "the camera NAME", or "the sequence's own camera".
std::string NameOfCamera(const SequenceOptions& options);

// Opens a folder of images, or a recording in one file, as a sequence. Stamps are of depth: those
// of TUM folders, .klg and .sens files and ROS bags (header.stamp), in seconds, less the camera's
// latency; frame numbers in ICL-NUIM's (as in *.gt.freiburg), index / frames_per_second where files
// have none. Frames are mirrored where fy < 0, see SequenceInfo. Throws InputError naming the
// folder, file or option at fault; also if not one frame can be read, or the first readable one has
// another size than the camera. Frames that cannot be read later are ReadResults with an error.
std::unique_ptr<FrameSource> OpenSequence(const SequenceOptions& options);

// The correction of depth that a sequence of this format comes with: the inverse_depth_field of its
// camera.yaml (of a file F.klg: F.klg.yaml) or of the one that options.camera names, zero where
// that has none or options.camera names a preset. OpenSequence() and OpenLive() apply it to
// every frame; it holds for frames as they give them, mirrored if the file's image y axis points
// up. Throws InputError naming file and key.
InverseDepthField ReadDepthField(const SequenceOptions& options, const std::string& format);

// Whether the frames of this format are still to come, so that OpenLive() takes the place of
// OpenSequence().
bool IsLive(const SequenceOptions& options);

// Frames of a folder that is being filled (watch; WatchFolder()) or of a camera (openni2). Of a
// camera options.path is the URI by which OpenNI2 knows it, or "any": the first that is there. Its
// camera is by its field of view if nothing else tells it. Depth and colour are paired by their
// stamps, which are the device's, in seconds. A frame without colour is a ReadResult with an error.
// A queue keeps the newest `capacity` frames that were not taken yet; older ones are dropped,
// logged and counted. While the camera is unplugged Next() waits for it; later stamps go on by the
// time that has passed (ReadResult::paused_before_s). Ends when `stop` becomes true, which must
// outlive the source. Throws InputError naming the device or option at fault.
std::unique_ptr<FrameSource> OpenLive(const SequenceOptions& options, int capacity,
                                      const std::atomic<bool>& stop);

// The frames of a folder that is being filled (by a phone or a recorder), each as soon as its files
// are complete: numbered PNG images in depth/, and numbered PNG or JPEG images in color/, rgb/ or
// image/ if that folder exists when the first frame arrives. Frames come in the order of their
// numbers N, with stamps N / frames_per_second and the camera of OpenSequence().
//
// Ends when the folder holds a file `done` and all frames before it are read, or when `stop`
// becomes true. A frame that is still incomplete after two seconds, or at the end, is a ReadResult
// with an error; so is a frame that arrives after a later one was taken.
//
// Waits for the first readable frame. Throws InputError naming the option at fault, or if there is
// no such frame before the end.
std::unique_ptr<FrameSource> WatchFolder(const SequenceOptions& options,
                                         const std::atomic<bool>& stop);

// The same frames in the same order, read by a background task while the caller works, up to
// `capacity` of them ahead. With one thread (ThreadLimit) they are read when asked for. An
// exception of the source is thrown by Next() in its turn, and then the sequence is over.
// Throws InputError unless capacity is at least 1.
std::unique_ptr<FrameSource> ReadAhead(std::unique_ptr<FrameSource> source, int capacity);

// Offers the frames of a recording at a fixed rate, as a live camera does. All frames are read by
// the first call of Next(), so that decoding costs no time later; a frame takes 7 bytes a pixel.
// Frame i is offered i / frames_per_second after the first, whatever its stamp says, and Next()
// waits for it. A queue keeps the newest `capacity` frames that were offered and not yet taken.
// Older ones are dropped, logged, and counted in the next ReadResult. Which frames are dropped
// depends on how fast they are taken; if none is, they are the source's, in order. Throws
// InputError unless frames_per_second is positive and capacity at least 1.
std::unique_ptr<FrameSource> OfferFrames(std::unique_ptr<FrameSource> source,
                                         double frames_per_second, int capacity);

}  // namespace surfit
