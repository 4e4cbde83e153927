#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

namespace surfit {

// An HTML page in which data are missing: its style, our scripts, and Chart.js with its zoom or
// three.js or both, put together from a folder `page` at build time.
struct Page {
  const char* before_data;
  const char* after_data;
};
extern const Page kReportPage, kComparisonPage, kLivePage;

// Writes the element <script type="application/json" class="name"> that holds the data.
void WriteData(const std::string& name, const nlohmann::ordered_json& data, std::ostream* page);

}  // namespace surfit
