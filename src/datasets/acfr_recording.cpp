#include "datasets/acfr_recording.h"

#include <algorithm>

#include "common/error.h"
#include "datasets/acfr_forms.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

bool isMatFile(const fs::path& path) {
  return path.extension() == ".mat" || path.extension() == ".MAT";
}

std::vector<fs::path> matFilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (isMatFile(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

AcfrRecording readSource(const fs::path& path) {
  const FileSource source(path);
  if (source.contains(kAcfrAsciiLaserFile)) return readAcfrAscii(source);
  if (fs::is_directory(path)) {
    const std::vector<fs::path> files = matFilesIn(path);
    if (!files.empty()) return readAcfrMatlab(files);
  }
  throw InputError(path.string() + " holds neither " + kAcfrAsciiLaserFile +
                   (fs::is_directory(path) ? " nor .mat files" : "; .mat files must be extracted") +
                   "; give the recording's .zip, its extracted folder, or its .mat files.");
}

}  // namespace

AcfrRecording readAcfr(const std::vector<fs::path>& inputs) {
  if (inputs.empty()) throw InputError("No recording was given; name its file or folder.");
  const bool only_mat = std::all_of(inputs.begin(), inputs.end(), isMatFile);
  if (inputs.size() > 1 && !only_mat) {
    throw InputError(
        "Several inputs were given, and not all are .mat files; only MATLAB recordings come in"
        " several files. Give the recording's .zip or folder alone.");
  }
  return only_mat ? readAcfrMatlab(inputs) : readSource(inputs.front());
}

}  // namespace hymm::core
