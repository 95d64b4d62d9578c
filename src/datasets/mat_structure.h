#pragma once

#include <filesystem>

namespace hymm::core {

/// Looks at what a MATLAB file tells of itself before matio believes it, which takes memory for
/// whatever lengths it reads, does not look at checksums of what is compressed, and reads what is
/// left of a file that was cut off without a word. Files of version 7.3 (HDF5) and of another byte
/// order are refused. Throws InputError; it says what to do.
void checkMatStructure(const std::filesystem::path& path);

}  // namespace hymm::core
