#include "pictures/plot_canvas.h"

#include <plplot/plplot.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

#if defined(__SANITIZE_ADDRESS__)
// Pango's fontconfig and PLplot's libltdl keep some 30 kB to the end of the process, by pointers in
// modules that are unloaded by then. NOLINTBEGIN(bugprone-reserved-identifier): the names are its
// own.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libfontconfig.so\nleak:libltdl.so\n";
}
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
// NOLINTEND(bugprone-reserved-identifier)
#endif

namespace surfit {
namespace {

constexpr Rgb8 kInk = {40, 40, 40};
constexpr Rgb8 kGrid = {220, 220, 220};
constexpr double kDotsPerInch = 96, kMillimetresPerInch = 25.4;
constexpr int kPen = 1;  // the slot of the current colour in PLplot's colour map 0

std::mutex& CanvasMutex() {
  static std::mutex mutex;
  return mutex;
}

// PLplot would ask on the terminal for another device if its Cairo driver were missing.
void RequireDriver() {
  std::array<const char*, 64> menu, names;
  const char** menu_begin = menu.data();
  const char** names_begin = names.data();
  int count = static_cast<int>(names.size());
  plgDevs(&menu_begin, &names_begin, &count);
  const bool found = std::any_of(names.begin(), names.begin() + count, [](const char* name) {
    return std::strcmp(name, "memcairo") == 0;
  });
  if (!found) {
    throw std::runtime_error(
        "PLplot's Cairo driver is missing: install the package plplot-driver-cairo");
  }
}

}  // namespace

PlotCanvas::PlotCanvas(Image<Rgb8>* image)
    : lock_(CanvasMutex()), width_px_(image->width()), height_px_(image->height()) {
  static_assert(sizeof(Rgb8) == 3);
  RequireDriver();
  plmkstrm(&stream_);
  plsdev("memcairo");
  plsmem(width_px_, height_px_, image->data());
  plspage(kDotsPerInch, kDotsPerInch, 0, 0, 0, 0);
  plinit();
  pladv(0);
  SetTextHeight(18);
  SetColor(kInk);
  UsePixels();
}

PlotCanvas::~PlotCanvas() {
  plsstrm(stream_);
  plend1();
}

void PlotCanvas::SetColor(Rgb8 color) {
  plscol0(kPen, color.r, color.g, color.b);
  plcol0(kPen);
}

void PlotCanvas::SetLineWidth(double width_px) { plwidth(width_px); }

void PlotCanvas::SetTextHeight(double height_px) {
  plschr(height_px / kDotsPerInch * kMillimetresPerInch, 1);
  plsmaj(6 / kDotsPerInch * kMillimetresPerInch, 1);  // ticks, 6 and 3 pixels long
  plsmin(3 / kDotsPerInch * kMillimetresPerInch, 1);
}

void PlotCanvas::SetBox(const PixelBox& box, const AxisRanges& ranges) {
  plvpor(box.left / width_px_, box.right / width_px_, 1 - box.bottom / height_px_,
         1 - box.top / height_px_);
  plwind(ranges.x.begin, ranges.x.end, ranges.y.begin, ranges.y.end);
}

void PlotCanvas::UsePixels() {
  SetBox({0, 0, static_cast<double>(width_px_), static_cast<double>(height_px_)},
         {{-0.5, width_px_ - 0.5}, {height_px_ - 0.5, -0.5}});
}

void PlotCanvas::BeginAxes(const Axes& axes) {
  SetBox(axes.box, axes.ranges);
  SetLineWidth(1);
  SetColor(kGrid);
  plbox("g", 0, 0, "g", 0, 0);
  SetColor(kInk);
  plbox("bcnst", 0, 0, axes.y_logarithmic ? "bclnstv" : "bcnstv", 0, 0);
  plmtex("t", 1.5, 0.5, 0.5, axes.title.c_str());
  plmtex("b", 3, 0.5, 0.5, axes.x_label.c_str());
  plmtex("l", 4.5, 0.5, 0.5, axes.y_label.c_str());
}

void PlotCanvas::DrawScale(const PixelBox& box, AxisRange range, bool logarithmic) {
  SetBox(box, {range, {0, 1}});
  SetColor(kInk);
  plbox(logarithmic ? "bclnst" : "bcnst", 0, 0, "bc", 0, 0);
  UsePixels();
}

void PlotCanvas::Text(double x, double y, const std::string& text, double justify) {
  plptex(x, y, 1, 0, justify, text.c_str());
}

void PlotCanvas::Line(const std::vector<double>& x, const std::vector<double>& y) {
  plline(static_cast<int>(std::min(x.size(), y.size())), x.data(), y.data());
}

void PlotCanvas::Marker(double x, double y, MarkerShape shape) {
  plstring(1, &x, &y, shape == MarkerShape::kCircle ? "\u25CF" : "\u25A0");
}

}  // namespace surfit
