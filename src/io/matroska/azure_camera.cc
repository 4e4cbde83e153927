#include "io/matroska/azure_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using AzureJson = nlohmann::json;

// Part of the sensor that a mode reads: the sensor, binned to `full` pixels, without the rows and
// columns before `crop`.
struct SensorPart {
  ImageSize full;
  int crop_u = 0, crop_v = 0;
};

SensorPart DepthPart(ImageSize size, const std::string& what) {
  if (size == ImageSize{640, 576}) return {{1024, 1024}, 192, 180};  // narrow
  if (size == ImageSize{320, 288}) return {{512, 512}, 96, 90};      // narrow, binned
  if (size == ImageSize{1024, 1024}) return {size, 0, 0};            // wide
  if (size == ImageSize{512, 512}) return {size, 0, 0};              // wide, binned
  throw InputError(what, ": depth images are ", size.width, " x ", size.height,
                   " pixels, must be 640 x 576, 320 x 288, 512 x 512 or 1024 x 1024");
}

// The colour sensor has the ratio 4:3. Modes of 16:9 are its middle rows.
SensorPart ColorPart(ImageSize size, const std::string& what) {
  const ImageSize full = {size.width, size.width * 3 / 4};
  ThrowIf(size.width > 4096 || size.height > full.height, what, ": colour images are ", size.width,
          " x ", size.height, " pixels, must be at most 4096 wide, with the ratio 4:3 or more");
  return {full, 0, (full.height - size.height) / 2};
}

// The camera of `Location` in calibration.json.
class CameraParser {
 public:
  CameraParser(const AzureJson& json, const std::string& location, const std::string& what)
      : what_(what + ": " + location) {
    for (const AzureJson& camera : json.at("CalibrationInformation").at("Cameras")) {
      if (camera.at("Location") == location) camera_ = camera;
    }
    ThrowIf(camera_.is_null(), what, " has no camera ", location);
  }

  Rigid3d CameraFromReference() const {
    const auto r = Numbers(camera_.at("Rt").at("Rotation"), "Rotation", 9);
    const auto t = Numbers(camera_.at("Rt").at("Translation"), "Translation", 3);
    Eigen::Matrix3d rotation;
    rotation << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
    ThrowIf(!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.01 &&
              rotation.determinant() > 0),
            what_, ": Rotation is no rotation matrix");
    return {Eigen::Quaterniond(rotation).normalized(), {t[0], t[1], t[2]}};
  }

  double AspectRatio() const {
    const double width = camera_.at("SensorWidth"), height = camera_.at("SensorHeight");
    ThrowIf(!(width > 0 && height > 0), what_, ": SensorWidth is ", width, " and SensorHeight ",
            height, ", must be positive");
    return width / height;
  }

  // `sensor`: ratio of width and height to which the intrinsics are relative. Intrinsics of older
  // files are relative to the middle part of another ratio.
  AzureCamera Camera(ImageSize size, const SensorPart& part) const {
    constexpr double kDefaultRadius = 1.7;  // if the calibration has none
    const AzureJson& intrinsics = camera_.at("Intrinsics");
    const std::string model = intrinsics.at("ModelType");
    const bool is_6kt = model == "CALIBRATION_LensDistortionModelRational6KT";
    ThrowIf(!is_6kt && model != "CALIBRATION_LensDistortionModelBrownConrady", what_,
            ": ModelType is ", model, ", must be CALIBRATION_LensDistortionModelBrownConrady");
    // cx cy fx fy k1 .. k6 codx cody p2 p1
    const auto m = Numbers(intrinsics.at("ModelParameters"), "ModelParameters", 14);
    const double width = part.full.width, own_height = width / AspectRatio();
    AzureCamera camera;
    PinholeCamera& pinhole = camera.pinhole;
    pinhole.width = size.width;
    pinhole.height = size.height;
    // The corner of the first pixel has the coordinates (0, 0) in the file.
    pinhole.cx = m[0] * width - part.crop_u - 0.5;
    pinhole.cy = m[1] * own_height + (part.full.height - own_height) / 2 - part.crop_v - 0.5;
    pinhole.fx = m[2] * width;
    pinhole.fy = m[3] * own_height;
    pinhole.Validate(what_);
    ThrowIf(pinhole.fy < 0, what_, ": fy is ", pinhole.fy, ", must be positive");
    AzureLens& lens = camera.lens;
    std::copy_n(m.begin() + 4, 6, lens.k.begin());
    lens.centre = {m[10], m[11]};
    lens.p2 = m[12];
    lens.p1 = m[13];
    lens.t = is_6kt ? 1 : 2;
    const double radius = camera_.value("MetricRadius", 0.);
    lens.max_radius = radius > 1e-4 ? radius : kDefaultRadius;
    return camera;
  }

 private:
  std::vector<double> Numbers(const AzureJson& json, const char* key, std::size_t least) const {
    auto numbers = json.get<std::vector<double>>();
    ThrowIf(numbers.size() < least, what_, ": ", key, " has ", numbers.size(),
            " numbers, must have ", least);
    for (const double number : numbers)
      ThrowIf(!std::isfinite(number), what_, ": ", key, " has the number ", number,
              ", must be finite");
    return numbers;
  }

  std::string what_;
  AzureJson camera_;
};

