#pragma once

namespace surfit {

// The page around the data, with its style, our scripts, three.js, Chart.js and its zoom, put
// together from src/report/page at build time. The runs come in between, each in an element <script
// type="application/json" class="run">.
extern const char kPageBeforeRuns[];
extern const char kPageAfterRuns[];

}  // namespace surfit
