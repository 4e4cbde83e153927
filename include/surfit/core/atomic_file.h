#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace surfit {

// Writes a file that is there either as a whole or not at all, whatever ends the program or the
// machine: `write` fills a new file beside `path`, which is flushed to the disk and then takes the
// place of `path` in one step. If `write` throws, or the disk is full, an older file stays as it
// was and the new one is removed. A symbolic link to a file is refused: what it leads to is
// somebody else's. What is no regular file (a device, a pipe) is written to directly.
// Throws InputError naming the file if it cannot be written, and whatever `write` throws.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace surfit
