#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

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

// A number with so many digits after its point.
std::string Fixed(double number, int digits);

// A page of text, tables and pictures, without scripts.
class PlainPage {
 public:
  struct Cell {
    Cell(std::string cell_text) : text(std::move(cell_text)) {}  // NOLINT: most have no link
    Cell(const char* cell_text) : text(cell_text) {}             // NOLINT
    Cell(std::string cell_text, std::string to) : text(std::move(cell_text)), link(std::move(to)) {}

    std::string text;
    std::string link;  // a file beside the page; empty if none
  };

  void Section(const std::string& title);
  void Paragraph(const std::string& text);
  void Picture(const std::string& file);  // beside the page
  // Rows of cells, the first of which are heads.
  void Table(const std::vector<std::vector<Cell>>& rows);
  // Throws InputError naming the file if it cannot be written.
  void Write(const std::string& title, const std::string& path) const;

 private:
  std::ostringstream body_;
};

}  // namespace surfit
