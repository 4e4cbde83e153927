#include "browser/page.h"

#include <iomanip>
#include <map>

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// JSON with '<' escaped, so that no string ends the script element.
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

std::string Escaped(const std::string& text) {
  static const std::map<char, const char*> kEscapes = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string escaped;
  for (const char c : text) {
    const auto found = kEscapes.find(c);
    escaped += found == kEscapes.end() ? std::string(1, c) : found->second;
  }
  return escaped;
}

std::string AddressOf(const std::string& path) {
  std::ostringstream address;
  for (const char c : path) {
    if (c == '%' || c == '#' || c == '?' || c == ':') {
      address << '%' << std::hex << std::uppercase << static_cast<int>(c);
    } else {
      address << c;
    }
  }
  return Escaped(address.str());
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

std::string Fixed(double number, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << number;
  return text.str();
}

void PlainPage::Section(const std::string& title) {
  body_ << "<h2>" << Escaped(title) << "</h2>\n";
}

void PlainPage::Paragraph(const std::string& text) { body_ << "<p>" << Escaped(text) << "</p>\n"; }

void PlainPage::Picture(const std::string& file) {
  body_ << "<p><img src=\"" << AddressOf(file) << "\" alt=\"" << Escaped(file) << "\"></p>\n";
}

void PlainPage::Table(const std::vector<std::vector<Cell>>& rows) {
  body_ << "<table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    body_ << "<tr>";
    for (const Cell& cell : rows[i]) {
      body_ << (i == 0 ? "<th>" : "<td>");
      if (!cell.link.empty()) body_ << "<a href=\"" << AddressOf(cell.link) << "\">";
      body_ << Escaped(cell.text) << (cell.link.empty() ? "" : "</a>");
    }
    body_ << "\n";
  }
  body_ << "</table>\n";
}

void PlainPage::Write(const std::string& title, const std::string& path) const {
  WritePage(kPlainPage, path, [&](std::ostream& file) {
    file << "<title>" << Escaped(title) << "</title>\n<main class=\"text-page\"><h1>"
         << Escaped(title) << "</h1>\n"
         << body_.str() << "</main>\n";
  });
}

}  // namespace surfit
