#include "apps/export/export_run.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "apps/export/colmap_files.h"
#include "apps/export/color_calibration.h"
#include "apps/export/color_images.h"
#include "apps/export/color_lens.h"
#include "apps/export/gaussian_colors.h"
#include "apps/export/gaussians.h"
#include "apps/export/image_poses.h"
#include "apps/export/map_visibility.h"
#include "apps/export/moving_masks.h"
#include "apps/export/nerfstudio_files.h"
#include "apps/export/occupancy.h"
#include "apps/export/sparse_points.h"
#include "io/files/output_folder.h"
#include "io/images/image_files.h"
#include "output/output_files.h"
#include "output/pictures/pictures.h"
#include "output/recorded_run.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExportJson = "export.json";
constexpr int kImagesOfGaussians = 48;  // the colours of Gaussians are fitted to them

// Relative paths of the results. Numbered images belong to a former export only if the folder has
// an export.json.
std::vector<std::string> FormerFiles(const std::string& folder) {
  std::vector<std::string> files = {kExportJson,
                                    "transforms.json",
                                    "points.ply",
                                    "splats.ply",
                                    "map.pgm",
                                    "map.yaml",
                                    "floor_plan.svg",
                                    "sparse/0/cameras.bin",
                                    "sparse/0/images.bin",
                                    "sparse/0/points3D.bin",
                                    "sparse_text/cameras.txt",
                                    "sparse_text/images.txt",
                                    "sparse_text/points3D.txt"};
  if (!fs::is_regular_file(folder + "/" + kExportJson)) return files;
  for (const std::string part : {"images", "depth", "masks"}) {
    std::error_code error;
    for (const fs::directory_entry& entry :
         fs::directory_iterator(Concat(folder, "/", part), error)) {
      const std::string stem = entry.path().stem().string();
      const bool is_number = !stem.empty() && std::all_of(stem.begin(), stem.end(), [](char c) {
        return std::isdigit(static_cast<unsigned char>(c)) != 0;
      });
      if (is_number && entry.path().extension() == ".png") {
        files.push_back(part + "/" + entry.path().filename().string());
      }
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Results must not replace images of the sequence, which has the same folder names.
void RequireOtherFolder(const ExportOptions& options) {
  for (const std::string& input : {options.sequence.path, options.run}) {
    std::error_code error;
    ThrowIf(!input.empty() && fs::equivalent(input, options.output, error), "--output is ",
            options.output, ", must be another folder than the input");
  }
}

std::string Degrees(double rad) {
  return Concat(std::round(100 * rad / kRadPerDeg) / 100, " degrees");
}

class Exporter {
 public:
  Exporter(const ExportOptions& options, const std::function<void(const std::string&)>& progress)
      : options_(options), progress_(progress), run_(ReadRecordedRun(options.run)) {
    RequireOtherFolder(options);
    map_.Append(ReadSurfelPly(options.run + "/map.ply"));
    ThrowIf(map_.size() == 0, options.run, "/map.ply: the map is empty");
    surfels_ = ReliableSurfels(map_);
    ThrowIf(surfels_.empty(), options.run, "/map.ply: no surfel has a finite position");
    ThrowIf(run_.trajectory.empty(), options.run, "/poses.json: the run has no poses");
    folder_.emplace(options.output, FormerFiles(options.output));
  }

  ExportSummary Export() {
    json_["format"] = options_.to;
    json_["run"] = options_.run;
    FindWorld();
    if (options_.to == "colmap") ExportColmap();
    if (options_.to == "nerfstudio") ExportNerfstudio();
    if (options_.to == "gaussians") ExportGaussians();
    if (options_.to == "occupancy") ExportOccupancy();
    WriteJson(json_, Path(kExportJson));
    return summary_;
  }

 private:
  template <typename... Parts>
  void Say(const Parts&... parts) {
    summary_.messages.push_back(Concat(parts...));
  }
  template <typename... Parts>
  void Warn(const Parts&... parts) {
    summary_.warnings.push_back(Concat(parts...));
  }
  std::string Path(const std::string& name) const { return options_.output + "/" + name; }

  void FindWorld() {
    Json& world = json_["world"];
    world["up"] = nullptr;
    if (options_.world == "run") {
      world["source"] = "run";
    } else {
      progress_("looking for floor and walls");
      const UprightResult found = FindUpright(surfels_, run_.trajectory);
      if (!found.world) {
        reason_ = found.reason;
        world["source"] = "run";
        world["reason"] = found.reason;
        if (options_.to != "occupancy") {
          Warn("the world frame stays that of the run: ", found.reason);
        }
      } else {
        const UprightWorld& upright = *found.world;
        export_from_world_ = upright.upright_from_world;
        is_upright_ = true;
        world["source"] = "floor and walls of the map";
        world["up"] = "z";
        world["gravity_sigma_deg"] = upright.sigma_rad / kRadPerDeg;
        world["horizontal_planes"] = upright.horizontal_planes;
        world["horizontal_area_m2"] = upright.horizontal_area_m2;
        world["walls"] = upright.walls;
        world["walls_give_axes"] = upright.walls_give_axes;
        world["floor_area_m2"] = upright.floor_area_m2;
        Say("upright: z is up within ", Degrees(upright.sigma_rad), " (one sigma), from ",
            upright.horizontal_planes, " horizontal planes and ", upright.walls,
            " walls of the map; the lowest horizontal plane (",
            std::round(100 * upright.floor_area_m2) / 100, " m2) is at z = 0",
            upright.walls_give_axes ? "; walls are along x and y" : "");
      }
    }
    Json rows = Json::array();
    const Eigen::Matrix4d matrix = export_from_world_.Matrix();
    for (int i = 0; i < 4; ++i) {
      rows.push_back({matrix(i, 0), matrix(i, 1), matrix(i, 2), matrix(i, 3)});
    }
    world["export_from_run"] = rows;
  }

  // At most `most` colour images with poses, and the colour camera. Gaussians have the colours of
  // the map, so their camera is that of the run.
  void PrepareImages(int most) {
    UnusedFrames unused;
    const SequenceInfo info = OpenSequence(options_.sequence)->info();
    RequireCameraOfFrames(run_, options_.run, info.pinhole);
    std::vector<ColorImage> all = ListColorImages(
        options_.sequence, run_, [&](int i) { progress_(Concat("reading images, ", i)); }, &unused);
    ThrowIf(all.empty(), options_.run, ": no frame has both colour and a pose");
    ColorCalibration found;
    found.camera = camera_ = given_camera_ = GivenColorCamera(info, run_);
    if (options_.to != "gaussians") {
      found = EstimateColorCamera(
          found.camera, info.sensor().prior, options_.sequence, all, map_,
          [&](int i) { progress_(Concat("estimating the colour camera, ", i)); });
      camera_ = found.camera;
      Report(found);
    }
    const std::vector<ColorImage> chosen = ChooseImages(all, most);
    unused.not_chosen = static_cast<int>(all.size() - chosen.size());
    for (const ColorImage& image : chosen) {
      const Rigid3d world_from_depth = ExtrapolatedTo(image, -found.latency_s);
      images_.push_back({image, world_from_depth * camera_.color_from_depth.Inverse()});
      images_.back().source.stamp_s -= found.latency_s;
    }
    if (options_.to != "gaussians") RegisterToEachOther();
    json_["images"] = {{options_.to == "gaussians" ? "used" : "written", images_.size()},
                       {"not_chosen", unused.not_chosen},
                       {"without_color", unused.without_color},
                       {"unreadable", unused.unreadable},
                       {"repeated", unused.repeated},
                       {"without_pose_at_time", unused.without_pose_at_time}};
    Say(images_.size(), " images of ", run_.trajectory.size(), " frames with poses; ",
        unused.not_chosen, " not chosen, ", unused.repeated, " repeat the previous image, ",
        unused.without_color, " without colour, ", unused.unreadable, " unreadable, ",
        unused.without_pose_at_time, " without a pose at the time of the image");
  }

  void RegisterToEachOther() {
    const ImageRegistration found = RegisterImages(
        camera_, map_,
        [&](const std::vector<ColorImage>& sources, const auto& call) {
          ReadColorImages(options_.sequence, sources, call);
        },
        [&](int i) { progress_(Concat("registering images, ", i)); }, &images_);
    json_["registration"] = {{"registered", found.registered},
                             {"too_few_surfels", found.too_few_surfels},
                             {"contradicting", found.contradicting},
                             {"without_gain", found.without_gain},
                             {"median_change_m", found.median_change_m},
                             {"median_change_rad", found.median_change_rad},
                             {"rms_log_brightness", {found.rms_before, found.rms_after}}};
    Say(found.registered, " images registered to each other, median change ",
        std::round(1e4 * found.median_change_m) / 10, " mm and ", Degrees(found.median_change_rad),
        "; ", found.too_few_surfels + found.contradicting + found.without_gain,
        " keep the tracked pose");
  }

  // Pose of the depth camera `seconds` after the time of the image.
  Rigid3d ExtrapolatedTo(const ColorImage& image, double seconds) const {
    constexpr double kMaxGap_s = 0.1, kSameTime_s = 1e-9;
    if (seconds == 0) return image.world_from_depth;
    if (const auto pose =
            InterpolatePose(run_.trajectory, image.stamp_s + seconds, kMaxGap_s, kSameTime_s)) {
      return *pose;
    }
    const Rigid3d motion(QuaternionExp<double>(seconds * image.motion.angular_velocity_rad_per_s),
                         seconds * image.motion.velocity_m_per_s);
    return image.world_from_depth * motion;
  }

  void Report(const ColorCalibration& found) {
    const PinholeCamera& lens = camera_.lens;
    const Rigid3d& mount = camera_.color_from_depth;
    Json& json = json_["color_camera"];
    json = CameraToJson(lens);
    json["distortion"] = lens.distortion;
    json["color_from_depth"] = ToJson(mount);
    json["estimated"] = found.is_estimated;
    json["latency_s"] = run_.found.color_latency_s + found.latency_s;
    json["change"] = std::vector<double>(found.change.begin(), found.change.end());
    json["sigmas"] = std::vector<double>(found.sigmas.begin(), found.sigmas.end());
    json["distance2"] = found.distance2;
    json["limit2"] = found.limit2;
    json["rms_log_brightness"] = {found.rms_before, found.rms_after};
    json["images"] = found.images;
    json["observations"] = found.observations;
    if (!found.is_estimated) {
      Say("colour camera as given", found.images == 0 ? ": too few images or surfels to estimate it"
                                                      : ", confirmed by the images");
      return;
    }
    Say("colour camera estimated from ", found.images, " images: fx ", lens.fx, ", fy ", lens.fy,
        ", cx ", lens.cx, ", cy ", lens.cy, " px; its pose changes by ",
        1000 * found.change.segment<3>(3).norm(), " mm and ",
        Degrees(found.change.head<3>().norm()), ", its latency by ", 1000 * found.latency_s, " ms");
  }

  // COLMAP ignores cameras with a larger distortion coefficient (Mapper.max_extra_param).
  bool IsRefusedByColmap() const {
    constexpr double kMaxCoefficient = 1;
    const auto& distortion = camera_.lens.distortion;
    return options_.to == "colmap" &&
           std::any_of(distortion.begin(), distortion.end(),
                       [](double c) { return std::abs(c) > kMaxCoefficient; });
  }
  bool WritesUndistorted() const { return options_.undistort || IsRefusedByColmap(); }
  PinholeCamera ImageCamera() const {
    return WritesUndistorted() ? UndistortedCamera(camera_.lens) : camera_.lens;
  }

  void WriteImages(const PinholeCamera& lens) {
    CreateFolder(Path("images"));
    std::vector<ColorImage> sources;
    for (const PosedImage& image : images_) sources.push_back(image.source);
    ReadColorImages(options_.sequence, sources, [&](std::size_t i, const Image<Rgb8>& color) {
      progress_(Concat("writing images, ", i));
      const Image<Rgb8> written =
          WritesUndistorted() ? Undistort(color, camera_.lens, lens) : color;
      WriteBytes("images/" + sources[i].Name(), EncodePng(written));
    });
  }

  void WriteBytes(const std::string& name, const std::string& bytes) const {
    WriteFileAtomically(Path(name), [&](std::ostream& out) {
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    });
  }

  void ExportColmap() {
    PrepareImages(options_.images);
    if (IsRefusedByColmap() && !options_.undistort) {
      Say("images are undistorted: COLMAP ignores cameras with a distortion coefficient above 1");
    }
    const PinholeCamera lens = ImageCamera();
    progress_("projecting points");
    const SparsePoints points = FindSparsePoints(map_, lens, images_);
    CreateFolder(Path("sparse/0"));
    CreateFolder(Path("sparse_text"));
    WriteColmapModel({lens, images_, points, export_from_world_}, Path("sparse/0"),
                     Path("sparse_text"));
    WriteImages(lens);
    json_["points"] = {{"written", points.points.size()},
                       {"in_fewer_than_two_images", points.unseen}};
    Say(points.points.size(), " points; ", points.unseen, " in fewer than two images are left out");
  }

  void ExportNerfstudio() {
    PrepareImages(options_.images);
    const PinholeCamera lens = ImageCamera();
    WriteImages(lens);
    CreateFolder(Path("depth"));
    for (const PosedImage& image : images_) {
      progress_("rendering depth, frame " + std::to_string(image.source.index));
      WriteBytes("depth/" + image.source.Name(),
                 EncodePng(DepthForImage(map_, lens, image.world_from_color)));
    }
    constexpr std::size_t kMaxPoints = 200000;
    PointCloud cloud;
    for (const Surfel& surfel : ThinOut(surfels_, kMaxPoints)) {
      cloud.points.emplace_back(
          (export_from_world_ * surfel.position_in_world.cast<double>()).cast<float>());
      cloud.normals.emplace_back(export_from_world_.rotation.cast<float>() *
                                 surfel.normal_in_world);
      cloud.colors.push_back(surfel.color);
    }
    WritePly(cloud, Path("points.ply"));
    const bool has_masks = WriteMasks(lens);
    WriteTransformsJson(lens, images_, has_masks, export_from_world_, Path("transforms.json"));
    json_["points"] = {{"written", cloud.points.size()}};
    Say(cloud.points.size(), " points in points.ply");
  }

  // Mask of an image. The given and the estimated colour camera both contribute to the mask.
  // A large mask is better than a small one, because masked pixels are not used.
  Image<std::uint8_t> MaskOf(const PosedImage& image, const Image<float>& depth_m,
                             const DepthSensor& sensor, const PinholeCamera& lens) const {
    const Rigid3d& world_from_depth = run_.world_from_camera.at(image.source.index);
    const Image<std::uint8_t> in_front =
        PixelsInFront(depth_m, DrawBlended(map_, sensor, world_from_depth).depth_m);
    const Rigid3d by_estimate = image.world_from_color.Inverse() * world_from_depth;
    Image<std::uint8_t> mask =
        MaskOfColor(in_front, depth_m, sensor.camera, by_estimate, camera_.lens);
    const Rigid3d as_given =
        given_camera_.color_from_depth * image.source.world_from_depth.Inverse() * world_from_depth;
    const Image<std::uint8_t> given =
        MaskOfColor(in_front, depth_m, sensor.camera, as_given, given_camera_.lens);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = std::min(mask[i], given[i]);
    return WritesUndistorted() ? UndistortMask(mask, camera_.lens, lens) : mask;
  }

  // nerfstudio needs masks of all images or of none. Returns whether masks are written: an object
  // in an image is not part of the map.
  bool WriteMasks(const PinholeCamera& lens) {
    std::vector<ColorImage> sources;
    for (const PosedImage& image : images_) sources.push_back(image.source);
    std::vector<Image<std::uint8_t>> masks;
    int with_object = 0;
    const DepthSensor sensor = OpenSequence(options_.sequence)->info().sensor();
    ReadDepthImages(options_.sequence, sources, [&](std::size_t i, const Image<float>& depth_m) {
      progress_(Concat("looking for moving objects, ", i));
      masks.push_back(MaskOf(images_[i], depth_m, sensor, lens));
      with_object += std::count(masks.back().begin(), masks.back().end(), 0) > 0;
    });
    json_["images"]["with_moving_objects"] = with_object;
    if (with_object == 0) return false;
    Say(with_object, " images show objects that are not part of the map: see masks");
    CreateFolder(Path("masks"));
    for (std::size_t i = 0; i < masks.size(); ++i) {
      WriteBytes("masks/" + sources[i].Name(), EncodePng(masks[i]));
    }
    return true;
  }

  void ExportGaussians() {
    std::vector<Gaussian> gaussians = GaussiansOf(surfels_);
    try {
      PrepareImages(kImagesOfGaussians);
      FitColors(
          ViewsOfGaussians(),
          [&](int drawn, int all) {
            progress_(Concat("fitting colours, view ", drawn, " of ", all));
          },
          &gaussians);
    } catch (const InputError& error) {
      images_.clear();
      Warn("the Gaussians have the colours of the map, because no images are usable: ",
           error.what());
    }
    WriteGaussians(gaussians, export_from_world_, Path("splats.ply"));
    json_["gaussians"] = {{"written", surfels_.size()}, {"noise", map_.size() - surfels_.size()}};
    Say(surfels_.size(), " Gaussians; ", map_.size() - surfels_.size(),
        " surfels of low confidence are left out");
  }

  std::vector<GaussianView> ViewsOfGaussians() const {
    const PinholeCamera camera = UndistortedCamera(camera_.lens);
    std::vector<ColorImage> sources;
    for (const PosedImage& image : images_) sources.push_back(image.source);
    std::vector<GaussianView> views;
    ReadColorImages(options_.sequence, sources, [&](std::size_t i, const Image<Rgb8>& color) {
      views.push_back(
          ReducedView(Undistort(color, camera_.lens, camera), camera, images_[i].world_from_color));
    });
    return views;
  }

  void ExportOccupancy() {
    ThrowIf(!is_upright_, "an occupancy map needs an upright world: ",
            reason_.empty() ? "--world is run, must be upright" : reason_);
    const UprightMap map = UprightMapOf(surfels_, run_, export_from_world_);
    progress_("tracing rays");
    const OccupancyGrid grid = MakeOccupancyGrid(map);
    const std::vector<WallLine> walls = FindWallLines(map, grid);
    WriteRosMap(grid, options_.output);
    WriteFloorPlan(grid, walls, map.path, Path("floor_plan.svg"));
    const auto count = [&](CellState state) {
      return std::count(grid.cells.begin(), grid.cells.end(), state);
    };
    json_["grid"] = {{"columns", grid.cells.width()},   {"rows", grid.cells.height()},
                     {"cell_m", grid.cell_m},           {"occupied", count(CellState::kOccupied)},
                     {"free", count(CellState::kFree)}, {"walls", walls.size()}};
    Say(grid.cells.width(), " x ", grid.cells.height(), " cells of ", grid.cell_m, " m, heights ",
        grid.low_m, " to ", grid.high_m, " m: ", count(CellState::kOccupied), " occupied, ",
        count(CellState::kFree), " free; ", walls.size(), " walls");
  }

  const ExportOptions& options_;
  const std::function<void(const std::string&)>& progress_;
  const RecordedRun run_;
  SurfelMap map_;
  std::vector<Surfel> surfels_;  // without noise
  std::optional<OutputFolder> folder_;
  Rigid3d export_from_world_;
  bool is_upright_ = false;
  std::string reason_;  // why the world frame of the run is kept
  ColorCamera camera_, given_camera_;
  std::vector<PosedImage> images_;
  Json json_;
  ExportSummary summary_;
};

}  // namespace

ExportSummary ExportRun(const ExportOptions& options,
                        const std::function<void(const std::string&)>& progress) {
  Validate(options);
  ThrowIf(options.to.empty(), "to is '', must be one of ", OptionToText(ExportFormatNames()));
  const ThreadLimit limit(options.threads);
  return Exporter(options, progress).Export();
}

}  // namespace surfit
