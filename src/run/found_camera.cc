#include "run/found_camera.h"

#include "surfit/geometry/sensor.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

// The field of both corrections, one after the other: the given one by the rays of its own camera,
// the found one by those of the found camera.
InverseDepthField Combined(const DepthCalibration& given, const DepthCalibration& found) {
  const PinholeCamera &a = given.camera, &b = found.camera;
  InverseDepthField sum =
      given.field.Substituted(b.fx / a.fx, (b.cx - a.cx) / a.fx, b.fy / a.fy, (b.cy - a.cy) / a.fy);
  for (std::size_t i = 0; i < InverseDepthField::kSize; ++i) {
    sum.coefficients[i] += found.field.coefficients[i];
  }
  return sum;
}

// The file's camera with what was found of its undistorted and downsampled images.
RgbdCamera Calibrated(RgbdCamera camera, const DepthCalibration& given,
                      const DepthCalibration& found) {
  const bool mirrored = camera.depth.fy < 0;
  if (mirrored) camera = Mirrored(camera);
  PinholeCamera& depth = camera.depth;
  const double downsample = depth.fx / given.camera.fx;
  depth.fx = found.camera.fx * downsample;
  depth.fy = found.camera.fy * downsample;
  depth.cx = found.camera.cx * downsample;
  depth.cy = found.camera.cy * downsample;
  return mirrored ? Mirrored(camera) : camera;
}

}  // namespace

DepthCalibration OfMeasuredDepth(const SequenceInfo& info, const InverseDepthField& given_field,
                                 const DepthCalibration& found) {
  return {found.camera, Combined({info.pinhole, given_field}, found)};
}

void WriteFoundCamera(const SequenceInfo& info, const InverseDepthField& given_field,
                      const DepthCalibration& found, const std::string& path) {
  const DepthCalibration given = {info.pinhole, given_field};
  const InverseDepthField field = Combined(given, found);
  WriteCameraYaml(Calibrated(info.camera, given, found), path,
                  info.mirrored ? Mirrored(field) : field);
}

Json ToJson(const DepthCalibration& calibration) {
  const PinholeCamera& c = calibration.camera;
  return {{"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"inverse_depth_field", calibration.field.coefficients}};
}

Json CalibrationSigmasToJson(const Eigen::MatrixXd& covariance) {
  if (covariance.size() == 0) return nullptr;
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const std::vector<double> field(sigma.data() + 4, sigma.data() + sigma.size());
  return {{"fx", sigma[0]},
          {"fy", sigma[1]},
          {"cx", sigma[2]},
          {"cy", sigma[3]},
          {"inverse_depth_field", field}};
}

}  // namespace surfit
