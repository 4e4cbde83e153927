#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "pictures/canvas.h"
#include "pictures/coloring.h"
#include "pictures/picture_view.h"
#include "surfit/mapping/blended_view.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/pictures/pictures.h"

namespace surfit {
namespace {

constexpr Rgb8 kBackground = {70, 77, 86};  // neither white nor black things are lost before it
const cv::Scalar kLetters(230, 230, 230), kPath(255, 150, 30), kCamera(255, 40, 40),
    kLoop(60, 220, 120), kAlarm(205, 20, 20);

// Fills the tile with the image at its own proportions, centred.
void Place(Image<Rgb8>* picture, const cv::Rect& tile, const Image<Rgb8>& image) {
  cv::Mat target = AsMat(picture)(tile);
  target.setTo(cv::Scalar(kBackground.r, kBackground.g, kBackground.b));
  if (image.empty()) return;
  const double scale = std::min(static_cast<double>(tile.width) / image.width(),
                                static_cast<double>(tile.height) / image.height());
  const int width = std::max(1, std::min(tile.width, cvRound(scale * image.width())));
  const int height = std::max(1, std::min(tile.height, cvRound(scale * image.height())));
  const cv::Rect inside((tile.width - width) / 2, (tile.height - height) / 2, width, height);
  const cv::Mat source(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::resize(source, target(inside), inside.size(), 0, 0, cv::INTER_AREA);
}

// Light with a dark edge: readable on any picture.
void Caption(Image<Rgb8>* picture, const cv::Rect& tile, const std::string& text) {
  const cv::Point place(tile.x + 8, tile.y + 20);
  for (const auto& [ink, width] : {std::pair(cv::Scalar(0, 0, 0), 3), std::pair(kLetters, 1)}) {
    cv::putText(AsMat(picture), text, place, cv::FONT_HERSHEY_SIMPLEX, 0.5, ink, width,
                cv::LINE_AA);
  }
}

Image<Rgb8> DepthPicture(const Image<float>& depth_m) {
  constexpr float kWhite = 0.5f;  // metres and nearer
  Image<Rgb8> picture(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const float share = depth_m[i] > 0 ? std::min(1.f, kWhite / depth_m[i]) : 0;
    const auto grey = static_cast<std::uint8_t>(255 * share);
    picture[i] = {grey, grey, grey};
  }
  return picture;
}

// Points that tell where the map is.
std::vector<Eigen::Vector3f> Thin(const SurfelMap& map) {
  constexpr std::size_t kMost = 20000;
  const std::vector<std::int32_t> ids = map.Ids();
  const std::size_t stride = (ids.size() + kMost - 1) / kMost;
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < ids.size(); i += stride) {
    points.push_back(map[ids[i]].position_in_world);
  }
  return points;
}

Image<Rgb8> OnBackground(BlendedView drawn) {
  for (std::size_t i = 0; i < drawn.color.size(); ++i) {
    if (!(drawn.depth_m[i] > 0)) drawn.color[i] = kBackground;
  }
  return std::move(drawn.color);
}

// A quarter of the pixels where it is to be quick. No sensor looks from there, and none's noise
// counts.
Image<Rgb8> DrawSurfels(const SurfelMap& map, const PictureView& view, bool coarsely) {
  const PinholeCamera camera = coarsely ? view.camera.Subsampled(2) : view.camera;
  return OnBackground(DrawBlended(map, {camera, {0}}, view.camera_from_world.Inverse()));
}

bool IsTouched(const MapOrbit& o) {
  return o.right_rad != 0 || o.up_rad != 0 || o.distance != 1 || o.follows ||
         o.shift_m != Eigen::Vector3d::Zero();
}

cv::Point Pixel(const PictureView& view, const Eigen::Vector3d& point_in_world) {
  constexpr double kFar = 1e4;  // keeps what is far outside from overflowing
  const Eigen::Vector3d p = view.camera_from_world * point_in_world;
  const Eigen::Vector2d uv = p.z() > 0 ? view.camera.Project(p) : Eigen::Vector2d(-kFar, -kFar);
  return {cvRound(std::clamp(uv.x(), -kFar, kFar)), cvRound(std::clamp(uv.y(), -kFar, kFar))};
}

void DrawPath(const PictureView& view, const Trajectory& path, cv::Mat picture) {
  std::vector<cv::Point> line;
  for (const StampedPose& pose : path) {
    line.push_back(Pixel(view, pose.world_from_camera.translation));
  }
  cv::polylines(picture, line, false, kPath, 2, cv::LINE_AA);
}

void DrawLoops(const PictureView& view, const std::vector<LoopSegment>& loops, cv::Mat picture) {
  for (const LoopSegment& loop : loops) {
    cv::line(picture, Pixel(view, loop.a), Pixel(view, loop.b), kLoop, 2, cv::LINE_AA);
  }
}

// White letters on a red band.
void DrawAlarm(const std::string& text, cv::Mat tile) {
  constexpr int kBand_px = 48, kEdge_px = 8;
  cv::rectangle(tile, cv::Rect(0, 0, tile.cols, tile.rows), kAlarm, 2 * kEdge_px);
  cv::rectangle(tile, cv::Rect(0, 0, tile.cols, kBand_px), kAlarm, cv::FILLED);
  cv::putText(tile, text, cv::Point(kEdge_px, kBand_px - 15), cv::FONT_HERSHEY_SIMPLEX, 0.9,
              cv::Scalar(255, 255, 255), 2, cv::LINE_AA);
}

// A pyramid of the camera's view, 0.3 m long.
void DrawCamera(const PictureView& view, const PinholeCamera& camera, const Rigid3d& pose,
                cv::Mat picture) {
  constexpr double kLength = 0.3;
  const cv::Point eye = Pixel(view, pose.translation);
  std::vector<cv::Point> corners;
  for (const auto& [u, v] : {std::pair(0, 0), std::pair(camera.width, 0),
                             std::pair(camera.width, camera.height), std::pair(0, camera.height)}) {
    corners.push_back(Pixel(view, pose * (kLength * camera.Ray(u, v))));
    cv::line(picture, eye, corners.back(), kCamera, 2, cv::LINE_AA);
  }
  cv::polylines(picture, corners, true, kCamera, 2, cv::LINE_AA);
}

const cv::Rect kFrameTile(0, 0, LivePicture::kTileWidth, LivePicture::kTileHeight);
const cv::Rect kModelTile(LivePicture::kTileWidth, 0, LivePicture::kTileWidth,
                          LivePicture::kTileHeight);
const cv::Rect kTextTile(0, LivePicture::kTileHeight, LivePicture::kWidth,
                         LivePicture::kTextHeight);
const cv::Rect kMapTile(0, LivePicture::kTileHeight + LivePicture::kTextHeight, LivePicture::kWidth,
                        LivePicture::kMapHeight);

}  // namespace

// What draws the model, as coarsely as still fills the tile; and the map's view that is shown.
struct LivePicture::Tools {
  Image<Rgb8> DrawNormals(const SurfelMap& map, const Rigid3d& world_from_camera) {
    const ModelView view = renderer.Render(map, sensor, world_from_camera);
    const SurfelColoring coloring = ColorByNormal(map);
    return ColorIndices(view.surfel_index, [&](int, int, std::int32_t id) {
      return id == ModelView::kNoSurfel ? kBackground : coloring.color_of(id);
    });
  }

