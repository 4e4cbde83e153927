#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace surfit {

// All that the page shows of one run, read from its output folder: label (the folder), summary
// (summary.json), frames (the text of frames.csv), poses (poses.json) with its views' pictures as
// data URLs, and map (PackMap). Throws InputError naming the file that is missing or broken.
nlohmann::ordered_json ReadRun(const std::string& folder, std::size_t max_points);

}  // namespace surfit
