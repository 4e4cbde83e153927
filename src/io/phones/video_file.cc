#include "io/phones/video_file.h"

#include <dlfcn.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/version.hpp>
#include <opencv2/videoio.hpp>

#include "io/phones/mp4_samples.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Constructor of cv::VideoCapture, which is the only function that is not virtual.
using ConstructCapture = void (*)(void* capture, const cv::String& path, int backend);
constexpr const char* kConstructCapture =
    "_ZN2cv12VideoCaptureC1ERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEi";

ConstructCapture LoadVideoLibrary() {
  const std::string version =
      Concat(CV_VERSION_MAJOR, CV_VERSION_MINOR < 10 ? "0" : "", CV_VERSION_MINOR);
  const std::string name = "libopencv_videoio.so." + version;
  // The library stays loaded, because its decoders run threads.
  void* const library = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) {
    throw InputError("videos need OpenCV's videoio, which cannot be loaded (", dlerror(),
                     "): install the Debian package libopencv-videoio", version);
  }
  void* const construct = dlsym(library, kConstructCapture);
  ThrowIf(construct == nullptr, name, " has no function ", kConstructCapture);
  return reinterpret_cast<ConstructCapture>(construct);
}

std::unique_ptr<cv::VideoCapture> OpenCapture(const std::string& path) {
  static const ConstructCapture construct = LoadVideoLibrary();
  void* const memory = operator new(sizeof(cv::VideoCapture));
  try {
    construct(memory, path, cv::CAP_FFMPEG);
  } catch (...) {
    operator delete(memory);
    throw;
  }
  std::unique_ptr<cv::VideoCapture> capture(static_cast<cv::VideoCapture*>(memory));
  ThrowIf(!capture->isOpened(), path, " cannot be decoded: OpenCV finds no video in it");
  // Intrinsics belong to the stored pixels.
  capture->set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  return capture;
}

}  // namespace

struct VideoFile::Capture {
  std::unique_ptr<cv::VideoCapture> video;
};

VideoFile::VideoFile(const std::string& path) : path_(path) {
  const Mp4Samples samples = ReadMp4Samples(path);
  capture_ = std::make_unique<Capture>(Capture{OpenCapture(path)});
  const auto side = [&](int property) { return static_cast<int>(capture_->video->get(property)); };
  size_ = {side(cv::CAP_PROP_FRAME_WIDTH), side(cv::CAP_PROP_FRAME_HEIGHT)};
  RequireValidSize(size_, path);
  hidden_ = samples.hidden;
  frame_count_ = samples.total - samples.hidden;
}

VideoFile::~VideoFile() = default;

Image<Rgb8> VideoFile::Read(int frame) {
  const auto require = [&](bool decoded) {
    ThrowIf(!decoded, path_, ": frame ", frame, " cannot be decoded");
  };
  if (frame < next_) {
    capture_->video.reset();
    capture_->video = OpenCapture(path_);
    next_ = 0;
  }
  require(capture_->video != nullptr);
  for (; next_ <= frame; ++next_) require(capture_->video->grab());
  cv::Mat image;
  require(capture_->video->retrieve(image, 0) && image.cols == size_.width &&
          image.rows == size_.height && image.type() == CV_8UC3);
  Image<Rgb8> color(size_.width, size_.height);
  for (int v = 0; v < size_.height; ++v) {
    const unsigned char* bgr = image.ptr(v);
    Rgb8* const row = color.row(v);
    for (int u = 0; u < size_.width; ++u, bgr += 3) row[u] = {bgr[2], bgr[1], bgr[0]};
  }
  return color;
}

}  // namespace surfit
