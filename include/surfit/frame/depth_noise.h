#pragma once

namespace surfit {

class OptionVisitor;

// Noise of a structured-light or stereo depth sensor, constant in inverse depth: with baseline b,
// focal length f and disparity noise delta, sigma_z = delta z^2 / (b f), that is
// sigma_(1/z) = delta / (b f) (Khoshelham and Elberink 2012; Schoeps et al., BAD SLAM, 2019).
struct DepthNoise {
  // 1/m. Kinect v1: 0.1 px / (0.075 m * 525 px) = 0.0025; 8 mm at 2 m.
  double inverse_depth_sigma = 0.002;

  // Standard deviation of a depth z, in metres.
  double SigmaZ(double z_m) const { return inverse_depth_sigma * z_m * z_m; }

  void Visit(OptionVisitor& visitor);
};

}  // namespace surfit
