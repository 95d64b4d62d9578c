#include "ros/bag_structure.h"

#include <cstdint>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>

#include "ros/bag_errors.h"
#include "support/temporary_folder.h"

namespace hymm {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Two messages on each of two topics.
std::string writeBag(const test::TemporaryFolder& folder, rosbag::CompressionType compression) {
  rosbag::Bag bag(folder / "a.bag", rosbag::bagmode::Write);
  bag.setCompression(compression);
  sensor_msgs::LaserScan scan;
  scan.ranges.assign(3, 1.0F);
  for (const double time_s : {1.0, 2.0}) {
    bag.write("scan", ros::Time(time_s), scan);
    bag.write("rear_scan", ros::Time(time_s), scan);
  }
  bag.close();
  return folder.read("a.bag");
}

/// Reads all messages; a damaged bag is refused with an InputError.
std::size_t messagesIn(const std::string& path) {
  return withBagErrors(path, [&] {
    rosbag::Bag bag;
    openBag(bag, path);
    std::size_t messages = 0;
    for (const rosbag::MessageInstance& instance : rosbag::View(bag)) {
      std::vector<std::uint8_t> bytes(instance.size());
      ros::serialization::OStream stream(bytes.data(), instance.size());
      instance.write(stream);
      ++messages;
    }
    return messages;
  });
}

/// The bag with other bytes at a place.
std::string replaced(std::string bag, std::size_t at, const std::string& bytes) {
  return bag.replace(at, bytes.size(), bytes);
}

TEST(BagStructure, FitsInWhatRosWrites) {
  const test::TemporaryFolder folder;
  for (const auto compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    writeBag(folder, compression);
    EXPECT_NO_THROW(checkBagStructure(folder / "a.bag"));
    EXPECT_EQ(messagesIn(folder / "a.bag"), 4u);
  }
}

TEST(BagStructure, LengthsBeyondTheFileAreRefused) {
  const test::TemporaryFolder folder;
  const std::string bag = writeBag(folder, rosbag::compression::Uncompressed);
  const std::string huge("\xff\xff\xff\xef", 4);
  // The length of a chunk's header, of its data, and of a field.
  for (const std::size_t at :
       {bag.find("compression=") - 8, bag.find("size=") + 9, bag.find("compression=") - 4}) {
    SCOPED_TRACE(at);
    const std::string path = folder.write("b.bag", replaced(bag, at, huge));
    EXPECT_THAT([&] { checkBagStructure(path); },
                ThrowsMessage<std::runtime_error>(HasSubstr("at byte")));
    EXPECT_THROW(messagesIn(path), core::InputError);
  }
}

TEST(BagStructure, WhatRosWouldTakeForABagIsRefused) {
  const test::TemporaryFolder folder;
  const std::string bag = writeBag(folder, rosbag::compression::Uncompressed);
  const std::string path = folder.write("b.bag", replaced(bag, 6, "F"));  // #ROSBAF
  EXPECT_THAT([&] { checkBagStructure(path); },
              ThrowsMessage<NotABag>(HasSubstr("does not begin")));
  EXPECT_THAT([&] { messagesIn(path); },
              ThrowsMessage<core::InputError>(HasSubstr("b.bag: is no bag")));
}

TEST(BagStructure, BagThatBreaksOffInItsFirstLineIsCutOff) {
  const test::TemporaryFolder folder;
  for (const std::string beginning : {"#", "#ROSBAG V2.0"}) {
    const std::string path = folder.write("b.bag", beginning);
    EXPECT_THROW(checkBagStructure(path), BagCutOff);
  }
}

TEST(BagStructure, IndexThatLeadsOutOfItsChunkIsRefused) {
  const test::TemporaryFolder folder;
  for (const auto compression : {rosbag::compression::Uncompressed, rosbag::compression::LZ4}) {
    const std::string bag = writeBag(folder, compression);
    const std::size_t index =
        bag.find("ver=");  // the length of the data follows, and the first entry
    ASSERT_NE(index, std::string::npos);
    const std::size_t entry = index + 8 + 4;
    const std::string path = folder.write("b.bag", replaced(bag, entry + 8, "\xff\xff\xff\x10"));
    EXPECT_THAT([&] { checkBagStructure(path); },
                ThrowsMessage<std::runtime_error>(HasSubstr("an index leads to no message")));
  }
}

TEST(BagStructure, BagWithAnyByteWrongIsReadOrRefused) {
  const test::TemporaryFolder folder;
  const std::string bag = writeBag(folder, rosbag::compression::Uncompressed);
  std::size_t refused = 0;
  // The records' lengths and places; definitions of messages are text, and need not be tried byte
  // by byte.
  for (std::size_t i = 0; i < bag.size(); i += bag[i] >= ' ' && bag[i] <= 'z' ? 23 : 1) {
    const std::string path =
        folder.write("b.bag", replaced(bag, i, std::string(1, static_cast<char>(bag[i] ^ 0x44))));
    try {
      messagesIn(path);
    } catch (const core::InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0u);
}

}  // namespace
}  // namespace hymm
