#include "apps/export/export_run.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>

#include "apps/export/colmap_files.h"
#include "apps/export/color_lens.h"
#include "apps/export/export_images.h"
#include "apps/export/gaussians.h"
#include "apps/export/map_visibility.h"
#include "apps/export/moving_masks.h"
#include "apps/export/nerfstudio_files.h"
#include "apps/export/occupancy.h"
#include "apps/export/sparse_points.h"
#include "io/files/output_folder.h"
#include "io/images/image_files.h"
#include "mapping/rendering/blended_view.h"
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

class Exporter {
 public:
  Exporter(const ExportOptions& options, const std::function<void(const std::string&)>& progress)
      : options_(options), log_(progress), run_(ReadRecordedRun(options.run)) {
    RequireOtherFolder(options);
    map_.Append(ReadSurfelPly(options.run + "/map.ply"));
    ThrowIf(map_.size() == 0, options.run, "/map.ply: the map is empty");
    surfels_ = ReliableSurfels(map_);
    ThrowIf(surfels_.empty(), options.run, "/map.ply: no surfel has a finite position");
    ThrowIf(run_.trajectory.empty(), options.run, "/poses.json: the run has no poses");
    folder_.emplace(options.output, FormerFiles(options.output));
  }

  ExportSummary Export() {
    log_.json["format"] = options_.to;
    log_.json["run"] = options_.run;
    FindWorld();
    if (options_.to == "colmap") ExportColmap();
    if (options_.to == "nerfstudio") ExportNerfstudio();
    if (options_.to == "gaussians") ExportGaussians();
    if (options_.to == "occupancy") ExportOccupancy();
    WriteJson(log_.json, Path(kExportJson));
    return log_.summary;
  }

 private:
  std::string Path(const std::string& name) const { return options_.output + "/" + name; }

