#include "ros/player_arguments.h"

#include <gmock/gmock.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include "common/error.h"
#include "support/temporary_folder.h"

namespace hymm {
namespace {

using testing::ElementsAre;

TEST(PlayerArguments, SayWhichPartIsPlayed) {
  for (const char* text : {"-s 20 -u 15.5", "-s20 -u15.5", "--start=20 --duration 15.5",
                           "-q --clock --hz 50 -d 1 -u 15.5 -i -s 20 --skip-empty=3"}) {
    const auto arguments = parsePlayerArguments(text);
    ASSERT_TRUE(arguments) << text;
    EXPECT_EQ(arguments->start_s, 20.0) << text;
    EXPECT_EQ(arguments->duration_s, 15.5) << text;
    EXPECT_FALSE(arguments->loops) << text;
    EXPECT_TRUE(arguments->topics.empty()) << text;
  }
}

TEST(PlayerArguments, WithoutAnyAllIsPlayedOnce) {
  const auto arguments = parsePlayerArguments(" ");
  ASSERT_TRUE(arguments);
  EXPECT_EQ(arguments->start_s, 0.0);
  EXPECT_FALSE(arguments->duration_s);
  EXPECT_FALSE(arguments->loops);
}

TEST(PlayerArguments, TellOfLoopsAndTopics) {
  EXPECT_TRUE(parsePlayerArguments("-l")->loops);
  EXPECT_TRUE(parsePlayerArguments("--loop -r 2")->loops);
  const auto arguments = parsePlayerArguments("--topics /scan /odom --bags");
  ASSERT_TRUE(arguments);
  EXPECT_THAT(arguments->topics, ElementsAre("/scan", "/odom"));
}

TEST(PlayerArguments, ThatAreNotKnownSayNothing) {
  for (const char* text : {"--sta 20", "-x", "-u", "-u long", "--s=3", "-il", "--loop=1"}) {
    EXPECT_FALSE(parsePlayerArguments(text)) << text;
  }
}

class PlayedSpanTest : public testing::Test {
 protected:
  /// A message on /a each second from 100 s to 110 s, on /b to 105 s.
  PlayedSpanTest() : path_(folder_ / "ten_seconds.bag") {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    for (int s = 100; s <= 110; ++s) bag.write("/a", ros::Time(s), std_msgs::String());
    for (int s = 100; s <= 105; ++s) bag.write("/b", ros::Time(s), std_msgs::String());
  }

  test::TemporaryFolder folder_;
  std::string path_;
};

TEST_F(PlayedSpanTest, EndsWithTheLastMessageThatIsPlayed) {
  PlayerArguments arguments;
  EXPECT_EQ(playedSpan(path_, arguments).begin_s, 100.0);
  EXPECT_EQ(playedSpan(path_, arguments).end_s, 110.0);
  arguments.start_s = 2.5;
  EXPECT_EQ(playedSpan(path_, arguments).begin_s, 103.0);
  EXPECT_EQ(playedSpan(path_, arguments).end_s, 110.0);
  arguments.duration_s = 4.0;
  EXPECT_EQ(playedSpan(path_, arguments).end_s, 106.0);
  arguments.topics = {"/b"};
  EXPECT_EQ(playedSpan(path_, arguments).end_s, 105.0);
}

TEST_F(PlayedSpanTest, WithoutAMessageIsRefused) {
  PlayerArguments arguments;
  arguments.start_s = 20.0;
  EXPECT_THROW(playedSpan(path_, arguments), core::InputError);
}

}  // namespace
}  // namespace hymm
