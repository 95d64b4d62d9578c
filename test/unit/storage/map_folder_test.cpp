#include "storage/map_folder.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

struct Killed {};

/// Ends the process, as it were, at the n-th step: nothing is done from there on.
class KillAt : public DiskWatch {
 public:
  explicit KillAt(int step) : step_(step) {}
  void before(const std::string&) override {
    if (++steps_ > step_) throw Killed();
  }
  int steps() const { return steps_; }

 private:
  int step_, steps_ = 0;
};

MapPart part(const std::string& state) { return {{{"gps.enabled", "false"}}, state}; }

/// A map of two parts, the second too large to be written at once.
struct Map {
  MapPart landmarks, dense;
  std::uint64_t version = 0;
};

Map mapNumber(int n) {
  std::mt19937 generator(static_cast<unsigned>(n));
  std::string noise(300000, '\0');
  for (char& c : noise) c = static_cast<char>(generator());
  return {part("landmarks of map " + std::to_string(n)), part(noise), std::uint64_t(n)};
}

void save(const fs::path& path, const Map& map, DiskWatch* watch = nullptr) {
  const MapFolder folder(path, watch);
  folder.prepare();
  MapManifest manifest;
  manifest.landmark_version = map.version;
  manifest.notes["saved"] = "at noon";
  manifest.parts = {folder.write(MapPart::kLandmarks, map.landmarks),
                    folder.write(MapPart::kDenseMap, map.dense)};
  folder.complete(manifest);
}

Map load(const fs::path& path) {
  const MapFolder folder(path);
  const MapManifest manifest = folder.manifest();
  return {folder.read(manifest.parts.at(0)), folder.read(manifest.parts.at(1)),
          manifest.landmark_version};
}

bool isSame(const Map& a, const Map& b) {
  return a.version == b.version && a.landmarks.state == b.landmarks.state &&
         a.landmarks.settings == b.landmarks.settings && a.dense.state == b.dense.state;
}

std::size_t filesIn(const fs::path& path) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(path), fs::directory_iterator()));
}

TEST(MapFolder, GivesBackWhatWasSaved) {
  const test::TemporaryFolder folder;
  save(folder.path() / "map", mapNumber(1));
  EXPECT_TRUE(isSame(load(folder.path() / "map"), mapNumber(1)));
  EXPECT_EQ(MapFolder(folder.path() / "map").manifest().notes.at("saved"), "at noon");
}

TEST(MapFolder, ReplacesTheMapBeforeAndRemovesItsFiles) {
  const test::TemporaryFolder folder;
  save(folder.path() / "map", mapNumber(1));
  save(folder.path() / "map", mapNumber(2));
  EXPECT_TRUE(isSame(load(folder.path() / "map"), mapNumber(2)));
  EXPECT_EQ(filesIn(folder.path() / "map"), 3U);
}

TEST(MapFolder, HoldsTheOldMapOrTheNewOneWhereverTheProcessIsKilled) {
  KillAt counter(1 << 30);
  {
    const test::TemporaryFolder folder;
    save(folder.path() / "map", mapNumber(1));
    save(folder.path() / "map", mapNumber(2), &counter);
  }
  int old_maps = 0, new_maps = 0;
  for (int step = 0; step < counter.steps(); ++step) {
    const test::TemporaryFolder folder;
    const fs::path path = folder.path() / "map";
    save(path, mapNumber(1));
    KillAt kill(step);
    EXPECT_THROW(save(path, mapNumber(2), &kill), Killed);
    const Map left = load(path);
    const bool is_old = isSame(left, mapNumber(1));
    EXPECT_TRUE(is_old || isSame(left, mapNumber(2))) << "step " << step;
    ++(is_old ? old_maps : new_maps);
    save(path, mapNumber(3));
    EXPECT_TRUE(isSame(load(path), mapNumber(3)));
    EXPECT_EQ(filesIn(path), 3U) << "what the kill left is removed";
  }
  EXPECT_GT(old_maps, 10);
  EXPECT_GT(new_maps, 1);
}

