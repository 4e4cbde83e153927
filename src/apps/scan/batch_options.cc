#include "apps/scan/batch.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit {

void BatchOptions::Visit(OptionVisitor& v) {
  v.Group("batch");
  v.Add(sequences, "sequences",
        "folder of the sequences: its folders, and its .klg, .sens, .bag, .db3 and .mcap files",
        Required(), AsFlag(), Everyday());
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.AddPart(run, "run", "options of each run", OptionalPart(),
            WithoutFlags({"sequence", "output", "trace", "dump_failures", "session", "continue",
                          "localize"}));
  v.Check([this] {
    if (!IsLive(run.sequence)) return;
    throw InputError("format is '", run.sequence.format, "', must be the format of a recording");
  });
}

}  // namespace surfit
