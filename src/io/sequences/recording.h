#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/images/image_files.h"
#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"

namespace surfit {

// When the images of one frame were taken: the same without colour.
struct FrameStamps {
  double depth_s = 0;
  double color_s = 0;
};

// Colour and depth whose stamps differ by more are not of one frame.
constexpr double kMaxBetweenImages_s = 0.02;

// The images of one frame as recorded.
struct FrameImages {
  RawDepth depth;
  Image<Rgb8> color;       // empty where the frame has no colour
  std::string depth_name;  // the file, and the place in it, for messages
  std::string color_name;
};

// The frames of a sequence, in a folder of images or in one file. Not thread-safe.
class Recording {
 public:
  virtual ~Recording() = default;
  virtual int frame_count() const = 0;
  virtual FrameStamps stamps(int index) const = 0;
  // Throws InputError naming what cannot be read.
  virtual FrameImages Read(int index) const = 0;
};

// A camera and where it is from.
struct ToldCamera {
  RgbdCamera camera;
  std::string from;
  bool is_guessed = false;
};

// What a recording or device itself tells of its camera; empty where it tells nothing.
using TellCamera = std::function<ToldCamera()>;

// A recording with its ground truth and warnings.
struct OpenedRecording {
  std::unique_ptr<Recording> frames;
  Trajectory ground_truth;            // as the files have it
  bool has_clock = false;             // SequenceInfo
  std::vector<std::string> warnings;  // what the user should know
  int unpaired_images = 0;            // of depth or colour, without one of the other
  TellCamera tell_camera = {};        // as long as the frames are there
};

// The files of one frame.
struct FrameFiles {
  FrameStamps stamps;
  std::string depth_path;
  std::string color_path;  // empty where the sequence has no colour
};

// What a folder of images holds. Whether the images can be read shows when they are.
struct SequenceFiles {
  std::vector<FrameFiles> frames;
  Trajectory ground_truth;  // as the files have it
  bool has_clock = false;   // SequenceInfo
  int unpaired_images = 0;  // OpenedRecording
};

// Each throws InputError naming the file, and the line, that is missing or malformed.

// associations.txt, or else rgb.txt and depth.txt paired by time (depth.txt alone: no colour), in
// order of depth's stamps. Ground truth from groundtruth.txt or *.gt.freiburg.
SequenceFiles ListTumSequence(const std::string& folder);

// The same, or without such lists rgb/N.png and depth/N.png. Stamps are the frame numbers N, for
// so they stand in *.gt.freiburg.
SequenceFiles ListIclNuimSequence(const std::string& folder);

// frame-N.{color.png|color.jpg, depth.png, pose.txt}; stamps are N / frames_per_second.
SequenceFiles ListSevenScenesSequence(const std::string& folder, double frames_per_second);

// Numbered images in depth/ and color/, rgb/ or image/ (or no colour), poses in trajectory.log;
// stamps are position / frames_per_second, and the log's first number is that position. Where all
// names in depth/ are times in seconds (1763820000.134.png), these are the stamps, colour is paired
// by time, and poses are those of groundtruth.txt.
SequenceFiles ListRedwoodSequence(const std::string& folder, double frames_per_second);

// results/frameN.jpg and results/depthN.png with poses in traj.txt, as rendered for NICE-SLAM;
// stamps are N / frames_per_second, a pose's N is its line.
SequenceFiles ListReplicaSequence(const std::string& folder, double frames_per_second);

// Pairs the images of two folders by the numbers in their names, in ascending order; both stamps
// are the number. A frame of which one image is missing is listed with the name it should have, so
// that reading it reports that name. color_folder may be empty: no colour. Throws InputError where
// two images of a folder have the same number.
std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder);

// The same, but calls `twice` with a sentence where two images have the same number.
using TwiceCall = std::function<void(const std::string&)>;
std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder, const TwiceCall& twice);

// The folder of colour beside depth/: color/, rgb/ or image/ of `folder`, or "" without one.
std::string FindColorFolder(const std::string& folder);

// The .klg files of ElasticFusion and its Logger, little endian: int32 number of frames; per frame
// int64 stamp (microseconds), int32 size of depth, int32 size of colour, depth (16-bit counts if
// that many bytes, else the same compressed by zlib), colour (red green blue if that many bytes,
// else JPEG; size 0: none).
// The file does not say how large its images are: they have the first JPEG's size, or without any
// the one given (0 x 0: unknown). Where the file ends before its number of frames, those that are
// whole are read, and a warning says so. Throws InputError naming the file if it cannot be read, or
// nothing tells the size.
OpenedRecording OpenKlg(const std::string& path, ImageSize size);

// ScanNet's .sens files (SensorData, version 4). Per frame: 4 x 4 floats camera-to-world (not
// finite: no pose), uint64 stamps of colour and of depth (microseconds), uint64 sizes of colour and
// of depth in bytes, colour, depth. Where the stamps of one are all 0 or not ascending, they are
// the other's; where those of both are, index / frames_per_second. What follows the frames
// (inertial data) is left alone. Where the file ends before its number of frames, those that are
// whole are read, and a warning says so. Throws InputError naming the file and what is wrong with
// it.
OpenedRecording OpenSens(const std::string& path, double frames_per_second);

// The camera in the header of such a file. Throws as OpenSens().
RgbdCamera ReadSensCamera(const std::string& path);

// A ROS bag of this format, or a folder of such ones: messages of depth and colour paired by their
// stamps. Throws InputError naming the file, and the topic or option at fault.
OpenedRecording OpenBag(const SequenceOptions& options, const std::string& format, bool is_folder);

// A recording of OpenNI2 (.oni). Its camera comes from the field of view. Throws InputError naming
// the file, also in a build without OpenNI2.
OpenedRecording OpenOni(const SequenceOptions& options);

}  // namespace surfit
