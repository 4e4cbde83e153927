#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace surfit {

// HTML page before and after its data. Assembled by CMakeLists.txt.
struct Page {
  const char* before_data;
  const char* after_data;
};
extern const Page kReportPage, kComparisonPage, kLivePage, kPlainPage;

// Writes a self-contained page with WriteFileAtomically(), and throws like this function.
// `write_data` writes the data with WriteData().
void WritePage(const Page& page, const std::string& path,
               const std::function<void(std::ostream&)>& write_data);

// Writes the data as an element <script type="application/json" class="name">. `name` is not
// escaped. NaN becomes null, and invalid UTF-8 is replaced.
void WriteData(const std::string& name, const nlohmann::ordered_json& data, std::ostream* page);

// Number with `digits` decimals.
std::string Fixed(double number, int digits);

// Page of text, tables and pictures without scripts. Elements appear in the order of the calls. All
// text is escaped. Write() throws like WritePage().
class PlainPage {
 public:
  struct Cell {
    Cell(std::string cell_text) : text(std::move(cell_text)) {}  // NOLINT: most have no link
    Cell(const char* cell_text) : text(cell_text) {}             // NOLINT
    Cell(std::string cell_text, std::string to) : text(std::move(cell_text)), link(std::move(to)) {}

    std::string text;
    std::string link;  // path relative to the page; empty: no link
  };

  // Begins a section with a heading.
  void Section(const std::string& title);
  void Paragraph(const std::string& text);
  // `file`: path relative to the page.
  void Picture(const std::string& file);
  // The first row has the column titles.
  void Table(const std::vector<std::vector<Cell>>& rows);
  void Write(const std::string& title, const std::string& path) const;

 private:
  std::ostringstream body_;
};

}  // namespace surfit