// Ray on an axis of the image whose distorted coordinate is `bent`, by bisection within the radius
// of the lens. The ray of the radius if none has this coordinate.
double RayOnAxis(const AzureLens& lens, int axis, double bent) {
  double near = 0, far = (bent < 0 ? -1 : 1) * 0.999 * (lens.max_radius - lens.centre.norm());
  const auto reaches = [&](double ray) {
    const auto distorted = lens.Distorted(ray * Eigen::Vector2d::Unit(axis));
    return !distorted || std::abs((*distorted)[axis]) >= std::abs(bent);
  };
  if (!reaches(far)) return far;
  for (int i = 0; i < 60; ++i) {
    const double middle = (near + far) / 2;
    (reaches(middle) ? far : near) = middle;
  }
  return far;
}

PinholeCamera CoveringPinhole(const AzureCamera& camera) {
  const PinholeCamera& recorded = camera.pinhole;
  PinholeCamera covering = recorded;
  const auto cover = [&](int axis, int size, double f, double c, int* new_size, double* new_c) {
    const double low = RayOnAxis(camera.lens, axis, -c / f);
    const double high = RayOnAxis(camera.lens, axis, (size - 1 - c) / f);
    const double before = std::min(std::floor(-f * low), c + size / 2.);
    const double after = std::min(std::floor(f * high), size - 1 - c + size / 2.);
    *new_c = before;
    *new_size = static_cast<int>(before + after) + 1;
  };
  cover(0, recorded.width, recorded.fx, recorded.cx, &covering.width, &covering.cx);
  cover(1, recorded.height, recorded.fy, recorded.cy, &covering.height, &covering.cy);
  return covering;
}

Rgb8 Interpolated(const Image<Rgb8>& image, float u, float v) {
  const int left = std::min(static_cast<int>(u), image.width() - 2);
  const int top = std::min(static_cast<int>(v), image.height() - 2);
  const float right = u - static_cast<float>(left), lower = v - static_cast<float>(top);
  const auto mean = [&](std::uint8_t Rgb8::*channel) {
    const auto at = [&](int x, int y) {
      return static_cast<float>(image(left + x, top + y).*channel);
    };
    const float above = at(0, 0) + right * (at(1, 0) - at(0, 0));
    const float below = at(0, 1) + right * (at(1, 1) - at(0, 1));
    return static_cast<std::uint8_t>(above + lower * (below - above) + 0.5F);
  };
  return {mean(&Rgb8::r), mean(&Rgb8::g), mean(&Rgb8::b)};
}

template <typename T, typename At>
Image<T> Remapped(const Image<float>& u, const Image<float>& v, const At& at) {
  Image<T> result(u.width(), u.height());
  ParallelFor(0, u.height(), kRowsPerBlock, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < u.width(); ++column) {
        if (!std::isnan(u(column, row))) result(column, row) = at(u(column, row), v(column, row));
      }
    }
  });
  return result;
}

}  // namespace

std::optional<Eigen::Vector2d> AzureLens::Distorted(const Eigen::Vector2d& ray) const {
  const Eigen::Vector2d p = ray - centre;
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  if (r2 > max_radius * max_radius) return std::nullopt;
  const double d =
      (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]))) / (1 + r2 * (k[3] + r2 * (k[4] + r2 * k[5])));
  return centre + Eigen::Vector2d(x * d + p2 * (r2 + 2 * x * x) + t * p1 * x * y,
                                  y * d + p1 * (r2 + 2 * y * y) + t * p2 * x * y);
}

AzureCalibration ParseAzureCalibration(const std::string& json, ImageSize depth, ImageSize color,
                                       const std::string& what) {
  try {
    const AzureJson parsed = AzureJson::parse(json);
    AzureCalibration calibration;
    const CameraParser depth_parser(parsed, "CALIBRATION_CameraLocationD0", what);
    calibration.depth = depth_parser.Camera(depth, DepthPart(depth, what));
    if (color == ImageSize()) return calibration;
    const CameraParser color_parser(parsed, "CALIBRATION_CameraLocationPV0", what);
    calibration.color = color_parser.Camera(color, ColorPart(color, what));
    calibration.color_from_depth =
        color_parser.CameraFromReference() * depth_parser.CameraFromReference().Inverse();
    return calibration;
  } catch (const AzureJson::exception& error) {
    throw InputError(what, ": ", error.what());
  }
}

AzureUndistorter::AzureUndistorter(const AzureCamera& camera)
    : camera_(camera), pinhole_(CoveringPinhole(camera)) {}

void AzureUndistorter::FindPixels() {
  if (!u_.empty()) return;
  const PinholeCamera& recorded = camera_.pinhole;
  constexpr float kOutside = std::numeric_limits<float>::quiet_NaN();
  u_ = v_ = Image<float>(pinhole_.width, pinhole_.height, kOutside);
  ParallelFor(0, pinhole_.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < pinhole_.width; ++u) {
        const auto bent = camera_.lens.Distorted(pinhole_.Ray(u, v).head<2>());
        if (!bent) continue;
        const double at_u = recorded.fx * bent->x() + recorded.cx;
        const double at_v = recorded.fy * bent->y() + recorded.cy;
        if (!(at_u >= 0 && at_v >= 0 && at_u <= recorded.width - 1 && at_v <= recorded.height - 1))
          continue;
        u_(u, v) = static_cast<float>(at_u);
        v_(u, v) = static_cast<float>(at_v);
      }
    }
  });
}

Image<std::uint16_t> AzureUndistorter::Undistorted(const Image<std::uint16_t>& depth) {
  FindPixels();
  return Remapped<std::uint16_t>(u_, v_, [&](float u, float v) {
    return depth(static_cast<int>(u + 0.5F), static_cast<int>(v + 0.5F));
  });
}

Image<Rgb8> AzureUndistorter::Undistorted(const Image<Rgb8>& color) {
  FindPixels();
  return Remapped<Rgb8>(u_, v_, [&](float u, float v) { return Interpolated(color, u, v); });
}

}  // namespace surfit
