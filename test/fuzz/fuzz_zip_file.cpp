#include "common/error.h"
#include "datasets/file_source.h"
#include "fuzz/harness.h"
#include "support/archive.h"
#include "support/temporary_folder.h"

namespace hymm::test {

/// A .zip archive: listed, and a file of it unpacked.
bool isRead(const std::uint8_t* data, std::size_t size) {
  try {
    const core::FileSource source(inputFile(data, size, ".zip"));
    source.read("LASER.txt");
    return true;
  } catch (const core::InputError&) {
    return false;
  }
}

std::map<std::string, std::string> seeds() {
  const TemporaryFolder folder;
  std::string rows;
  for (int i = 0; i < 20; ++i) rows += "1 2 3\n";
  writeArchive(folder / "stored.zip", {{"folder/LASER.txt", rows}}, ZIP_CM_STORE);
  writeArchive(folder / "deflated.zip", {{"folder/LASER.txt", rows}}, ZIP_CM_DEFLATE);
  return {{"stored.zip", folder.read("stored.zip")}, {"deflated.zip", folder.read("deflated.zip")}};
}

}  // namespace hymm::test
