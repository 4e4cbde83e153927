#include "surfit/core/options.h"

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"

namespace surfit {

void RefineRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "as the run read it");
  v.Group("run");
  v.Add(trajectory, "trajectory", "the run's trajectory, in TUM format", Required());
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.Group("keyframes");
  v.Add(keyframe_translation_m, "keyframe_translation_m",
        "a frame this far from the last keyframe is the next", Positive(), AsFlag());
  v.Add(keyframe_rotation_rad, "keyframe_rotation_rad", "and so is a frame turned this far",
        Positive(), AsFlag());
  v.Add(max_keyframes, SharedOption("max_keyframes"));
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
  v.AddPart(refinement, "refinement", "what is estimated, and how");
  v.Check([this] {
    if (max_keyframes != 1) return;
    throw InputError("max_keyframes is 1, must be 0 (no limit) or at least 2");
  });
}

void RegisterRunOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.Add(source, SharedOption("source", Required(), Everyday()));
  v.Add(target, SharedOption("target", Required(), Everyday()));
  v.Group("run");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(sensor, "sensor", "what both were measured with");
  v.AddPart(normals, "normals", "how normals are estimated");
  v.AddPart(registration, "registration", "how the clouds are registered");
}

void AlignRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last", "stride"}));
  v.Add(source, "source", "index of the source frame, which is moved", AtLeast(0),
        AsFlag("source_frame"), Everyday());
  v.Add(target, "target", "index of the target frame", AtLeast(0), AsFlag("target_frame"),
        Everyday());
  v.Group("run");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces");
  v.AddPart(initialize, "initialize", "where registration starts");
  v.AddPart(icp, "icp", "the registration", WithoutFlags({"min_source_rows"}));
}

}  // namespace surfit
