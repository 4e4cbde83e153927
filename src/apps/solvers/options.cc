#include "surfit/core/options.h"

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"

namespace surfit {

void RefineRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "sequence of the run, with the same options");
  v.Group("run");
  v.Add(trajectory, "trajectory", "trajectory of the run, TUM format", Required());
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.Group("keyframes");
  v.Add(keyframe_translation_m, "keyframe_translation_m", "minimum translation between keyframes",
        Positive(), AsFlag());
  v.Add(max_keyframes, SharedOption("max_keyframes"));
  v.AddPart(preprocess, "preprocess", "depth preprocessing", NoFlags());
  v.AddPart(refinement, "refinement", "joint refinement");
  v.Check([this] {
    if (max_keyframes != 1) return;
    throw InputError("max_keyframes is 1, must be 0 (no limit) or at least 2");
  });
}

CloudSensor RegisterRunOptions::DefaultSensor() {
  CloudSensor sensor;
  sensor.noise.inverse_depth_sigma = 0;
  return sensor;
}

RegisterCloudsOptions RegisterRunOptions::DefaultRegistration() {
  RegisterCloudsOptions registration;
  registration.icp.gates.max_distance_m = 0;
  registration.icp.error_model.floor_sigma_m = 1e-6;
  return registration;
}

void RegisterRunOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.Add(source, SharedOption("source", Required(), Everyday()));
  v.Add(target, SharedOption("target", Required(), Everyday()));
  v.Group("registration");
  v.AddPart(start, "start", "initial pose and verification");
  v.Add(start_pose, "start_pose",
        "initial target_from_source: a file with a 4 x 4 matrix, or tx,ty,tz,qx,qy,qz,qw; empty: "
        "none");
  v.Group("run");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(sensor, "sensor", "sensor of both clouds");
  v.Add(single_view, "single_view",
        "both clouds were observed from the viewpoint of the sensor: verify their free space");
  v.AddPart(normals, "normals", "normal estimation");
  v.AddPart(registration, "registration", "registration");
}

void AlignRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "input sequence", WithoutFlags({"first", "last", "stride"}));
  v.Add(source, "source", "index of the source frame, which is moved", AtLeast(0));
  v.Add(target, "target", "index of the target frame", AtLeast(0));
  v.Group("run");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(preprocess, "preprocess", "depth preprocessing");
  v.AddPart(initialize, "initialize", "initial pose");
  v.AddPart(icp, "icp", "registration");
}

}  // namespace surfit
