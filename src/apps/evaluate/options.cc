#include "surfit/core/options.h"

#include "apps/evaluate/revisits.h"
#include "apps/evaluate/view_evaluation.h"
#include "apps/evaluate/view_files.h"

namespace surfit {

void RevisitOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last"}));
  v.Group("revisits");
  v.Add(estimate, "estimate", "the estimated trajectory of the sequence, in TUM format", Required(),
        Everyday());
  v.Add(min_gap, "min_gap", "frames between two visits", AtLeast(1), Everyday());
  v.Add(max_distance_m, "max_distance_m", "distance of the two cameras at most", Positive(),
        Everyday());
  v.Add(max_angle_rad, "max_angle_rad", "angle between the two cameras at most", Positive(),
        Everyday());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
}

void ViewEvaluationOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "as the run read it");
  v.Group("views");
  v.Add(run, "run",
        "output folder of surfit_slam; its summary.json says which sequence it read and how, where "
        "flags do not, and its poses.json what camera it found",
        Required(), Everyday());
  v.Add(output, "output", "folder for the results, made if missing; empty: the run's", Everyday());
  v.Add(every, "every", "judge by every n-th frame; a run with --hold_out by what it held out",
        AtLeast(1), Everyday());
  v.Add(pictures, "pictures", "write pictures of so many views, the worst first",
        Between(0, kMostViewPictures), Everyday());
  v.Add(threads, ThreadsOption());
}

void FindLoopsRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last", "stride"}));
  v.Group("run");
  v.Add(trajectory, "trajectory", "the estimated trajectory, in TUM format", Required(),
        Everyday());
  v.Add(output, OutputOption("folder for loops.csv and loops.g2o"));
  v.Add(threads, ThreadsOption());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
  v.AddPart(keyframes, "keyframes", "when a frame becomes a keyframe");
  v.AddPart(view, "view", "what is kept of a keyframe");
  v.AddPart(index, "index", "how places are looked up");
  v.AddPart(loops, "loops", "which keyframes may be joined");
  v.Group("loops");
  v.Add(max_view_bytes, "max_view_bytes",
        "memory for all keyframes' views; beyond, views of places that others show as well are "
        "given up",
        AsFlag());
  v.Group("evaluation");
  v.Add(revisit_gap, "revisit_gap",
        "a frame returns if its true pose is near that of a frame this much earlier", AtLeast(1),
        AsFlag());
  v.Add(revisit_m, "revisit_m", "distance that is near", Positive(), AsFlag("revisit_distance_m"));
  v.Add(revisit_rad, "revisit_rad", "angle that is near", Positive(), AsFlag("revisit_angle_rad"));
  v.Add(wrong_m, "wrong_m", "a loop farther from the truth is wrong", Positive());
  v.Add(wrong_rad, "wrong_rad", "and so is one turned farther", Positive());
}

}  // namespace surfit
