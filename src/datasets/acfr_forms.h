#pragma once

#include <filesystem>
#include <vector>

#include "datasets/acfr_recording.h"
#include "datasets/file_source.h"

/// The readers of the single forms in which ACFR's recordings were published; see readAcfr.
namespace hymm::core {

/// The file by which the ASCII form is known.
inline constexpr char kAcfrAsciiLaserFile[] = "LASER.txt";

AcfrRecording readAcfrAscii(const FileSource& source);

/// One file of the car-park form, or the two or three of Victoria Park.
AcfrRecording readAcfrMatlab(const std::vector<std::filesystem::path>& files);

}  // namespace hymm::core
