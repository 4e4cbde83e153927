#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

namespace surfit {

// An HTML page around its data: style, scripts and the libraries that the scripts need. The build
// puts the parts together (CMakeLists.txt).
struct Page {
  const char* before_data;
  const char* after_data;
};
extern const Page kReportPage, kComparisonPage, kLivePage, kPlainPage;

// Writes a page that needs no other file. Throws InputError naming the file if it cannot be
// written.
void WritePage(const Page& page, const std::string& path,
               const std::function<void(std::ostream&)>& write_data);

// Writes the element <script type="application/json" class="name"> that holds the data.
void WriteData(const std::string& name, const nlohmann::ordered_json& data, std::ostream* page);

}  // namespace surfit
