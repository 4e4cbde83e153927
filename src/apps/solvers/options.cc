#include "surfit/core/options.h"

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"
#include "surfit/core/error.h"

namespace surfit {

void RefineRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "as the run read it");
  v.Group("run");
  v.Add(trajectory, "trajectory", "the run's trajectory, in TUM format", Required());
  v.Add(output, OutputOption("folder for the results"));
  v.Add(threads, ThreadsOption());
  v.Group("keyframes");
  v.Add(keyframe_translation_m, "keyframe_translation_m",
        "a frame this far from the last keyframe is the next", Positive(), AsFlag());
  v.Add(keyframe_rotation_rad, "keyframe_rotation_rad", "and so is a frame turned this far",
        Positive(), AsFlag());
  v.Add(max_keyframes, "max_keyframes", "with more of them, both are enlarged", ZeroIs("no limit"),
        AsFlag());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
  v.AddPart(refinement, "refinement", "what is estimated, and how");
  v.Check([this] {
    if (max_keyframes != 1) return;
    throw InputError("max_keyframes is 1, must be 0 (no limit) or at least 2");
  });
}

void RegisterRunOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.Add(source, "source", "the cloud to be moved: PLY or PCD, in m", Required(), Everyday());
  v.Add(target, "target", "the cloud to be met", Required(), Everyday());
  v.Group("run");
  v.Add(output, OutputOption("folder for pose, aligned cloud and pictures"));
  v.Add(threads, ThreadsOption());
  v.AddPart(sensor, "sensor", "what both were measured with");
  v.AddPart(normals, "normals", "how normals are estimated");
  v.AddPart(registration, "registration", "how the clouds are registered");
}

void AlignRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last", "stride"}));
  v.Add(source, "source", "index of the frame to be moved", AtLeast(0), Everyday());
  v.Add(target, "target", "index of the frame to be met", AtLeast(0), Everyday());
  v.Group("run");
  v.Add(output, OutputOption("folder for clouds and pictures"));
  v.Add(threads, ThreadsOption());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces");
  v.AddPart(initialize, "initialize", "where registration starts");
  v.AddPart(icp, "icp", "the registration", WithoutFlags({"min_source_rows"}));
}

}  // namespace surfit
