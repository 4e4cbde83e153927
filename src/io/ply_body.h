#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "io/ply_header.h"

namespace surfit {

// Calls `row` with the values of each row of the first element of that name, one for each property
// (0 for a list), in the file's order. `begin` is called before the first row, once the file is
// known to be long enough for all of them.
// Throws InputError naming `path`, the element and the row if the body breaks its header's promise.
void ReadPlyElement(std::string_view file, const PlyHeader& header, const std::string& name,
                    const std::string& path, const std::function<void()>& begin,
                    const std::function<void(const double*)>& row);

}  // namespace surfit