  DepthSensor sensor;
  ModelRenderer renderer{RenderOptions()};
  LiveMapView map_view;
};

LivePicture::LivePicture(const DepthSensor& sensor)
    : tools_(std::make_unique<Tools>()), image_(kWidth, kHeight, kBackground) {
  const PinholeCamera& camera = sensor.camera;
  tools_->sensor = {camera.Subsampled(std::max(1, camera.width / kTileWidth)), sensor.noise};
}

LivePicture::~LivePicture() = default;

void LivePicture::ShowFrame(const RgbdFrame& frame) {
  const bool has_color = !frame.color.empty();
  Place(&image_, kFrameTile, has_color ? frame.color : DepthPicture(frame.depth_m));
  Caption(&image_, kFrameTile, has_color ? "frame" : "frame (depth)");
}

void LivePicture::ShowModel(const SurfelMap& map, const Rigid3d& world_from_camera,
                            ModelColors colors) {
  const bool normals = colors == ModelColors::kNormals;
  Place(&image_, kModelTile,
        normals ? tools_->DrawNormals(map, world_from_camera)
                : OnBackground(DrawBlended(map, tools_->sensor, world_from_camera)));
  Caption(&image_, kModelTile, normals ? "model, normals" : "model, colour");
}

void LivePicture::ShowLost(const Image<Rgb8>& last_good) {
  Place(&image_, kModelTile, last_good);
  DrawAlarm("LOST: go back to this view", AsMat(&image_)(kModelTile));
}

void LivePicture::ShowMap(const SurfelMap& map, const Trajectory& camera_path,
                          const std::vector<LoopSegment>& loops, bool coarsely) {
  if (map.size() == 0) return;
  const LiveMapView overview = Overview(Thin(map), camera_path, kMapTile.width, kMapTile.height);
  tools_->map_view = IsTouched(orbit_) ? Turned(overview, orbit_, camera_path) : overview;
  const PictureView& view = tools_->map_view.view;
  Place(&image_, kMapTile, DrawSurfels(map, view, coarsely));
  cv::Mat tile = AsMat(&image_)(kMapTile);
  DrawLoops(view, loops, tile);
  if (!camera_path.empty()) {
    DrawPath(view, camera_path, tile);
    DrawCamera(view, tools_->sensor.camera, camera_path.back().world_from_camera, tile);
  }
  Caption(&image_, kMapTile, orbit_.follows ? "map, following the camera" : "map");
}

void LivePicture::DragMap(double right_px, double down_px) {
  const PictureView& view = tools_->map_view.view;
  if (view.camera.fx <= 0) return;  // none is shown yet
  const double distance = (view.camera_from_world * tools_->map_view.target).norm();
  const Eigen::Vector3d in_camera(-right_px, -down_px, 0);
  orbit_.shift_m +=
      distance / view.camera.fx * (view.camera_from_world.rotation.conjugate() * in_camera);
}

void LivePicture::ShowText(const std::string& first, const std::string& second) {
  Place(&image_, kTextTile, {});
  Caption(&image_, kTextTile, first);
  Caption(&image_, kTextTile + cv::Point(0, kTextHeight / 2 - 4), second);
}

}  // namespace surfit
