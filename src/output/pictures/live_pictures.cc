#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "output/pictures/canvas.h"
#include "output/pictures/pictures.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {
namespace {

constexpr Rgb8 kBackground = {70, 77, 86};  // contrasts with white and black objects
const cv::Scalar kLetters(230, 230, 230), kAlarm(205, 20, 20);

Image<Rgb8> Centered(const Image<Rgb8>& image) {
  Image<Rgb8> picture(LivePictures::kWidth, LivePictures::kHeight, kBackground);
  if (image.empty()) return picture;
  const double scale = std::min(static_cast<double>(picture.width()) / image.width(),
                                static_cast<double>(picture.height()) / image.height());
  const int width = std::max(1, std::min(picture.width(), cvRound(scale * image.width())));
  const int height = std::max(1, std::min(picture.height(), cvRound(scale * image.height())));
  const cv::Rect inside((picture.width() - width) / 2, (picture.height() - height) / 2, width,
                        height);
  DrawImage(&picture, inside, image);
  return picture;
}

// Bright text with dark outlines, readable on any background.
void WriteCaption(const std::string& text, Image<Rgb8>* picture) {
  const cv::Point place(8, 20);
  for (const auto& [ink, width] : {std::pair(cv::Scalar(0, 0, 0), 3), std::pair(kLetters, 1)}) {
    cv::putText(AsMat(picture), text, place, cv::FONT_HERSHEY_SIMPLEX, 0.5, ink, width,
                cv::LINE_AA);
  }
}

Image<Rgb8> DepthPicture(const Image<float>& depth_m) {
  constexpr float kWhite = 0.5f;  // pixels up to this depth are white, m
  Image<Rgb8> picture(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const float share = depth_m[i] > 0 ? std::min(1.f, kWhite / depth_m[i]) : 0;
    const auto grey = static_cast<std::uint8_t>(255 * share);
    picture[i] = {grey, grey, grey};
  }
  return picture;
}

// Fills one-pixel gaps between discs: a pixel with surfels on two opposite sides gets the left or
// the upper surfel.
Image<std::int32_t> WithoutHoles(const Image<std::int32_t>& ids) {
  Image<std::int32_t> filled = ids;
  const auto fill = [&](int u, int v, std::int32_t before, std::int32_t after) {
    if (before != ModelView::kNoSurfel && after != ModelView::kNoSurfel) filled(u, v) = before;
  };
  for (int v = 0; v < ids.height(); ++v) {
    for (int u = 0; u < ids.width(); ++u) {
      if (ids(u, v) != ModelView::kNoSurfel) continue;
      if (u > 0 && u + 1 < ids.width()) fill(u, v, ids(u - 1, v), ids(u + 1, v));
      if (v > 0 && v + 1 < ids.height()) fill(u, v, ids(u, v - 1), ids(u, v + 1));
    }
  }
  return filled;
}

void DrawAlarm(const std::string& text, cv::Mat picture) {
  constexpr int kBand_px = 48, kEdge_px = 8;
  cv::rectangle(picture, cv::Rect(0, 0, picture.cols, picture.rows), kAlarm, 2 * kEdge_px);
  cv::rectangle(picture, cv::Rect(0, 0, picture.cols, kBand_px), kAlarm, cv::FILLED);
  cv::putText(picture, text, cv::Point(kEdge_px, kBand_px - 15), cv::FONT_HERSHEY_SIMPLEX, 0.9,
              cv::Scalar(255, 255, 255), 2, cv::LINE_AA);
}

}  // namespace

// Renderer of the model at reduced resolution. The disc renderer is much faster than DrawBlended().
struct LivePictures::Tools {
  DepthSensor sensor;
  ModelRenderer renderer{RenderOptions()};
};

LivePictures::LivePictures(const DepthSensor& sensor) : tools_(std::make_unique<Tools>()) {
  const PinholeCamera& camera = sensor.camera;
  tools_->sensor = {camera.Subsampled(std::max(1, camera.width / kWidth)), sensor.noise};
}

LivePictures::~LivePictures() = default;

Image<Rgb8> LivePictures::OfFrame(const RgbdFrame& frame) const {
  const bool has_color = !frame.color.empty();
  Image<Rgb8> picture = Centered(has_color ? frame.color : DepthPicture(frame.depth_m));
  WriteCaption(has_color ? "frame" : "frame (depth)", &picture);
  return picture;
}

Image<Rgb8> LivePictures::OfModel(const SurfelMap& map, const Rigid3d& world_from_camera,
                                  ModelColors colors) {
  const bool normals = colors == ModelColors::kNormals;
  const SurfelColoring coloring = normals ? ColorByNormal(map) : ColorByColor(map);
  const ModelView view = tools_->renderer.Render(map, tools_->sensor, world_from_camera);
  Image<Rgb8> picture =
      Centered(ColorIndices(WithoutHoles(view.surfel_index), [&](int, int, std::int32_t id) {
        return id == ModelView::kNoSurfel ? kBackground : coloring.color_of(id);
      }));
  WriteCaption(normals ? "model, normals" : "model, colour", &picture);
  return picture;
}

Image<Rgb8> LivePictures::OfLost(const Image<Rgb8>& last_good) const {
  Image<Rgb8> picture = Centered(last_good);
  DrawAlarm("LOST: return to this view", AsMat(&picture));
  return picture;
}

}  // namespace surfit
