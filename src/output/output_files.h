#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

#include "surfit/core/options.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/io/sequence.h"

namespace surfit {

// keeps the order of insertion
using Json = nlohmann::ordered_json;

// Throws InputError with the path if the file is missing or not a JSON object, and like
// ReadJsonText().
Json ReadJson(const std::string& path);

// Writes a JSON file atomically. `indent` -1: one line. Replaces invalid UTF-8. NaN becomes null.
// Throws InputError with the path if writing fails.
void WriteJson(const Json& json, const std::string& path, int indent = 2);

// Writes an array of JSON objects with equal keys as CSV: a header, then one line per object. Null
// becomes an empty cell. Throws InputError with the path if writing fails. The order of the keys,
// which are not quoted, must be equal, too. No rows give an empty file.
void WriteCsv(const Json& rows, const std::string& path);

// Camera as an object with width, height, fx, fy, cx and cy, without distortion. CameraFromJson()
// throws an nlohmann::json exception for a missing field, and InputError for an invalid camera.
Json CameraToJson(const PinholeCamera& camera);
PinholeCamera CameraFromJson(const Json& json);

// Implement OptionsToJson() and OptionsFromJson().
nlohmann::ordered_json TableToJson(const OptionTable& table);
void ReadTable(const nlohmann::ordered_json& json, const OptionTable& table);

// Converts all options to a JSON object, without loss of precision of finite numbers.
template <typename Options>
nlohmann::ordered_json OptionsToJson(Options options) {
  return TableToJson(TableOf(&options));
}

// Throws an nlohmann::json exception for a missing field or wrong type, and InputError for an
// invalid text. Also reads the option names of version 0.1. Does not check the values.
template <typename Options>
Options OptionsFromJson(const nlohmann::ordered_json& json) {
  Options options;
  ReadTable(json, TableOf(&options));
  return options;
}

// Converts a calibration of corrected depth to a calibration of measured depth, for prepared
// frames. `found` was estimated from frames corrected by `given_field`, the result of
// ReadDepthField().
DepthCalibration CalibrationOfRawDepth(const SequenceInfo& info,
                                       const InverseDepthField& given_field,
                                       const DepthCalibration& found);

// Writes camera.yaml: the camera of the sequence with the estimated calibration. `found` as in
// CalibrationOfRawDepth(). Throws InputError with the path if writing fails.
void WriteEstimatedCamera(const SequenceInfo& info, const InverseDepthField& given_field,
                          const DepthCalibration& found, const std::string& path);

// [tx, ty, tz, qx, qy, qz, qw]
Json ToJson(const Rigid3d& pose);
// Object with fx, fy, cx, cy (px), inverse_depth_field (1/m) and readout_s.
Json ToJson(const DepthCalibration& calibration);
// Standard deviations from RefinementSummary::calibration_covariance, with the keys of ToJson();
// null for an empty covariance.
Json CalibrationSigmasToJson(const Eigen::MatrixXd& covariance);

}  // namespace surfit
