#include "datasets/file_source.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "support/archive.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

class FileSourceTest : public testing::Test {
 protected:
  std::filesystem::path archive(const std::map<std::string, std::string>& files) const {
    const auto path = folder_.path() / "recording.zip";
    test::writeArchive(path, files);
    return path;
  }

  test::TemporaryFolder folder_;
  // Random enough that compression keeps most of it.
  const std::string content_ = [] {
    std::string text;
    for (unsigned i = 0, x = 1; i < 5000; ++i) {
      x = x * 1664525u + 1013904223u;
      text += std::to_string(x) + "\n";
    }
    return text;
  }();
};

TEST_F(FileSourceTest, FindsFilesInFolderWhateverTheCase) {
  folder_.write("Laser.TXT", "1 2 3");
  const FileSource source(folder_.path());
  EXPECT_TRUE(source.contains("LASER.txt"));
  EXPECT_FALSE(source.contains("GPS.txt"));
  EXPECT_EQ(source.read("LASER.txt"), "1 2 3");
}

TEST_F(FileSourceTest, FindsFilesInFoldersOfAnArchive) {
  const FileSource source(archive({{"park/raw/LASER.txt", content_}, {"park/GPS.txt", ""}}));
  EXPECT_EQ(source.read("laser.txt"), content_);
  EXPECT_EQ(source.read("GPS.txt"), "");
}

TEST_F(FileSourceTest, NamesMissingFile) {
  const FileSource source(archive({{"GPS.txt", "1"}}));
  EXPECT_THAT([&] { source.read("LASER.txt"); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("recording.zip"), HasSubstr("holds no file LASER.txt"))));
}

TEST_F(FileSourceTest, RefusesFileThatIsThereTwice) {
  const FileSource source(archive({{"a/GPS.txt", "1"}, {"b/GPS.txt", "2"}}));
  EXPECT_THAT([&] { source.read("GPS.txt"); },
              ThrowsMessage<InputError>(HasSubstr("more than one file GPS.txt")));
}

TEST_F(FileSourceTest, RefusesArchiveCutOffAnywhere) {
  const auto path = archive({{"GPS.txt", content_}});
  const auto size = std::filesystem::file_size(path);
  for (const std::uintmax_t kept : {size - 1, size - 30, size / 2, std::uintmax_t{40}}) {
    std::filesystem::resize_file(path, kept);
    EXPECT_THAT([&] { FileSource(path).read("GPS.txt"); },
                ThrowsMessage<InputError>(HasSubstr("recording.zip")))
        << kept << " of " << size << " bytes";
  }
}

TEST_F(FileSourceTest, RefusesArchiveWithDamagedContent) {
  const auto path = archive({{"GPS.txt", content_}});
  std::string bytes = readFile(path);
  bytes[bytes.size() / 2] = static_cast<char>(~bytes[bytes.size() / 2]);
  folder_.write("recording.zip", bytes);
  EXPECT_THAT(
      [&] { FileSource(path).read("GPS.txt"); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("recording.zip: GPS.txt"), HasSubstr("damaged"))));
}

TEST_F(FileSourceTest, RefusesWhatIsNoArchive) {
  EXPECT_THAT([&] { FileSource(folder_.write("recording.zip", "hello")); },
              ThrowsMessage<InputError>(HasSubstr("cannot be read as a .zip archive")));
  EXPECT_THAT([&] { FileSource(folder_.write("empty.zip", "")); },
              ThrowsMessage<InputError>(HasSubstr("cannot be read as a .zip archive")));
  EXPECT_THAT([&] { FileSource(folder_.path() / "none.zip"); },
              ThrowsMessage<InputError>(HasSubstr("does not exist")));
}

}  // namespace
}  // namespace hymm::core
