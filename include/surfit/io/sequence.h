#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/inertial.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

class OptionVisitor;

// Options of an RGB-D sequence: its location, its camera and the selection of frames.
struct SequenceOptions {
  std::string path;  // folder or file of the sequence; for openni2 a device URI or "any"
  // Format of a recording: auto, tum, icl_nuim, seven_scenes, redwood, replica, nerfstudio,
  // stray_scanner, arkit_scenes, polycam, record3d, klg, sens, bag, db3, mcap, oni. Format of a
  // live source, for OpenLive(): watch, openni2.
  std::string format = "auto";

  // Name of a preset (CameraPreset()), or path of a camera file *.yaml. If empty, the search order
  // is:
  //   1. camera.yaml in the folder, or F.yaml for a file F such as a.klg
  //   2. the recording. tum: the name freiburg1, 2 or 3 in the head of rgb.txt or depth.txt.
  //     redwood, watch: camera_intrinsic.json, intrinsic.json or transforms.json. replica:
  //     cam_params.json. nerfstudio: transforms.json. seven_scenes: _info.txt. stray_scanner:
  //     odometry.csv or camera_matrix.csv. arkit_scenes: *.pincam. polycam: cameras/*.json.
  //     record3d: metadata.json. sens: the file header. bag, db3, mcap: CameraInfo and tf. oni,
  //     openni2: the field of view.
  //   3. the default camera of the format
  std::string camera;

  // Overrides of single values of this camera. With `intrinsics` or `color_intrinsics`, the image
  // size is taken from the images. `color_intrinsics` makes the colour camera a separate camera.
  // The other two colour options require a separate colour camera.
  std::optional<std::array<double, 4>> intrinsics;        // depth camera: fx fy cx cy, px
  std::optional<std::array<double, 5>> distortion;        // depth camera: k1 k2 p1 p2 k3
  std::optional<double> depth_units_per_metre;            // replaces a disparity
  std::optional<double> inverse_depth_sigma;              // 1/m: DepthNoise
  std::optional<std::array<double, 4>> color_intrinsics;  // fx fy cx cy, px
  std::optional<std::array<double, 5>> color_distortion;  // k1 k2 p1 p2 k3
  std::optional<Rigid3d> color_from_depth;
  std::optional<double> frames_per_second;  // for files without timestamps
  std::optional<double> latency_s;          // see RgbdCamera; 0 without timestamps of a clock
  std::optional<double> color_latency_s;    // see RgbdCamera
  std::optional<double> readout_s;          // see RgbdCamera

  // Uses the confidence images of a folder: depth of low confidence is missing. They are in
  // confidence/ with the numbers or timestamps of depth/ in their names, or listed in
  // confidence.txt, and have one channel of 8 bits. If no value of the first images is above 2, the
  // values are 0 (low), 1 (medium) and 2 (high), as ARKit has them. Otherwise they are 0 to 255, as
  // time-of-flight cameras have them, and values below 85 are low. A frame without a confidence
  // image keeps all depth, and a warning has the number of such frames.
  bool confidence = true;

  // Uses the inertial sensor of a recording, see ReadImu().
  bool imu = true;

  // Topics of depth and colour in a ROS bag (bag, db3, mcap). Empty: the only topic. Colour "none":
  // no colour.
  std::string depth_topic, color_topic;

  // Stream mode of a camera (openni2): must be a mode of the device.
  int device_width = 640, device_height = 480;  // px
  int device_fps = 30;
  // Camera: the device registers depth to colour. Recording (oni): depth was registered to colour.
  bool device_registration = true;
  // Locks exposure and white balance after 60 colour images.
  bool device_lock_exposure = false;
  // Library for openni2 and oni, as for dlopen(). Its drivers are beside it.
  std::string openni2_library = "libOpenNI2.so.0";

  int first = 0;  // index of the first frame, from 0, before `stride`
  int last = -1;  // index of the last frame, inclusive; -1 or beyond the end: the last frame of the
                  // sequence
  int stride = 1;  // read every stride-th frame

  RectifyOptions rectify;

  void Visit(OptionVisitor& visitor);
};

// Returns "the camera NAME" or "the sequence's own camera", for messages.
std::string NameOfCamera(const SequenceOptions& options);

// Opens a recording: a folder of images or a file. The time of a frame (RgbdFrame::stamp_s) refers
// to its depth image:
// - TUM folders, .klg, .sens, .oni, ROS bags (header.stamp), phones, and names with times: the
//   timestamp in s minus the latency of the camera
// - ICL-NUIM: the frame number, as in *.gt.freiburg
// - other images with a number N: N / frames_per_second, relative to the first N for redwood and
//   nerfstudio
//
// Formats of phones and nerfstudio have intrinsics for each frame. If these change, images are
// resampled to the median intrinsics. Poses by the phone are no ground truth, and are not returned.
//
// Frames are mirrored if fy < 0, see SequenceInfo. A frame that cannot be read later is a
// ReadResult with an error. Throws InputError that names the folder, file or option. The format
// must not be live, a frame must be readable, and the first readable frame must have the size of
// the camera.
std::unique_ptr<FrameSource> OpenSequence(const SequenceOptions& options);

