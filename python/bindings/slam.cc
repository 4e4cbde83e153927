// SLAM, frame by frame.
#include <array>
#include <filesystem>
#include <functional>

#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/slam_session.h"

namespace surfit::python {
namespace {

void BindProcess(py::class_<SlamSession>* slam) {
  slam->def(
      "process",
      [](SlamSession& session, const Frame& frame, std::optional<Rigid3d> world_from_camera) {
        return session.Process(frame, world_from_camera);
      },
      py::arg("frame"), py::kw_only(), py::arg("world_from_camera") = py::none(),
      "Tracks and fuses the next frame. With world_from_camera, fuses it at this pose.");
  slam->def(
      "process",
      [](SlamSession& session, const py::object& color, const py::array& depth, double stamp_s,
         std::optional<int> index, std::optional<Rigid3d> world_from_camera) {
        return session.Process(color, depth, stamp_s, index, world_from_camera);
      },
      py::arg("color"), py::arg("depth"), py::arg("stamp_s"), py::kw_only(),
      py::arg("index") = py::none(), py::arg("world_from_camera") = py::none(),
      "Processes arrays, as in Frame, with the camera of the constructor. index: None for the "
      "index "
      "after the last frame.");
  slam->def(
      "on_pose",
      [](SlamSession& session,
         const std::function<void(int, double, std::optional<Rigid3d>)>& call) {
        if (!call) return session.OnPose(nullptr);
        session.OnPose([call](const FrameReport& pose) {
          const bool is_lost = pose.state == FrameState::kLost;
          call(pose.index, pose.stamp_s,
               is_lost ? std::nullopt : std::optional<Rigid3d>(pose.world_from_camera));
        });
      },
      py::arg("call").none(true),
      "Sets a callback: call(index, stamp_s, world_from_camera) is called for each frame before "
      "its "
      "fusion. The pose of a lost frame is None. The callback must not call this Slam. Its "
      "exceptions are raised at the end of process(). None removes the callback.");
}

void BindResults(py::class_<SlamSession>* slam) {
  slam->def_property_readonly("trajectory", &SlamSession::TrajectoryRows,
                              "N x 8, one row per frame with a pose: stamp tx ty tz qx qy qz qw, "
                              "world from camera, metres, "
                              "with all corrections so far");
  slam->def_property_readonly("poses", &SlamSession::Poses,
                              "N x 4 x 4, world from camera, metres, for the frames of trajectory");
  slam->def_property_readonly("mirrored", &SlamSession::mirrored,
                              "True if camera and world are mirrored, see Sequence.mirrored");
  slam->def_property_readonly("surfel_count", &SlamSession::SurfelCount, "number of surfels");
  slam->def_property_readonly(
      "digest", &SlamSession::DigestOfResult,
      "hash of trajectory and map; equal for bitwise identical results, also of surfit_slam");
  slam->def(
      "finish", &SlamSession::Finish,
      "Applies pending results of loop closure and calibration. Call it after the last frame.");
  slam->def_property_readonly(
      "calibration",
      [](SlamSession& session) -> std::optional<std::array<double, 10>> {
        const std::optional<DepthCalibration> found = session.FoundCalibration();
        if (!found) return std::nullopt;
        const PinholeCamera& c = found->camera;
        const auto& [c0, c1, c2, c3, c4, c5] = found->field.coefficients;
        return std::array<double, 10>{c.fx, c.fy, c.cx, c.cy, c0, c1, c2, c3, c4, c5};
      },
      "estimated calibration: fx fy cx cy in px, and the coefficients c0 to c5 of the correction "
      "of "
      "inverse depth in 1/m; None: the input calibration is kept");
  slam->def("surfels", &SlamSession::Surfels, "Returns a copy of the present map.");
  slam->def(
      "write_trajectory",
      [](SlamSession& session, const std::filesystem::path& path) {
        session.WriteTrajectory(path.string());
      },
      py::arg("path"), "Writes a TUM file, in the pose convention of the source.");
  slam->def(
      "write_map",
      [](SlamSession& session, const std::filesystem::path& path) {
        session.WriteMap(path.string());
      },
      py::arg("path"), "Writes the map as PLY, like surfit_slam.");
}

}  // namespace

void BindSlam(py::module_& module) {
  py::class_<SlamSession> slam(
      module, "Slam",
      "Dense SLAM with surfels. Each frame is registered to the rendered map, and fused at the "
      "estimated pose. With options.loops.enabled, loop closures correct the map and the "
      "trajectory. With options.calibration.enabled, the default, keyframes calibrate the camera, "
      "which also corrects map and trajectory.");
  slam.def(
      py::init([](const SlamOptions& options, const std::optional<CameraChoice>& camera,
                  const RectifyOptions& rectify, std::optional<Rigid3d> initial_pose) {
        std::optional<RgbdCamera> rgbd_camera;
        if (camera) rgbd_camera = CameraOf(*camera);
        return std::make_unique<SlamSession>(options, rgbd_camera, rectify,
                                             initial_pose.value_or(Rigid3d()));
      }),
      py::arg("options") = SlamOptions(), py::arg("camera") = py::none(),
      py::arg("rectify") = RectifyOptions(), py::arg("initial_pose") = py::none(),
      "The options are copied. Frames that are arrays use camera (a PinholeCamera, an RgbdCamera "
      "or the name of a preset) and prepare; a Frame has its own camera. The 4 x 4 matrix "
      "initial_pose is the pose of the first camera; None: the identity.");
  BindProcess(&slam);
  BindResults(&slam);
}

}  // namespace surfit::python
