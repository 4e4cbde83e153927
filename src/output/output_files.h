#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "surfit/core/options.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/io/sequence.h"

namespace surfit {

// Keys stay in the order in which they are set.
using Json = nlohmann::ordered_json;

// Throws InputError with the path unless the file is a JSON object.
Json ReadJson(const std::string& path);

// Writes a JSON file atomically. indent -1: one line. Replaces invalid UTF-8, for example in file
// names. Throws InputError with the path if writing fails.
void WriteJson(const Json& json, const std::string& path, int indent = 2);

// Writes an array of JSON objects with equal keys as CSV: a header with the keys, then one line per
// object. A value of null becomes an empty cell. Throws InputError with the path if writing fails.
void WriteCsv(const Json& rows, const std::string& path);

// Converts width, height, fx, fy, cx and cy. CameraFromJson() throws exceptions of nlohmann::json
// for missing fields, and InputError for an invalid camera.
Json CameraToJson(const PinholeCamera& camera);
PinholeCamera CameraFromJson(const Json& json);

nlohmann::ordered_json TableToJson(const OptionTable& table);
void ReadTable(const nlohmann::ordered_json& json, const OptionTable& table);

// Converts all fields, numbers without loss and parts as objects.
template <typename Options>
nlohmann::ordered_json OptionsToJson(Options options) {
  return TableToJson(TableOf(&options));
}

// Throws exceptions of nlohmann::json for missing fields and wrong types, and InputError for
// invalid texts.
template <typename Options>
Options OptionsFromJson(const nlohmann::ordered_json& json) {
  Options options;
  ReadTable(json, TableOf(&options));
  return options;
}

// Converts a calibration to measured depth. `found` was estimated from frames to which
// `given_field` had already been applied.
DepthCalibration CalibrationOfRawDepth(const SequenceInfo& info,
                                       const InverseDepthField& given_field,
                                       const DepthCalibration& found);

// Writes the camera of the sequence with the estimated calibration as camera.yaml. `found` as in
// CalibrationOfRawDepth(). Throws InputError with the path if writing fails.
void WriteEstimatedCamera(const SequenceInfo& info, const InverseDepthField& given_field,
                          const DepthCalibration& found, const std::string& path);

// [tx, ty, tz, qx, qy, qz, qw]
Json ToJson(const Rigid3d& pose);
Json ToJson(const DepthCalibration& calibration);
// Standard deviations from RefinementSummary::calibration_covariance; null if it is empty.
Json CalibrationSigmasToJson(const Eigen::MatrixXd& covariance);

}  // namespace surfit
