#pragma once

#include "common/tool_main.h"
#include "output/report/write_report.h"
#include "surfit/registration/icp.h"

namespace surfit::tools {

// Prints loss and number of inliers per iteration on stdout.
void PrintIterations(const IcpResult& icp);

// Prints target_from_source as a 4 x 4 matrix on stdout.
void PrintPose(const IcpResult& icp);

// Returns kDone after a success, otherwise kAlgorithmFailed. Prints the value and the constraint of
// a failed registration on stderr.
ExitCode PrintFailure(const IcpResult& icp, const IcpOptions& options);

// Writes the report, and prints the shown and the total number of surfels per map and the path of
// the report. Throws like WriteReport().
void WriteAndPrintReport(const ReportOptions& options);

}  // namespace surfit::tools
