#include "pictures/png_file.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "surfit/core/atomic_file.h"

namespace surfit {

void WritePng(const Image<Rgb8>& image, const std::string& path) {
  static_assert(sizeof(Rgb8) == 3);
  const cv::Mat rgb(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<unsigned char> bytes;
  cv::imencode(".png", bgr, bytes);
  WriteFileAtomically(path, [&](std::ostream& file) {
    file.write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
}

}  // namespace surfit
