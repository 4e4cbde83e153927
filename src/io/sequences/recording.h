#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/images/image_files.h"
#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"

namespace surfit {

// Timestamps of the images of one frame, s, as recorded, except in CaptureTimes(). Both are equal
// without colour.
struct FrameStamps {
  double depth_s = 0;
  double color_s = 0;
};

// Maximum time between colour and depth of one frame.
constexpr double kMaxBetweenImages_s = 0.02;

// Statistics of the removal of depth with low confidence.
struct LowConfidence {
  int range = 0;            // largest confidence value of the recording; 0: no confidence image
  std::int64_t depths = 0;  // pixels with depth before the removal
  std::int64_t removed = 0;
};

// Images of one frame, without depth of low confidence.
struct FrameImages {
  RawDepth depth;
  Image<Rgb8> color;       // empty: no colour
  std::string depth_name;  // file and position in the file, for messages
  std::string color_name;
  LowConfidence low_confidence = {};
};

// Frames of a sequence in a folder of images or in one file. Not thread-safe. Indices are 0 to
// frame_count() - 1.
class Recording {
 public:
  virtual ~Recording() = default;
  virtual int frame_count() const = 0;
  virtual FrameStamps stamps(int index) const = 0;
  // Throws InputError naming the file or the frame that cannot be read.
  virtual FrameImages Read(int index) const = 0;
};

// Camera of a recording or device, and the source of its parameters.
struct SourceCamera {
  RgbdCamera camera;
  std::string from;
  bool is_guessed = false;      // default of the format
  bool scale_is_given = false;  // a file has the depth scale
};

// Returns the camera that a recording or device contains, or throws InputError. Empty function: it
// contains none.
using CameraReader = std::function<SourceCamera()>;

// Recording with the properties for SequenceInfo.
struct OpenedRecording {
  std::unique_ptr<Recording> frames;
  Trajectory ground_truth;               // in the convention of the files
  bool has_clock = false;                // SequenceInfo::has_clock; false for .sens
  std::vector<std::string> warnings;     // SequenceInfo::warnings
  int unpaired_images = 0;               // number of images that belong to no frame
  CameraReader read_camera = {};         // valid as long as `frames`
  Trajectory device_poses = {};          // ReadDevicePoses()
  std::string device_pose_warning = {};  // number of invalid poses; empty: none
};

struct FrameFiles {
  FrameStamps stamps;
  std::string depth_path;
  std::string color_path;            // empty: no colour
  std::string confidence_path = {};  // empty: no confidence image
  int confidence_range = 0;          // ConfidenceRange()
};

// File with its timestamp.
struct StampedFile {
  double stamp_s = 0;
  std::string path;
};

// Reads a list of timestamps and files, such as depth.txt. Each part of FindClockStarts() is in
// ascending order of time. Adds a warning for timestamps in another unit than s. Throws InputError
// that names the file and the line.
std::vector<StampedFile> ReadStampedFiles(const std::string& folder, const std::string& name,
                                          std::vector<std::string>* warnings);

// Files of a folder of images. The images are not opened.
struct SequenceFiles {
  std::vector<FrameFiles> frames;
  Trajectory ground_truth;                 // in the convention of the files
  bool has_clock = false;                  // SequenceInfo::has_clock
  int unpaired_images = 0;                 // OpenedRecording::unpaired_images
  std::vector<std::string> warnings = {};  // SequenceInfo::warnings
};

// The List functions throw InputError naming the file and line that is missing or malformed. A pose
// that is not finite or not rigid is left out and counted in a warning.

// Lists a TUM folder: associations.txt, otherwise rgb.txt and depth.txt paired by time. Without
// rgb.txt, frames have no colour. Frames of associations.txt and frames without colour are sorted
// by the depth timestamp, paired frames by the colour timestamp. If the clock starts again in the
// lists, each part is sorted. Ground truth is in groundtruth.txt or *.gt.freiburg.
SequenceFiles ListTumSequence(const std::string& folder);

// Lists an ICL-NUIM folder, like ListTumSequence() if it has associations.txt or depth.txt.
// Otherwise the frames are rgb/N.png and depth/N.png. Their timestamps are N, as in the ground
// truth (*.gt.freiburg).
SequenceFiles ListIclNuimSequence(const std::string& folder);

// Lists a 7-Scenes folder: frame-N.depth.png, frame-N.color.png or frame-N.color.jpg, and
// frame-N.pose.txt. Timestamps are N / frames_per_second.
SequenceFiles ListSevenScenesSequence(const std::string& folder, double frames_per_second);

// Lists a Redwood folder: numbered images in depth/, and in the folder of FindColorFolder(). Poses
// are in trajectory.log. FramesOfPoses() assigns them to frames. Timestamps are (number - first
// number) / frames_per_second.
//
// If all file names in depth/ are times (1763820000.134.png, or integers in ms, us or ns), these
// are the timestamps. The number of a frame is then its position, from 0. Colour is paired by time,
// and poses are in groundtruth.txt or trajectory.log. If names have a number and a time
// (0000012-000000366699.png), images are paired by number. They are paired by time if images of one
// number are from different times.
SequenceFiles ListRedwoodSequence(const std::string& folder, double frames_per_second);

// Camera of transforms.json. If depth images have another size with the same aspect ratio as colour
// images, the depth camera has their size, and colour is not registered. Throws InputError with the
// path.
SourceCamera ReadNerfstudioCamera(const std::string& folder);

// Lists a Replica folder as rendered for NICE-SLAM: results/frameN.jpg and results/depthN.png, with
// six digits, and the pose of a frame in a line of traj.txt, see FramesOfPoses(). Timestamps are N
// / frames_per_second.
SequenceFiles ListReplicaSequence(const std::string& folder, double frames_per_second);

// Pairs the images of two folders by the numbers in their names, in ascending order. Both
// timestamps are the number. A missing image is listed with its expected name, which the read error
// reports. Empty color_folder: no colour. Empty without images. Throws InputError if two images of
// a folder have the same number.
std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder);

