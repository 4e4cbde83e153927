#include "browser/page.h"

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// JSON without '<', which is in strings only: no text ends the element. Invalid UTF-8 is replaced,
// because the name of a folder may be any bytes.
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

void WritePage(const Page& page, const std::string& path,
               const std::function<void(std::ostream&)>& write_data) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << page.before_data;
    write_data(file);
    file << page.after_data;
  });
}

void WriteData(const std::string& name, const Json& data, std::ostream* page) {
  *page << "<script type=\"application/json\" class=\"" << name << "\">" << ToScriptText(data)
        << "</script>\n";
}

}  // namespace surfit
