#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/inertial.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Returns a camera preset. Throws InputError with the list of names for an unknown name.
// - Data sets, 640 x 480 px: tum_fr1, tum_fr2, tum_fr3, icl_nuim (fy < 0, as published),
//   seven_scenes (colour camera not registered to depth), redwood, klg (default of ElasticFusion).
// - Data set, 1200 x 680 px: replica (as rendered for NICE-SLAM).
// - Sensors with factory settings and colour registered to depth: kinect_v1, xtion, kinect_v2,
//   azure_kinect (undistorted images), realsense_d415, realsense_d435, realsense_d455.
RgbdCamera CameraPreset(const std::string& name);

std::vector<std::string> CameraPresetNames();

// Reads a camera from YAML, as written by cv::FileStorage. fy of the result can be negative,
// see Mirrored(). The keys are:
//   depth_camera: { width, height, fx, fy, cx, cy, distortion: [ k1, k2, p1, p2, k3 ] }   px
//   color_camera: { the same keys }          if colour is not registered to depth
//   color_from_depth: { translation_m: [ x, y, z ], rotation_xyzw: [ x, y, z, w ] }
//   depth_units_per_metre: 5000.
//   disparity: { focal_px: 570., baseline_m: 0.075, counts_per_px: 8., count_at_infinity: 0. }
//   inverse_depth_sigma: 0.002               1/m: DepthNoise
//   inverse_depth_field: [ c0, c1, c2, c3, c4, c5 ]      1/m: ReadInverseDepthField()
//   frames_per_second: 30.
//   latency_s: 0.02                          timestamp minus capture time of a depth frame
//   color_latency_s: 0.01                    additional latency of colour
//   readout_s: 0.033                         rolling-shutter readout
//   prior: { focal_relative_sigma: 0.01, ... }        fields of CalibrationPrior
//   imu: { camera_from_imu: { as color_from_depth }, ... }        ReadImuCalibration()
// `depth_camera` is required, and either `depth_units_per_metre` or `disparity`. `color_from_depth`
// requires `color_camera`. Missing keys have these defaults: no distortion, the identity for
// `color_from_depth`, otherwise the defaults of RgbdCamera. Unknown keys and files above 64 KiB are
// errors. Throws InputError that names the file, the key, the value and the constraint.
RgbdCamera ReadCameraYaml(const std::string& path);

// Reads only the key `inverse_depth_field` of such a file: the correction of its depth. Returns the
// zero field without the key. Other keys are not checked. Throws InputError that names the file.
InverseDepthField ReadInverseDepthField(const std::string& path);

// Reads only the key `imu` of such a file: the inertial sensor. Its keys are camera_from_imu (as
// color_from_depth), time_offset_s, their standard deviations rotation_sigma_rad,
// translation_sigma_m and time_offset_sigma_s, and the fields of ImuNoise. The keys of `imu`
// replace those of `calibration`. A given camera_from_imu has the standard deviations 0.005 rad and
// 0.01 m, and a given time offset 0.003 s, unless their keys are present. Other keys of the file
// are not checked. Throws InputError that names the file and the key.
ImuCalibration ReadImuCalibration(const std::string& path, ImuCalibration calibration);

// Writes such a file atomically. A zero `field`, a zero `color_latency_s`, the default prior
// and a null `imu` are omitted. The camera is not validated. Throws InputError that names the file
// if it cannot be written.
void WriteCameraYaml(const RgbdCamera& camera, const std::string& path,
                     const InverseDepthField& field = {}, const ImuCalibration* imu = nullptr);

}  // namespace surfit