  void FindWorld() {
    Json& world = log_.json["world"];
    world["up"] = nullptr;
    if (options_.world == "run") {
      world["source"] = "run";
    } else {
      log_.Progress("looking for floor and walls");
      const UprightResult found = FindUpright(surfels_, run_.trajectory);
      if (!found.world) {
        reason_ = found.reason;
        world["source"] = "run";
        world["reason"] = found.reason;
        if (options_.to != "occupancy") {
          log_.Warn("the world frame stays that of the run: ", found.reason);
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
        log_.Say("upright: z is up within ", DegreesText(upright.sigma_rad), " (one sigma), from ",
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

  // COLMAP ignores cameras with a larger distortion coefficient (Mapper.max_extra_param).
  bool IsRefusedByColmap() const {
    constexpr double kMaxCoefficient = 1;
    const auto& distortion = images_.camera.lens.distortion;
    return options_.to == "colmap" &&
           std::any_of(distortion.begin(), distortion.end(),
                       [](double c) { return std::abs(c) > kMaxCoefficient; });
  }
  bool WritesUndistorted() const { return options_.undistort || IsRefusedByColmap(); }
  PinholeCamera ImageCamera() const {
    return WritesUndistorted() ? UndistortedCamera(images_.camera.lens) : images_.camera.lens;
  }

  void WriteImages(const PinholeCamera& lens) {
    CreateFolder(Path("images"));
    const std::vector<ColorImage> sources = images_.Sources();
    ReadColorImages(options_.sequence, sources, [&](std::size_t i, const Image<Rgb8>& color) {
      log_.Progress("writing images, ", i);
      const Image<Rgb8> written =
          WritesUndistorted() ? Undistort(color, images_.camera.lens, lens) : color;
      WriteBytes("images/" + sources[i].Name(), EncodePng(written));
    });
  }

  void WriteBytes(const std::string& name, const std::string& bytes) const {
    WriteFileAtomically(Path(name), [&](std::ostream& out) {
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    });
  }

  void ExportColmap() {
    images_ = PrepareImages(options_, run_, map_, options_.images, &log_);
    if (IsRefusedByColmap() && !options_.undistort) {
      log_.Say(
          "images are undistorted: COLMAP ignores cameras with a distortion coefficient above 1");
    }
    const PinholeCamera lens = ImageCamera();
    log_.Progress("projecting points");
    const SparsePoints points = FindSparsePoints(map_, lens, images_.posed);
    CreateFolder(Path("sparse/0"));
    CreateFolder(Path("sparse_text"));
    WriteColmapModel({lens, images_.posed, points, export_from_world_}, Path("sparse/0"),
                     Path("sparse_text"));
    WriteImages(lens);
    log_.json["points"] = {{"written", points.points.size()},
                           {"in_fewer_than_two_images", points.unseen}};
    log_.Say(points.points.size(), " points; ", points.unseen,
             " in fewer than two images are left out");
  }

  void ExportNerfstudio() {
    images_ = PrepareImages(options_, run_, map_, options_.images, &log_);
    const PinholeCamera lens = ImageCamera();
    WriteImages(lens);
    CreateFolder(Path("depth"));
    for (const PosedImage& image : images_.posed) {
      log_.Progress("rendering depth, frame ", image.source.index);
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
    WriteTransformsJson(lens, images_.posed, has_masks, export_from_world_,
                        Path("transforms.json"));
    log_.json["points"] = {{"written", cloud.points.size()}};
    log_.Say(cloud.points.size(), " points in points.ply");
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
        MaskOfColor(in_front, depth_m, sensor.camera, by_estimate, images_.camera.lens);
    const Rigid3d as_given = images_.given_camera.color_from_depth *
                             image.source.world_from_depth.Inverse() * world_from_depth;
    const Image<std::uint8_t> given =
        MaskOfColor(in_front, depth_m, sensor.camera, as_given, images_.given_camera.lens);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = std::min(mask[i], given[i]);
    return WritesUndistorted() ? UndistortMask(mask, images_.camera.lens, lens) : mask;
  }

  // nerfstudio needs masks of all images or of none. Returns whether masks are written: an object
  // in an image is not part of the map.
  bool WriteMasks(const PinholeCamera& lens) {
    const std::vector<ColorImage> sources = images_.Sources();
    std::vector<Image<std::uint8_t>> masks;
    int with_object = 0;
    const DepthSensor sensor = OpenSequence(options_.sequence)->info().sensor();
    ReadDepthImages(options_.sequence, sources, [&](std::size_t i, const Image<float>& depth_m) {
      log_.Progress("looking for moving objects, ", i);
      masks.push_back(MaskOf(images_.posed[i], depth_m, sensor, lens));
      with_object += std::count(masks.back().begin(), masks.back().end(), 0) > 0;
    });
    log_.json["images"]["with_moving_objects"] = with_object;
    if (with_object == 0) return false;
    log_.Say(with_object, " images show objects that are not part of the map: see masks");
    CreateFolder(Path("masks"));
    for (std::size_t i = 0; i < masks.size(); ++i) {
      WriteBytes("masks/" + sources[i].Name(), EncodePng(masks[i]));
    }
    return true;
  }

  void ExportGaussians() {
    std::vector<Gaussian> gaussians = GaussiansOf(surfels_);
    try {
      images_ = PrepareImages(options_, run_, map_, kImagesOfGaussians, &log_);
      FitColors(
          ViewsOfGaussians(),
          [&](int drawn, int all) { log_.Progress("fitting colours, view ", drawn, " of ", all); },
          &gaussians);
    } catch (const InputError& error) {
      log_.Warn("the Gaussians have the colours of the map, because no images are usable: ",
                error.what());
    }
    WriteGaussians(gaussians, export_from_world_, Path("splats.ply"));
    log_.json["gaussians"] = {{"written", surfels_.size()},
                              {"noise", map_.size() - surfels_.size()}};
    log_.Say(surfels_.size(), " Gaussians; ", map_.size() - surfels_.size(),
             " surfels of low confidence are left out");
  }

  std::vector<GaussianView> ViewsOfGaussians() const {
    const PinholeCamera camera = UndistortedCamera(images_.camera.lens);
    const std::vector<ColorImage> sources = images_.Sources();
    std::vector<GaussianView> views;
    ReadColorImages(options_.sequence, sources, [&](std::size_t i, const Image<Rgb8>& color) {
      views.push_back(ReducedView(Undistort(color, images_.camera.lens, camera), camera,
                                  images_.posed[i].world_from_color));
    });
    return views;
  }

  void ExportOccupancy() {
    ThrowIf(!is_upright_, "an occupancy map needs an upright world: ",
            reason_.empty() ? "--world is run, must be upright" : reason_);
    const UprightMap map = UprightMapOf(surfels_, run_, export_from_world_);
    log_.Progress("tracing rays");
    const OccupancyGrid grid = MakeOccupancyGrid(map);
    const std::vector<WallLine> walls = FindWallLines(map, grid);
    WriteRosMap(grid, options_.output);
    WriteFloorPlan(grid, walls, map.path, Path("floor_plan.svg"));
    const auto count = [&](CellState state) {
      return std::count(grid.cells.begin(), grid.cells.end(), state);
    };
    log_.json["grid"] = {
        {"columns", grid.cells.width()},   {"rows", grid.cells.height()},
        {"cell_m", grid.cell_m},           {"occupied", count(CellState::kOccupied)},
        {"free", count(CellState::kFree)}, {"walls", walls.size()}};
    log_.Say(grid.cells.width(), " x ", grid.cells.height(), " cells of ", grid.cell_m,
             " m, heights ", grid.low_m, " to ", grid.high_m, " m: ", count(CellState::kOccupied),
             " occupied, ", count(CellState::kFree), " free; ", walls.size(), " walls");
  }

  const ExportOptions& options_;
  ExportLog log_;
  const RecordedRun run_;
  SurfelMap map_;
  std::vector<Surfel> surfels_;  // without noise
  std::optional<OutputFolder> folder_;
  Rigid3d export_from_world_;
  bool is_upright_ = false;
  std::string reason_;  // why the world frame of the run is kept
  ExportImages images_;
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
