// Slam, frame by frame.
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
      "Tracks and fuses the next frame, or fuses it at a given pose.");
  slam->def(
      "process",
      [](SlamSession& session, const py::object& color, const py::array& depth, double stamp_s,
         std::optional<int> index, std::optional<Rigid3d> world_from_camera) {
        return session.Process(color, depth, stamp_s, index, world_from_camera);
      },
      py::arg("color"), py::arg("depth"), py::arg("stamp_s"), py::kw_only(),
      py::arg("index") = py::none(), py::arg("world_from_camera") = py::none(),
      "The same of arrays, as Frame takes them, in the camera that Slam was made with. The index "
      "is that after the last frame's if None.");
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
      "Calls call(index, stamp_s, world_from_camera) with each frame as soon as its pose is known, "
      "None where it is lost: process() then goes on to fuse it. The call must not call this Slam. "
      "What it raises is raised by process() in the end. None: no more calls.");
}

void BindResults(py::class_<SlamSession>* slam) {
  slam->def_property_readonly(
      "trajectory", &SlamSession::TrajectoryRows,
      "N x 8, a row for each frame with a pose: stamp tx ty tz qx qy qz qw, world from camera, "
      "metres, as corrected by loops and calibration so far");
  slam->def_property_readonly("poses", &SlamSession::Poses,
                              "N x 4 x 4, world from camera, metres, of the same frames");
  slam->def_property_readonly("mirrored", &SlamSession::mirrored,
                              "whether camera and world are mirrored: see Sequence.mirrored");
  slam->def_property_readonly("surfel_count", &SlamSession::SurfelCount, "of the map");
  slam->def_property_readonly(
      "digest", &SlamSession::DigestOfResult,
      "of trajectory and map: equal digests, equal results bit for bit, with surfit_slam as well");
  slam->def(
      "finish", &SlamSession::Finish,
      "Takes in what is still being found out about loops and the camera: after the last frame.");
  slam->def_property_readonly(
      "calibration",
      [](SlamSession& session) -> std::optional<std::array<double, 10>> {
        const std::optional<DepthCalibration> found = session.FoundCalibration();
        if (!found) return std::nullopt;
        const PinholeCamera& c = found->camera;
        const auto& [c0, c1, c2, c3, c4, c5] = found->field.coefficients;
        return std::array<double, 10>{c.fx, c.fy, c.cx, c.cy, c0, c1, c2, c3, c4, c5};
      },
      "fx fy cx cy in px, and c0 to c5 in 1/m of the correction of inverse depth, by which the "
      "depth camera was found to see while it was tracked; None while it is as given");
  slam->def("surfels", &SlamSession::Surfels, "The map as it is now, copied once.");
  slam->def(
      "write_trajectory",
      [](SlamSession& session, const std::filesystem::path& path) {
        session.WriteTrajectory(path.string());
      },
      py::arg("path"), "Writes a TUM file, in the source's own convention where it is mirrored.");
  slam->def(
      "write_map",
      [](SlamSession& session, const std::filesystem::path& path) {
        session.WriteMap(path.string());
      },
      py::arg("path"), "Writes the map as PLY, as surfit_slam does.");
}

}  // namespace

void BindSlam(py::module_& module) {
  py::class_<SlamSession> slam(
      module, "Slam",
      "Dense SLAM by point-based fusion: each frame is registered to what the map predicts, and "
      "fused into the map at the pose found. With options.loops.enabled the map and the trajectory "
      "follow the poses that closed loops correct; with options.calibration.enabled, the default, "
      "they and the camera follow what the keyframes tell of it.");
  slam.def(py::init([](const SlamOptions& options, const std::optional<CameraChoice>& camera,
                       const PrepareOptions& prepare, std::optional<Rigid3d> initial_pose) {
             std::optional<RgbdCamera> rgbd_camera;
             if (camera) rgbd_camera = CameraOf(*camera);
             return std::make_unique<SlamSession>(options, rgbd_camera, prepare,
                                                  initial_pose.value_or(Rigid3d()));
           }),
           py::arg("options") = SlamOptions(), py::arg("camera") = py::none(),
           py::arg("prepare") = PrepareOptions(), py::arg("initial_pose") = py::none(),
           "The options are copied. The camera, a PinholeCamera, an RgbdCamera or a preset's name, "
           "and how to prepare images are for frames that are arrays: a Frame has its own. "
           "initial_pose is the first camera's, 4 x 4; the identity if None.");
  BindProcess(&slam);
  BindResults(&slam);
}

}  // namespace surfit::python
