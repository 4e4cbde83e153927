#pragma once

#include "common/tool_main.h"
#include "output/report/write_report.h"
#include "surfit/registration/icp.h"

namespace surfit::tools {

// Loss and inliers of each iteration, on stdout.
void PrintIterations(const IcpResult& icp);

// target_from_source as a 4 x 4 matrix, on stdout.
void PrintPose(const IcpResult& icp);

// The exit code; says on stderr what an unsuccessful registration lacks, value and constraint.
ExitCode PrintFailure(const IcpResult& icp, const IcpOptions& options);

// Writes the report and says where it is and what of the maps it shows. Throws like WriteReport().
void WriteAndPrintReport(const ReportOptions& options);

}  // namespace surfit::tools
