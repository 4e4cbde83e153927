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

// Throws InputError naming the file if it cannot be read or is no JSON object.
Json ReadJson(const std::string& path);

// Writes a JSON file, indented unless indent is -1. What is no UTF-8 (a file's name may be
// anything) is replaced. Throws InputError naming the file.
void WriteJson(const Json& json, const std::string& path, int indent = 2);

// Writes rows of JSON objects that have the same keys as CSV: the keys, then each row's values,
// null as nothing. Throws InputError naming the file.
void WriteCsv(const Json& rows, const std::string& path);

// Width, height, fx, fy, cx and cy.
Json CameraToJson(const PinholeCamera& camera);
PinholeCamera CameraFromJson(const Json& json);

nlohmann::ordered_json TableToJson(const OptionTable& table);
void ReadTable(const nlohmann::ordered_json& json, const OptionTable& table);

// All fields by name, numbers without loss, parts as objects.
template <typename Options>
nlohmann::ordered_json OptionsToJson(Options options) {
  return TableToJson(TableOf(&options));
}

// Throws nlohmann's exceptions for a missing field or one of another type, and InputError for a
// text that does not fit.
template <typename Options>
Options OptionsFromJson(const nlohmann::ordered_json& json) {
  Options options;
  ReadTable(json, TableOf(&options));
  return options;
}

// A calibration that was found of a sequence's frames, which come with the field that was given
// applied, as one of the depth as it is measured.
DepthCalibration OfMeasuredDepth(const SequenceInfo& info, const InverseDepthField& given_field,
                                 const DepthCalibration& found);

// Writes the sequence's camera with such a calibration as camera.yaml. Throws InputError naming the
// file.
void WriteFoundCamera(const SequenceInfo& info, const InverseDepthField& given_field,
                      const DepthCalibration& found, const std::string& path);

// [tx, ty, tz, qx, qy, qz, qw]
Json ToJson(const Rigid3d& pose);
Json ToJson(const DepthCalibration& calibration);
// Standard deviations, from RefinementSummary::calibration_covariance; null where that is empty.
Json CalibrationSigmasToJson(const Eigen::MatrixXd& covariance);

}  // namespace surfit
