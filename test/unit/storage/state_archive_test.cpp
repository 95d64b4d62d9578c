#include "common/state_archive.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

struct Everything {
  int number = 7;
  double real = -0.1;
  bool flag = true;
  std::string text = "pole";
  std::vector<bool> flags = {true, false, true};
  std::vector<double> reals = {1.5, 2.5};
  std::deque<std::string> texts = {"a", ""};
  std::array<int, 2> two = {3, 4};
  std::optional<Pose2> pose = Pose2{1.0, 2.0, 0.3};
  std::optional<int> nothing;
  std::map<int, std::set<int>> sets = {{1, {2, 3}}, {4, {}}};
  std::unordered_map<int, double> hashed = {{9, 0.9}, {-1, 0.1}, {5, 0.5}};
  std::unordered_set<int> ids = {8, 2, 6};
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Constant(2, 3, 0.25);
  Eigen::Vector2d place{5.0, 6.0};

  template <class Archive>
  void describeState(Archive& archive) {
    archive(number, real, flag, text, flags, reals, texts, two, pose, nothing, sets, hashed, ids,
            matrix, place);
  }
};

std::string bytesOf(const Everything& value) {
  StateWriter writer;
  writer(value);
  return writer.takeBytes();
}

TEST(StateArchive, GivesBackWhatWasWritten) {
  Everything written;
  written.number = 12;
  written.pose.reset();
  written.nothing = 3;
  written.flags = {};
  const std::string bytes = bytesOf(written);
  Everything read;
  StateReader reader(bytes, "The state");
  reader(read);
  reader.requireEnd();
  EXPECT_EQ(bytesOf(read), bytes);
  EXPECT_EQ(read.number, 12);
  EXPECT_FALSE(read.pose.has_value());
  EXPECT_EQ(read.nothing, 3);
  EXPECT_EQ(read.hashed, written.hashed);
  EXPECT_EQ(read.matrix, written.matrix);
}

TEST(StateArchive, WritesTheSameBytesWhateverTheOrderOfHashedContainers) {
  Everything other;
  other.hashed.clear();
  for (const auto& [key, value] : {std::pair(-1, 0.1), {5, 0.5}, {9, 0.9}})
    other.hashed[key] = value;
  other.ids = {2, 6, 8};
  EXPECT_EQ(bytesOf(other), bytesOf(Everything()));
}

TEST(StateArchive, RefusesEveryTruncation) {
  const std::string bytes = bytesOf(Everything());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    StateReader reader(std::string_view(bytes).substr(0, size), "The state");
    Everything read;
    EXPECT_THROW(reader(read), InputError) << size << " bytes";
  }
}

TEST(StateArchive, RefusesSizesThatCannotBe) {
  StateWriter writer;
  writer(~std::uint64_t{0});
  std::vector<double> numbers;
  Eigen::MatrixXd matrix;
  EXPECT_THROW(StateReader(writer.bytes(), "The state")(numbers), InputError);
  StateWriter sizes;
  sizes(std::uint64_t{1} << 33U, std::uint64_t{1} << 33U, 0.0);
  EXPECT_THROW(StateReader(sizes.bytes(), "The state")(matrix), InputError);
}

}  // namespace
}  // namespace hymm::core
