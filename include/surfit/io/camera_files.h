#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// The cameras of well-known data sets, 640 x 480: tum_fr1, tum_fr2, tum_fr3, icl_nuim (fy < 0, as
// published), seven_scenes (colour camera not registered to depth), redwood, replica (1200 x 680,
// as rendered for NICE-SLAM), klg (ElasticFusion's default); and of sensors as they come, colour
// registered to depth: kinect_v1, xtion, kinect_v2, azure_kinect, realsense_d415, realsense_d435,
// realsense_d455. Throws InputError listing the known names for any other.
RgbdCamera CameraPreset(const std::string& name);

std::vector<std::string> CameraPresetNames();

// A camera as YAML (as OpenCV's FileStorage writes it):
//   depth_camera: { width, height, fx, fy, cx, cy, distortion: [ k1, k2, p1, p2, k3 ] }   pixels
//   color_camera: { the same keys }          only where colour is not registered to depth
//   color_from_depth: { translation_m: [ x, y, z ], rotation_xyzw: [ x, y, z, w ] }
//   depth_units_per_metre: 5000.
//   disparity: { focal_px: 570., baseline_m: 0.075, counts_per_px: 8. }   in place of the units
//   inverse_depth_sigma: 0.002               1/m: DepthNoise
//   inverse_depth_field: [ c0, c1, c2, c3, c4, c5 ]      1/m: ReadInverseDepthField()
//   frames_per_second: 30.
//   latency_s: 0.02                          how long before its stamp a depth frame was measured
//   color_latency_s: 0.01                    and how much longer a colour frame
//   readout_s: 0.033                         of a rolling shutter
//   prior: { focal_share: 0.01, ... }        any fields of CalibrationPrior
// depth_camera and depth_units_per_metre (or disparity) must stand; distortion is zero,
// color_from_depth the identity, and the others the RgbdCamera's defaults where they do not. A key
// that is none of these is an error, for it is a misspelt one. Throws InputError naming the file,
// the key, the value and the constraint.
RgbdCamera ReadCameraYaml(const std::string& path);

// Its inverse_depth_field, what its depth needs to be right; zero where there is none.
// Throws InputError as ReadCameraYaml() does.
InverseDepthField ReadInverseDepthField(const std::string& path);

// Writes such a file, without a field or a color_latency_s that is zero and a prior that is the
// default. Throws InputError naming the file if it cannot be written.
void WriteCameraYaml(const RgbdCamera& camera, const std::string& path,
                     const InverseDepthField& field = {});

}  // namespace surfit
