#pragma once

#include <Eigen/Core>
#include <string>

#include "run/output_files.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/io/sequence.h"

namespace surfit {

// A calibration that was found of a sequence's frames, which come with the field that was given
// applied, as one of the depth as it is measured.
DepthCalibration OfMeasuredDepth(const SequenceInfo& info, const InverseDepthField& given_field,
                                 const DepthCalibration& found);

// Writes the sequence's camera with such a calibration as camera.yaml. Throws InputError naming the
// file.
void WriteFoundCamera(const SequenceInfo& info, const InverseDepthField& given_field,
                      const DepthCalibration& found, const std::string& path);

Json ToJson(const DepthCalibration& calibration);
// Standard deviations, from RefinementSummary::calibration_covariance; null where that is empty.
Json CalibrationSigmasToJson(const Eigen::MatrixXd& covariance);

}  // namespace surfit
