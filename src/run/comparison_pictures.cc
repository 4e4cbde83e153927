#include "run/comparison_pictures.h"

#include <algorithm>

#include "pictures/dot_chart.h"
#include "pictures/line_panels.h"
#include "pictures/png_file.h"
#include "pictures/share_tables.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// What is compared side by side.
std::string GroupTitle(const SolverCombination& combination) {
  return combination.residual + ", " + combination.association;
}

// The titles in the order of their first.
template <typename TitleOf>
std::vector<std::string> TitlesOf(const std::vector<ComparedRuns>& all, const TitleOf& title_of) {
  std::vector<std::string> titles;
  for (const ComparedRuns& runs : all) {
    const std::string title = title_of(runs.combination);
    if (std::find(titles.begin(), titles.end(), title) == titles.end()) titles.push_back(title);
  }
  return titles;
}

// Results do not depend on the number of threads.
std::vector<ComparedRuns> OfOneThreadCount(const std::vector<ComparedRuns>& all) {
  std::vector<ComparedRuns> chosen;
  for (const ComparedRuns& runs : all) {
    if (runs.threads == all.front().threads) chosen.push_back(runs);
  }
  return chosen;
}

// The second of the diagonal, from which slow combinations run as well.
GridCell ShownStart(const CompareOptions& options) {
  const bool has_second = options.rotations_deg.size() > 1 && options.translations_m.size() > 1;
  return has_second ? GridCell{1, 1} : GridCell{0, 0};
}

void WriteConvergence(const std::vector<ComparedRuns>& all, const CompareOptions& options) {
  const GridCell start = ShownStart(options);
  std::vector<LinePanel> panels;
  for (const std::string& title : TitlesOf(all, GroupTitle)) {
    LinePanel panel{title, {}};
    for (const ComparedRuns& runs : all) {
      if (GroupTitle(runs.combination) != title) continue;
      for (const ComparedRun& run : runs.runs) {
        if (run.problem != 0 || !(run.cell == start)) continue;
        panel.series.push_back({runs.combination.SolverTitle(), run.outcome.losses});
      }
    }
    panels.push_back(std::move(panel));
  }
  const std::string x_label = Concat("iteration, from ", options.rotations_deg[start.rotation],
                                     " deg and ", options.translations_m[start.translation], " m");
  WritePng(DrawLinePanels(panels, x_label, "loss [m#u2#d]"), options.output + "/convergence.png");
}

ShareTable TableOf(const ComparedRuns& runs, const CompareOptions& options) {
  ShareTable table(options.rotations_deg.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    for (std::size_t j = 0; j < options.translations_m.size(); ++j) {
      table[i].push_back(ConvergedShare(runs, {static_cast<int>(i), static_cast<int>(j)}));
    }
  }
  return table;
}

std::vector<std::string> Labels(const std::vector<double>& values) {
  std::vector<std::string> labels;
  labels.reserve(values.size());
  for (const double value : values) labels.push_back(Concat(value));
  return labels;
}

void WriteBasins(const std::vector<ComparedRuns>& all, const CompareOptions& options) {
  ShareTables tables;
  tables.title = Concat("Percent of the starts that end within ", options.max_rotation_error_deg,
                        " deg and ", options.max_translation_error_m, " m of the truth");
  tables.cell_rows_label = "turned by [deg]";
  tables.cell_columns_label = "shifted by [m]";
  tables.cell_row_labels = Labels(options.rotations_deg);
  tables.cell_column_labels = Labels(options.translations_m);
  const auto row_title = [](const SolverCombination& combination) {
    return combination.SolverTitle() + ", " + combination.association;
  };
  const auto column_title = [](const SolverCombination& combination) {
    return combination.residual;
  };
  tables.column_titles = TitlesOf(all, column_title);
  tables.row_titles = TitlesOf(all, row_title);
  tables.tables.resize(tables.row_titles.size(),
                       std::vector<ShareTable>(tables.column_titles.size()));
  const auto index = [](const std::vector<std::string>& titles, const std::string& title) {
    return std::find(titles.begin(), titles.end(), title) - titles.begin();
  };
  for (const ComparedRuns& runs : all) {
    const auto row = index(tables.row_titles, row_title(runs.combination));
    const auto column = index(tables.column_titles, column_title(runs.combination));
    tables.tables[row][column] = TableOf(runs, options);
  }
  WritePng(DrawShareTables(tables), options.output + "/basin.png");
}

void WriteTimes(const std::vector<ComparisonRow>& rows, const CompareOptions& options) {
  DotChart chart;
  chart.title = "Median times: linearised once, one solve, from the start to the final pose";
  if (options.synthetic_points == 0) {
    chart.title += " (closed_form_ldlt and _lu: with the association)";
  }
  chart.x_label = "milliseconds";
  chart.series = {"linearise", "solve", "in all"};
  for (const ComparisonRow& row : rows) {
    const std::string heading = GroupTitle(row.combination);
    if (chart.groups.empty() || chart.groups.back().heading != heading) {
      chart.groups.push_back({heading, {}});
    }
    std::string label = row.combination.SolverTitle();
    if (options.threads.size() > 1) label += Concat(", ", row.threads, " threads");
    chart.groups.back().rows.push_back({label, {row.linearize_ms, row.solve_ms, row.total_ms}});
  }
  WritePng(DrawDotChart(chart), options.output + "/time.png");
}

}  // namespace

void WriteComparisonPictures(const std::vector<ComparedRuns>& all,
                             const std::vector<ComparisonRow>& rows,
                             const CompareOptions& options) {
  if (rows.empty()) return;
  const std::vector<ComparedRuns> once = OfOneThreadCount(all);
  WriteConvergence(once, options);
  if (rows.front().converged_share) WriteBasins(once, options);
  WriteTimes(rows, options);
}

}  // namespace surfit
