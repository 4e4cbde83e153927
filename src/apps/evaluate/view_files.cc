#include "apps/evaluate/view_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iomanip>
#include <utility>

#include "output/output_files.h"
#include "output/pictures/canvas.h"
#include "output/recorded_run.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kHeader_px = 28;

bool IsWorse(const ComparedView& a, const ComparedView& b) {
  return a.view.error.psnr_covered_db < b.view.error.psnr_covered_db;
}

std::string Caption(const EvaluatedView& view) {
  std::array<char, 200> text;
  std::snprintf(
      text.data(), text.size(),
      "frame %d, map, difference: PSNR %.1f dB over covered pixels (%.1f with gain), %.1f dB over "
      "all, %.1f %% covered, median depth error %.1f mm",
      view.frame, view.error.psnr_covered_db, view.error.psnr_covered_by_gain_db,
      view.error.psnr_db, 100 * view.error.coverage, 1000 * view.error.depth_error_median_m);
  return text.data();
}

// Twice the colour difference, plus 128 per channel. Equal colours give 128.
Rgb8 Difference(Rgb8 a, Rgb8 b) {
  const auto of = [](int x, int y) {
    return static_cast<std::uint8_t>(std::clamp(128 + 2 * (x - y), 0, 255));
  };
  return {of(a.r, b.r), of(a.g, b.g), of(a.b, b.b)};
}

Image<Rgb8> SideBySide(const ComparedView& view) {
  const int width = view.frame.width(), height = view.frame.height();
  Image<Rgb8> picture(3 * width, height + kHeader_px, {255, 255, 255});
  DrawText(&picture, {8, kHeader_px / 2.}, Caption(view.view));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Rgb8 frame = view.frame(u, v), drawn = view.drawn(u, v);
      Rgb8* const row = picture.row(v + kHeader_px);
      row[u] = frame;
      row[u + width] = drawn;
      row[u + 2 * width] = Difference(drawn, frame);
    }
  }
  return picture;
}

std::vector<std::pair<std::string, double>> Figures(const ViewError& error) {
  return {{"psnr_covered_db", error.psnr_covered_db},
          {"psnr_covered_by_gain_db", error.psnr_covered_by_gain_db},
          {"psnr_registered_db", error.psnr_registered_db},
          {"ssim_registered", error.ssim_registered},
          {"psnr_db", error.psnr_db},
          {"ssim_covered", error.ssim_covered},
          {"ssim", error.ssim},
          {"coverage", error.coverage},
          {"depth_error_median_m", error.depth_error_median_m},
          {"depth_error_mean_m", error.depth_error_mean_m}};
}

void WriteCsv(const ViewEvaluation& evaluation, std::ostream& file) {
  file << "frame";
  for (const auto& [name, value] : Figures(evaluation.mean)) file << ',' << name;
  file << '\n' << std::fixed << std::setprecision(6);
  for (const EvaluatedView& view : evaluation.views) {
    file << view.frame;
    for (const auto& [name, value] : Figures(view.error)) {
      file << ',';
      if (!std::isnan(value)) file << value;
    }
    file << '\n';
  }
}

}  // namespace

void WorstViews::Offer(ComparedView view) {
  views_.insert(std::upper_bound(views_.begin(), views_.end(), view, IsWorse), std::move(view));
  if (views_.size() > static_cast<std::size_t>(most_)) views_.pop_back();
}

std::string WorstViews::Write(const std::string& folder) const {
  if (views_.empty()) return "";
  std::error_code error;
  std::filesystem::create_directories(folder + "/view_pictures", error);
  if (error)
    throw InputError(Concat(folder, "/view_pictures: cannot be created: ", error.message()));
  for (std::size_t i = 0; i < views_.size(); ++i) {
    WritePng(SideBySide(views_[i]), folder + "/" + ViewPictureName(static_cast<int>(i)));
  }
  return folder + "/" + ViewPictureName(0);
}

void WriteViewFiles(const ViewEvaluation& evaluation, const std::string& folder) {
  Json json;
  for (const auto& [name, value] : Figures(evaluation.mean)) json[name] = value;
  json["frames"] = evaluation.views.size();
  json["held_out"] = evaluation.held_out;
  json["frames_without_color"] = evaluation.without_color;
  WriteJson(json, folder + "/views.json");
  WriteFileAtomically(folder + "/views.csv",
                      [&](std::ostream& file) { WriteCsv(evaluation, file); });
}

}  // namespace surfit
