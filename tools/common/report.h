#pragma once

#include "surfit/report/write_report.h"

namespace surfit::tools {

// Writes the report and says where it is and what of the maps it shows. Throws like WriteReport().
void WriteAndPrintReport(const ReportOptions& options);

}  // namespace surfit::tools