TEST(MapFolder, RefusesAMapThatWasKilledBeforeItWasFirstComplete) {
  KillAt counter(1 << 30);
  {
    const test::TemporaryFolder folder;
    save(folder.path() / "map", mapNumber(1), &counter);
  }
  for (int step = 0; step < counter.steps(); ++step) {
    const test::TemporaryFolder folder;
    KillAt kill(step);
    EXPECT_THROW(save(folder.path() / "map", mapNumber(1), &kill), Killed);
    std::optional<Map> left;
    try {
      left = load(folder.path() / "map");
    } catch (const InputError&) {
    }
    if (left) {
      EXPECT_TRUE(isSame(*left, mapNumber(1)));
    }
  }
}

/// The files of a small map, to be damaged.
class DamagedMap : public testing::Test {
 protected:
  DamagedMap() {
    map_.landmarks = part("landmarks");
    map_.dense = part("cells");
    map_.version = 5;
    save(path_, map_);
    for (const auto& entry : fs::directory_iterator(path_)) {
      files_.push_back(entry.path().filename().string());
    }
  }
  std::string content(const std::string& file) const { return folder_.read("map/" + file); }
  void write(const std::string& file, const std::string& content) const {
    folder_.write("map/" + file, content);
  }

  test::TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "map";
  Map map_;
  std::vector<std::string> files_;
};

TEST_F(DamagedMap, IsRefusedWhereverAFileIsCutOff) {
  for (const std::string& file : files_) {
    const std::string whole = content(file);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      write(file, whole.substr(0, size));
      EXPECT_THROW(load(path_), InputError) << file << " cut to " << size;
    }
    write(file, whole);
  }
  EXPECT_TRUE(isSame(load(path_), map_));
}

TEST_F(DamagedMap, IsRefusedWhicheverBitFlips) {
  for (const std::string& file : files_) {
    const std::string whole = content(file);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      std::string damaged = whole;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
      write(file, damaged);
      EXPECT_THROW(load(path_), InputError) << file << " bit " << bit;
    }
    write(file, whole);
  }
}

TEST_F(DamagedMap, IsRefusedWithASentenceWhereAFileIsMissingOrLonger) {
  for (const std::string& file : files_) {
    const std::string whole = content(file);
    write(file, whole + "x");
    EXPECT_THROW(load(path_), InputError);
    fs::remove(path_ / file);
    EXPECT_THAT([&] { load(path_); }, ThrowsMessage<InputError>(HasSubstr(file)));
    write(file, whole);
  }
}

TEST(MapFolder, RefusesANewerFormatAndSaysWhatToDo) {
  EXPECT_THAT(
      [] { parseManifest(sealed("hymm map, format 2\nanything else\n"), "map.txt"); },
      ThrowsMessage<InputError>(testing::AllOf(HasSubstr("format 2"), HasSubstr("later one"))));
}

TEST(MapFolder, RefusesNamesThatLeadOutOfTheFolder) {
  const std::string text =
      "hymm map, format 1\nlandmark_version 0\npart landmarks ../../secret 1 1 0\n";
  EXPECT_THAT([&] { parseManifest(sealed(text), "map.txt"); },
              ThrowsMessage<InputError>(HasSubstr("no name of a file")));
}

TEST(MapFolder, LeavesFoldersAloneThatHoldOtherThings) {
  const test::TemporaryFolder folder;
  folder.write("map/thesis.tex", "years of work");
  EXPECT_THAT([&] { save(folder.path() / "map", mapNumber(1)); },
              ThrowsMessage<OutputError>(HasSubstr("thesis.tex")));
  EXPECT_THROW(save(folder.path() / "no" / "parent", mapNumber(1)), OutputError);
  EXPECT_THROW(load(folder.path() / "nothing"), InputError);
}

TEST(SavedSettings, TellWhatIsDifferent) {
  const SavedSettings saved = {{"a", "1"}, {"b", "x"}, {"gone", "2"}};
  const SavedSettings present = {{"a", "1"}, {"b", "y"}, {"new", ""}};
  EXPECT_THAT(differencesOf(saved, present),
              testing::ElementsAre("b was x and is y", "gone was 2 and is not known",
                                   "new was not known and is empty"));
  EXPECT_TRUE(differencesOf(saved, saved).empty());
}

}  // namespace
}  // namespace hymm::core
