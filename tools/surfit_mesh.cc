// Creates a triangle mesh of a map.

#include <cstdio>
#include <filesystem>

#include "common/console.h"
#include "common/recorded_flags.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "mesh/texture/texture_frames.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/io/sequence.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string run, map, output;
  MeshOptions mesh;
  TextureOptions texture;
  SequenceOptions sequence;
  int threads = 2;

  void Visit(OptionVisitor& v) {
    v.Add(run, SharedOption("run", Everyday()));
    v.Add(map, SharedOption("map", Everyday()));
    v.Add(output, SharedOption("output", Required(), Everyday()));
    v.AddPart(mesh, "mesh", "resolution and extent of the mesh");
    v.AddPart(texture, "texture", "texture");
    v.AddPart(sequence, "sequence", "sequence of the run, with the same options", OptionalPart());
    v.Add(threads, SharedOption("threads", Everyday()));
  }

  bool HasTexture() const {
    return !run.empty() && texture.max_texture_px > 0 &&
           std::filesystem::path(output).extension() != ".ply";
  }
};

void Print(const Options& options, const PointCloud& cloud, std::size_t not_finite,
           const TriangleMesh& mesh, const MeshSummary& summary) {
  std::printf("%s: %zu points, %zu not finite; %zu vertices, %zu triangles in %zu pieces, %.1f MB",
              options.output.c_str(), cloud.points.size(), not_finite, mesh.vertices.size(),
              mesh.triangles.size(), summary.pieces,
              1e-6 * static_cast<double>(std::filesystem::file_size(options.output)));
  if (summary.components_dropped > 0) {
    std::printf("; removed %zu pieces smaller than %g m, with %zu triangles",
                summary.components_dropped, options.mesh.min_component_m,
                summary.triangles_dropped);
  }
  if (summary.decimation_m > 0) {
    std::printf("; decimated from %zu triangles, which moved the surface by %.2f mm",
                summary.triangles_found, 1e3 * summary.decimation_m);
  }
  if (options.mesh.watertight) {
    std::printf(
        "; watertight: %zu holes filled with %zu triangles in unobserved areas, longest hole "
        "boundary "
        "%.2f m, %zu triangles removed",
        summary.holes_filled, summary.triangles_added, summary.longest_hole_perimeter_m,
        summary.triangles_cut);
  }
  std::printf(
      "; half of the points are within %.2f mm of the mesh, 90 %% within %.2f mm, %.1f %% have no "
      "surface nearby\n",
      1e3 * summary.median_distance_m, 1e3 * summary.p90_distance_m, 100 * (1 - summary.covered));
}

void Print(const MeshTexture& texture, const TextureSummary& summary) {
  std::printf(
      "texture: %d x %d texels, %.2f texels per pixel, from %d of %d frames in %zu charts; %zu "
      "triangles that no frame observes have the colours of the map\n",
      texture.image.width(), texture.image.height(), summary.pixel_ratio, summary.frames_used,
      summary.frames, summary.charts, summary.triangles_unseen);
}

// Sets the map and the options of the sequence of the run.
void Prepare(Options* options) {
  if (options->run.empty()) {
    RequireFlag("map or --run", options->map);
    return;
  }
  if (options->map.empty()) options->map = options->run + "/map.ply";
  ApplyRecordedFlags(options->run, TableOf(&options->sequence), {}, RecordedCamera::kGiven);
}

MeshTexture MakeTexture(const Options& options, const TriangleMesh& mesh, ProgressLine* progress,
                        TextureSummary* summary) {
  const TextureFrames frames =
      TextureFramesOf(options.run, options.sequence, options.texture.max_texture_frames);
  const char* stage = "reading frames, ";
  const auto shown = [&](const auto& visit) {
    int count = 0;
    frames([&](const TextureFrame& frame) {
      progress->Show(Concat(stage, ++count), false);
      visit(frame);
    });
    stage = "rendering the texture, frame ";
  };
  return TextureMesh(mesh, shown, options.texture, summary);
}

int Run(const Options& options) {
  RequireMeshEnding(options.output);
  const ThreadLimit limit(options.threads);
  ProgressLine progress;
  progress.Show("reading the map", false);
  PointCloud cloud = ReadPointCloud(options.map);
  const std::size_t not_finite = RemoveNonFinite(&cloud);
  MeshSummary summary;
  const auto show = [&](const std::string& stage, double share) {
    progress.Show(Concat(static_cast<int>(100 * share), " %  ", stage), false);
  };
  const TriangleMesh mesh = MeshSurfels(cloud, options.mesh, &summary, show);
  MeshTexture texture;
  TextureSummary texture_summary;
  if (options.HasTexture()) {
    texture = MakeTexture(options, mesh, &progress, &texture_summary);
    WriteMesh(mesh, texture, options.output);
  } else {
    WriteMesh(mesh, options.output);
  }
  progress.Show(Concat("done in ", static_cast<int>(progress.elapsed_s()), " s"), true);
  Print(options, cloud, not_finite, mesh, summary);
  if (options.HasTexture()) Print(texture, texture_summary);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "creates a coloured triangle mesh of a map: the surface of its surfels, smoothed by their "
      "noise and confidence, with holes in unobserved areas. --output is a .ply, .obj or .glb "
      "file. "
      "The map is --map, or the map of --run; .obj and .glb of a run have a texture of its "
      "sharpest "
      "frames",
      surfit::tools::Run, surfit::tools::Prepare);
}
