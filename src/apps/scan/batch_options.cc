// The options of this module.
#include "apps/scan/batch.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit {

void BatchOptions::Visit(OptionVisitor& v) {
  v.Group("batch");
  v.Add(sequences, "sequences",
        "folder of the sequences: each folder in it, and each .klg, .sens, .bag, .db3 and .mcap "
        "file, is one",
        Required(), AsFlag(), Everyday());
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(memory_mb, "memory_mb", "that a run may take, of a node of a cluster", AtLeast(1),
        InUnit("MB"), AsFlag());
  v.Add(minutes, "minutes", "that a run may take, on a cluster", AtLeast(1), InUnit("min"),
        AsFlag());
  v.AddPart(run, "run", "how each sequence is run", OptionalPart(),
            WithoutFlags({"sequence", "output", "trace", "dump_failures", "session", "continue",
                          "localize"}));
  v.Check([this] {
    if (!IsLive(run.sequence)) return;
    throw InputError("format is '", run.sequence.format,
                     "', must be one of a sequence that is recorded");
  });
}

}  // namespace surfit
