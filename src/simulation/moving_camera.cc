#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/simulation/render.h"

namespace surfit {
namespace {

constexpr double kMeanGrey = 0.18;
constexpr double kMinLight = 1e-3;

// First-order low-pass filter, updated once per frame. Always 0 if the lag is 0.
class Lagged {
 public:
  Lagged(double lag_s, double frame_s) : is_on_(lag_s > 0), share_(-std::expm1(-frame_s / lag_s)) {}

  // Returns the filtered value for the current frame. `wish`: unfiltered value, which takes effect
  // in the next frame. In the first frame, it takes effect at once.
  double Next(double wish) {
    if (!is_on_) return 0;
    if (!has_begun_) next_ = wish;
    has_begun_ = true;
    const double now = next_;
    next_ += share_ * (wish - next_);
    return now;
  }

 private:
  bool is_on_, has_begun_ = false;
  double share_, next_ = 0;
};

Eigen::Vector3d MeanOf(const LightImage& light) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& l : light) sum += l.cast<double>();
  return sum / static_cast<double>(light.size());
}

}  // namespace

bool ColorOptions::ArePlain() const {
  return color_readout_s == 0 && exposure_s == 0 && auto_exposure_lag_s == 0 &&
         auto_white_balance_lag_s == 0 && channel_gains.empty();
}

std::vector<Eigen::Vector3f> ColorGains(const std::vector<Eigen::Vector3d>& mean_light,
                                        double frames_per_second, const ColorOptions& options) {
  const double frame_s = 1 / frames_per_second;
  Lagged exposure(options.auto_exposure_lag_s, frame_s);
  std::vector<Lagged> balance(3, Lagged(options.auto_white_balance_lag_s, frame_s));
  std::vector<Eigen::Vector3f> gains;
  for (const Eigen::Vector3d& mean : mean_light) {
    const double brightness = std::max(mean.mean(), kMinLight);
    const double exposed = exposure.Next(std::log(kMeanGrey / brightness));
    Eigen::Vector3f gain;
    for (int c = 0; c < 3; ++c) {
      const double balanced = balance[c].Next(std::log(brightness / std::max(mean[c], kMinLight)));
      const double fixed = options.channel_gains.empty() ? 1 : options.channel_gains[c];
      gain[c] = static_cast<float>(fixed * std::exp(exposed + balanced));
    }
    gains.push_back(gain);
  }
  return gains;
}

MovingCamera::MovingCamera(const Scene& scene, const RgbdCamera& camera, const Trajectory& path,
                           const ColorOptions& options)
    : scene_(scene), camera_(camera), path_(path), options_(options) {
  camera.Validate("camera");
  Validate(options);
  const bool adapts = options.auto_exposure_lag_s > 0 || options.auto_white_balance_lag_s > 0;
  gains_ = ColorGains(adapts ? MeanLight() : std::vector<Eigen::Vector3d>(path.size(), {1, 1, 1}),
                      camera.frames_per_second, options);
}

std::vector<Eigen::Vector3d> MovingCamera::MeanLight() const {
  constexpr int kWidth = 80;
  const PinholeCamera small = camera_.depth.Binned(std::max(1, camera_.depth.width / kWidth));
  std::vector<Eigen::Vector3d> means;
  for (int i = 0; i < static_cast<int>(path_.poses().size()); ++i) {
    means.push_back(
        MeanOf(RenderLight(scene_, small, [&](int) { return path_.At(ColorCaptureTime(i)); })));
  }
  return means;
}

Rigid3d MovingCamera::PoseAt(double middle_s, double readout_s, int v) const {
  if (readout_s == 0) return path_.At(middle_s);
  return path_.At(middle_s + ((v + 0.5) / camera_.depth.height - 0.5) * readout_s);
}

Rigid3d MovingCamera::DepthPose(int i, int v) const {
  return PoseAt(path_.poses()[i].stamp_s, camera_.readout_s, v);
}

double MovingCamera::ColorCaptureTime(int i) const {
  return path_.poses()[i].stamp_s - camera_.color_latency_s;
}

Rigid3d MovingCamera::ColorPose(int i, int v) const {
  return PoseAt(ColorCaptureTime(i), options_.color_readout_s, v);
}

LightImage MovingCamera::Light(int i) const {
  const int samples = options_.exposure_s == 0 ? 1 : options_.exposure_samples;
  LightImage sum;
  for (int k = 0; k < samples; ++k) {
    const double later_s = ((k + 0.5) / samples - 0.5) * options_.exposure_s;
    LightImage light = RenderLight(scene_, camera_.depth, [&](int v) {
      return PoseAt(ColorCaptureTime(i) + later_s, options_.color_readout_s, v);
    });
    if (k == 0) {
      sum = std::move(light);
    } else {
      for (std::size_t p = 0; p < sum.size(); ++p) sum[p] += light[p];
    }
  }
  for (Eigen::Vector3f& l : sum) l /= static_cast<float>(samples);
  return sum;
}

Rendering MovingCamera::Frame(int i) const {
  const int count = static_cast<int>(path_.poses().size());
  ThrowIf(i < 0 || i >= count, "the frame is ", i, ", must be from 0 to ", count - 1);
  if (options_.ArePlain() && camera_.readout_s == 0 && camera_.color_latency_s == 0) {
    return Render(scene_, camera_.depth, path_.poses()[i].world_from_camera);
  }
  Rendering frame = RenderRows(scene_, camera_.depth, [&](int v) { return DepthPose(i, v); });
  frame.color = ToSrgbImage(Light(i), gains_[i]);
  return frame;
}

}  // namespace surfit
