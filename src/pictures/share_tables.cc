#include "pictures/share_tables.h"

#include <algorithm>
#include <cmath>

#include "pictures/chart_colors.h"
#include "pictures/color_scale.h"
#include "pictures/plot_canvas.h"

namespace surfit {
namespace {

constexpr int kCellWidth = 44, kCellHeight = 22;
constexpr int kLeft = 340;  // for titles of rows
constexpr int kTop = 90;    // for titles of columns
constexpr int kLabelWidth = 52, kLabelHeight = 26, kSpace = 14;

// Where things are, in pixels.
struct Layout {
  int table_width, table_height, width, height;

  explicit Layout(const ShareTables& t)
      : table_width(kLabelWidth + kCellWidth * static_cast<int>(t.cell_column_labels.size()) +
                    kSpace),
        table_height(kLabelHeight + kCellHeight * static_cast<int>(t.cell_row_labels.size()) +
                     kSpace),
        width(std::max(900, kLeft + table_width * static_cast<int>(t.column_titles.size()))),
        height(kTop + table_height * static_cast<int>(t.row_titles.size()) + kSpace) {}

  int TableLeft(std::size_t column) const {
    return kLeft + table_width * static_cast<int>(column) + kLabelWidth;
  }
  int TableTop(std::size_t row) const {
    return kTop + table_height * static_cast<int>(row) + kLabelHeight;
  }
};

void FillCell(int left, int top, Rgb8 color, Image<Rgb8>* image) {
  for (int v = top; v < top + kCellHeight - 1; ++v) {
    std::fill_n(&(*image)(left, v), kCellWidth - 1, color);
  }
}

// Calls f(share, left, top) for each cell that has one.
template <typename F>
void ForEachCell(const ShareTables& t, const Layout& layout, const F& f) {
  for (std::size_t row = 0; row < t.tables.size(); ++row) {
    for (std::size_t column = 0; column < t.tables[row].size(); ++column) {
      const ShareTable& table = t.tables[row][column];
      for (std::size_t i = 0; i < table.size(); ++i) {
        for (std::size_t j = 0; j < table[i].size(); ++j) {
          if (!table[i][j]) continue;
          f(*table[i][j], layout.TableLeft(column) + kCellWidth * static_cast<int>(j),
            layout.TableTop(row) + kCellHeight * static_cast<int>(i));
        }
      }
    }
  }
}

// The labels of a small table's rows and columns.
void DrawCellLabels(const ShareTables& t, int left, int top, PlotCanvas* canvas) {
  canvas->SetTextHeight(12);
  for (std::size_t i = 0; i < t.cell_row_labels.size(); ++i) {
    canvas->Text(left - 6, top + kCellHeight * (static_cast<double>(i) + 0.5), t.cell_row_labels[i],
                 1);
  }
  for (std::size_t j = 0; j < t.cell_column_labels.size(); ++j) {
    canvas->Text(left + kCellWidth * (static_cast<double>(j) + 0.5), top - 10,
                 t.cell_column_labels[j], 0.5);
  }
}

void DrawTitles(const ShareTables& t, const Layout& layout, PlotCanvas* canvas) {
  canvas->SetColor(kChartInk);
  canvas->SetTextHeight(18);
  canvas->Text(20, 24, t.title);
  canvas->SetTextHeight(14);
  canvas->Text(20, 50, "rows: " + t.cell_rows_label + ", columns: " + t.cell_columns_label);
  for (std::size_t column = 0; column < t.column_titles.size(); ++column) {
    canvas->Text(layout.TableLeft(column), kTop - 8, t.column_titles[column]);
  }
  for (std::size_t row = 0; row < t.row_titles.size(); ++row) {
    canvas->SetTextHeight(14);
    canvas->Text(20, layout.TableTop(row) + kCellHeight * 0.5, t.row_titles[row]);
    for (std::size_t column = 0; column < t.column_titles.size(); ++column) {
      if (t.tables[row][column].empty()) continue;
      DrawCellLabels(t, layout.TableLeft(column), layout.TableTop(row), canvas);
    }
  }
}

}  // namespace

Image<Rgb8> DrawShareTables(const ShareTables& tables) {
  const Layout layout(tables);
  const ColorScale scale(0, 1, false);
  Image<Rgb8> image(layout.width, layout.height, kChartPaper);
  ForEachCell(tables, layout, [&](double share, int left, int top) {
    FillCell(left, top, scale.ColorOf(share), &image);
  });
  {
    PlotCanvas canvas(&image);
    DrawTitles(tables, layout, &canvas);
    canvas.SetTextHeight(12);
    ForEachCell(tables, layout, [&](double share, int left, int top) {
      canvas.SetColor(share > 0.6 ? kChartInk : kChartPaper);  // on yellow and on blue
      canvas.Text(left + 0.5 * kCellWidth, top + 0.5 * kCellHeight,
                  std::to_string(std::lround(100 * share)), 0.5);
    });
  }
  return image;
}

}  // namespace surfit