// Reads the depth correction of a sequence: `inverse_depth_field` of its camera file, see
// SequenceOptions::camera. `format` is SequenceInfo::format. Returns the zero field for a preset
// and for a sequence without camera file. OpenSequence() and OpenLive() apply the correction to
// their frames. The field belongs to these frames, which are mirrored if fy < 0 in the file. Throws
// InputError that names the file and the key.
InverseDepthField ReadDepthField(const SequenceOptions& options, const std::string& format);

// Reads the inertial sensor of a recording. Returns std::nullopt without one, for live sources, and
// if SequenceOptions::imu is false. `format` is SequenceInfo::format. Sources:
// - folder, in this order: imu.csv, imu/data.csv, imu0/data.csv, accelerometer.txt
// - bag, db3, mcap: topics of the type sensor_msgs/Imu. Two topics must have "gyro" and "accel" in
//   their names; the accelerometer is then interpolated at the times of the gyroscope.
// The first line of a csv file selects its form:
// - "timestamp, a_x, ...": Stray Scanner, with times in s, accelerometer, gyroscope. The
//   accelerometer is the negative of the specific force. The mounting in an iPhone is known.
// - "#timestamp [ns],w_RS_S_x ...": EuRoC, with times in ns, gyroscope, accelerometer.
// accelerometer.txt has the form of TUM: time in s, accelerometer. It has no gyroscope.
//
// The calibration is that of the format, replaced by the key `imu` of the camera file
// (ReadImuCalibration()). An unknown mounting has an infinite rotation_sigma_rad. Samples that are
// not later than the sample before are dropped and counted. Without samples, logs a warning and
// returns std::nullopt. Throws InputError that names file and line, or the topics.
std::optional<ImuRecording> ReadImu(const SequenceOptions& options, const std::string& format);

// Returns whether the format is live: OpenLive() is required instead of OpenSequence().
bool IsLive(const SequenceOptions& options);

// Opens a live source: a folder that is being filled (watch, see WatchFolder()) or a camera
// (openni2). Throws InputError that names the device or option, and unless `capacity` is at least
// 1. `stop` must outlive the source.
//
// For a camera, `options.path` is its OpenNI2 URI, or "any" for the first device. Without other
// calibration, the intrinsics follow from the field of view. Depth and colour are paired by their
// device timestamps, in s. A frame without colour is a ReadResult with an error.
//
// A queue keeps the newest `capacity` frames of a camera; watch has no queue. Older frames are
// dropped, logged and counted. While the camera is unplugged, Next() waits for it, and later
// timestamps continue after this time (ReadResult::paused_before_s). The sequence ends when `stop`
// becomes true.
std::unique_ptr<FrameSource> OpenLive(const SequenceOptions& options, int capacity,
                                      const std::atomic<bool>& stop);

// Opens a folder that a phone or a recorder is filling. It has numbered PNG images in depth/, and
// numbered PNG or JPEG images in color/, rgb/, image/ or images/ if such a folder exists when the
// first frame arrives. Confidence images are in confidence/, see SequenceOptions::confidence; a
// list of them is not read. Each frame is read as soon as its files are complete. If its confidence
// image is missing for two seconds or at the end, the frame is used without one. Frames come in the
// order of their numbers N, with timestamps N / frames_per_second and the camera of OpenSequence().
//
// The sequence ends when the folder has a file `done` and all frames before it are read, or when
// `stop` becomes true. A frame that is incomplete for two seconds or at the end is a ReadResult
// with an error. A frame that arrives after a later frame was taken is an error as well.
//
// Waits for the first readable frame. Throws InputError that names the option, if the path is not a
// folder, and if the sequence ends without a readable frame. `stop` must outlive the source.
std::unique_ptr<FrameSource> WatchFolder(const SequenceOptions& options,
                                         const std::atomic<bool>& stop);

// Reads up to `capacity` frames ahead in a background task, in the same order. With one thread
// (ThreadLimit), frames are read on demand. An exception of `source` is thrown by Next() at the
// position of its frame, and ends the sequence. The destructor waits for the frame that is being
// read. Throws InputError unless `capacity` is at least 1.
std::unique_ptr<FrameSource> ReadAhead(std::unique_ptr<FrameSource> source, int capacity);

// Replays a recording at a fixed rate, like a live camera. A background task decodes up to 30
// frames before they are due, see ReadAhead(). Frame i is due i / frames_per_second after the first
// frame. Its timestamp has no effect. Next() waits for it.
//
// A queue keeps the newest `capacity` frames that are due. Older frames are dropped, logged, and
// counted in the next ReadResult: the result depends on the speed of the caller. Throws InputError
// unless `frames_per_second` is positive and `capacity` is at least 1.
std::unique_ptr<FrameSource> OfferFrames(std::unique_ptr<FrameSource> source,
                                         double frames_per_second, int capacity);

}  // namespace surfit
