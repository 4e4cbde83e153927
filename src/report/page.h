#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

namespace surfit {

// An HTML page in which data are missing: its style, our scripts, Chart.js with its zoom and, for
// reports, three.js, put together from src/report/page at build time.
struct Page {
  const char* before_data;
  const char* after_data;
};
extern const Page kReportPage, kComparisonPage;

// Writes the element <script type="application/json" class="name"> that holds the data.
void WriteData(const std::string& name, const nlohmann::ordered_json& data, std::ostream* page);

}  // namespace surfit
