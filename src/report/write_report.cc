#include "surfit/report/write_report.h"

#include "report/page.h"
#include "report/report_data.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// JSON that HTML cannot mistake for a tag; '<' stands in strings only. What is no UTF-8 (a folder's
// name may be anything) is replaced.
std::string ToScriptText(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

}  // namespace

void WriteData(const std::string& name, const Json& data, std::ostream* page) {
  *page << "<script type=\"application/json\" class=\"" << name << "\">" << ToScriptText(data)
        << "</script>\n";
}

void ReportOptions::Visit(OptionVisitor& v) {
  v.Add(runs, "runs", "output folder of surfit_slam; several --run stand side by side", Required(),
        AsFlag("run"), Repeatable());
  v.Add(output, "output", "the page; if empty, report.html in the first run's folder", Required(),
        AsFlag());
  v.Add(max_points, "max_points",
        "surfels of all runs together that the page holds; larger maps are sampled evenly",
        AtLeast(1000), AsFlag());
}

std::vector<ReportedMap> WriteReport(const ReportOptions& options) {
  Validate(options);
  std::vector<ReportedMap> maps;
  WriteFileAtomically(options.output, [&](std::ostream& file) {
    file << kReportPage.before_data;
    for (const std::string& folder : options.runs) {
      const Json run = ReadRun(folder, options.max_points / options.runs.size());
      maps.push_back({folder, run["map"]["points"], run["map"]["shown"]});
      WriteData("run", run, &file);
    }
    file << kReportPage.after_data;
  });
  return maps;
}

}  // namespace surfit