// Calls `twice` with a message instead of throwing if two images have the same number. The image
// with the shorter name is used.
using DuplicateCallback = std::function<void(const std::string&)>;
std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder,
                                           const DuplicateCallback& twice);

// Returns the path of color/, rgb/, image/ or images/ in `folder`, or "" without such a folder.
std::string FindColorFolder(const std::string& folder);

// Opens a .klg file of ElasticFusion or its Logger. Format, little endian:
//   int32 number of frames, then per frame:
//   int64 timestamp, us
//   int32 size of depth in bytes, int32 size of colour in bytes (0: no colour)
//   depth: raw 16-bit counts if the size matches, otherwise compressed by zlib
//   colour: raw RGB if the size matches, otherwise JPEG or PNG
// The file does not contain the image size. It is taken from the first JPEG, otherwise from `size`
// (0 x 0: unknown). A truncated file, and a file with more frames than its count, give all complete
// frames and a warning. Timestamps in ms or ns (DetectTimeUnit()) are converted, with a warning.
// Throws InputError naming the file if it cannot be read or if the image size is unknown.
OpenedRecording OpenKlg(const std::string& path, ImageSize size);

// Opens a .sens file of ScanNet (SensorData, version 4). Each frame has:
//   4 x 4 floats, camera-to-world (not finite: no pose)
//   uint64 timestamps of colour and of depth, us
//   uint64 sizes of colour and of depth in bytes
//   colour, depth
// If the timestamps of one stream are not ascending, for example all 0, the timestamps of the other
// stream are used. A stream with several parts (FindClockStarts()) is used. If neither are
// ascending, timestamps are index / frames_per_second. Inertial data after the frames is ignored. A
// truncated file gives its complete frames and a warning. Throws InputError naming the file and the
// error.
OpenedRecording OpenSens(const std::string& path, double frames_per_second);

// Camera of the file header. Throws like OpenSens().
RgbdCamera ReadSensCamera(const std::string& path);

// Opens a ROS bag of this format, or a folder of bags. Depth and colour messages are paired by
// their timestamps, within kMaxBetweenImages_s. Throws InputError naming the file, and the topic or
// option at fault. If no message of a topic has a timestamp, recording times are used, with a
// warning.
OpenedRecording OpenBag(const SequenceOptions& options, const std::string& format, bool is_folder);

// Opens a recording of an Azure Kinect (.mkv of k4arecorder): the tracks DEPTH (16-bit grey, mm)
// and COLOR (MJPG or BGRA), paired by their timestamps within kMaxBetweenImages_s. With the
// attachment calibration.json, images are undistorted, and the camera is the camera of the
// undistorted images. Without it, the options must set the cameras. A truncated file gives its
// complete frames and a warning. Throws InputError naming the file.
OpenedRecording OpenAzureKinect(const SequenceOptions& options);

// Opens an OpenNI2 recording, and plays it once. Recording::Read() is fast for ascending frames
// only. The intrinsics are computed from the field of view. Throws InputError naming the file, also
// in a build without OpenNI2.
OpenedRecording OpenOni(const SequenceOptions& options);

}  // namespace surfit
