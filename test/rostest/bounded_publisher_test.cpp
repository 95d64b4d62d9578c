#include "ros/bounded_publisher.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <sys/wait.h>
#include <unistd.h>

// This program is also the readers: with the argument `reader` it tells a line for each message.

namespace hymm {
namespace {

constexpr const char* kTopic = "large";
constexpr std::size_t kMessageBytes = 500'000;
constexpr BoundedPublisher::Bound kBound{4'000'000, 5.0};
constexpr int kFarTooMany = 200;  // far more than sockets hold: 100 MB

bool waitFor(const std::function<bool()>& condition) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

int runReader(int argc, char** argv) {
  ros::init(argc, argv, "reader", ros::init_options::AnonymousName);
  ros::NodeHandle handle;
  const boost::function<void(const std_msgs::String::ConstPtr&)> tell =
      [](const std_msgs::String::ConstPtr&) {
        if (::write(STDOUT_FILENO, "x", 1) != 1) ros::shutdown();
      };
  const ros::Subscriber subscriber = handle.subscribe<std_msgs::String>(kTopic, 0, tell);
  ros::spin();
  return 0;
}

/// A process that reads the topic, can be stopped as if it hung, and tells what it has got.
class Reader {
 public:
  Reader() {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::execl("/proc/self/exe", "reader", "reader", nullptr);
      ::_exit(1);
    }
    ::close(ends[1]);
    told_ = ends[0];
    ::fcntl(told_, F_SETFL, O_NONBLOCK);
  }
  ~Reader() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    ::close(told_);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  void hang() const {
    ::kill(process_, SIGSTOP);
    ::waitpid(process_, nullptr, WUNTRACED);
  }
  void goOn() const { ::kill(process_, SIGCONT); }
  /// Messages that it has got so far.
  int count() {
    char told[256];
    for (ssize_t size; (size = ::read(told_, told, sizeof told)) > 0;) {
      count_ += static_cast<int>(size);
    }
    return count_;
  }

 private:
  pid_t process_ = 0;
  int told_ = -1;
  int count_ = 0;
};

class BoundedPublisherTest : public testing::Test {
 protected:
  BoundedPublisherTest()
      : publisher_(handle_,
                   ros::AdvertiseOptions::create<std_msgs::String>(
                       kTopic, 1, [this](const ros::SingleSubscriberPublisher&) { ++served_; },
                       ros::SubscriberStatusCallback(), ros::VoidConstPtr(),
                       ros::getGlobalCallbackQueue()),
                   kBound) {
    message_.data.assign(kMessageBytes, 'x');
    spinner_.start();
  }

  void SetUp() override {
    ASSERT_TRUE(waitFor([this] { return publisher_.getNumSubscribers() == 2 && served_ == 2; }));
  }

  void publish() {
    publisher_.publish(message_);
    ++sent_;
  }

  bool publishUntil(const std::function<bool()>& condition) {
    return waitFor([&] {
      if (!publisher_.isFull()) publish();
      return condition();
    });
  }

  /// Until the bound is reached, and the reader that lives has got all.
  void fillTheOther() {
    hung_.hang();
    ASSERT_TRUE(waitFor([this] {
      if (!publisher_.isFull()) publish();
      return sent_ > kFarTooMany || (publisher_.isFull() && lives_.count() == sent_);
    }));
    ASSERT_LE(sent_, kFarTooMany);
  }

  ros::NodeHandle handle_;
  std::atomic<int> served_{0};
  std_msgs::String message_;
  int sent_ = 0;
  BoundedPublisher publisher_;
  Reader lives_, hung_;
  ros::AsyncSpinner spinner_{1};
};

TEST_F(BoundedPublisherTest, HoldsItsBoundForAReaderThatHangs) {
  fillTheOther();
  EXPECT_GE(publisher_.waitingBytes(), kBound.bytes);
  EXPECT_LT(publisher_.waitingBytes(), kBound.bytes + kMessageBytes + 100);
}

TEST_F(BoundedPublisherTest, DropsNothingForAReaderThatGoesOn) {
  fillTheOther();
  hung_.goOn();
  EXPECT_TRUE(waitFor([this] { return hung_.count() == sent_; })) << hung_.count();
  EXPECT_TRUE(waitFor([this] { return publisher_.waitingBytes() == 0; }));
}

TEST_F(BoundedPublisherTest, DisconnectsAReaderThatTakesNothingAndServesAllAnew) {
  fillTheOther();
  EXPECT_FALSE(publisher_.disconnectIfStuck(100.0));
  EXPECT_FALSE(publisher_.disconnectIfStuck(99.9 + kBound.patience_s));
  EXPECT_TRUE(publisher_.disconnectIfStuck(100.1 + kBound.patience_s));
  EXPECT_EQ(publisher_.waitingBytes(), 0U);
  // A reader may come back twice: by itself, and when the master tells it to.
  const int sent = sent_;
  EXPECT_TRUE(publishUntil([&] { return lives_.count() > sent; })) << "the reader that lives";
  EXPECT_GE(served_, 3);
  hung_.goOn();
  EXPECT_TRUE(publishUntil([&] { return hung_.count() > sent; })) << "the reader that hung";
  EXPECT_GE(served_, 4);
}

TEST_F(BoundedPublisherTest, KeepsAReaderThatIsSlow) {
  fillTheOther();
  EXPECT_FALSE(publisher_.disconnectIfStuck(100.0));
  const std::size_t full = publisher_.waitingBytes();
  hung_.goOn();
  EXPECT_TRUE(waitFor([&] { return publisher_.waitingBytes() < full; }));
  hung_.hang();
  EXPECT_FALSE(publisher_.disconnectIfStuck(101.0 + kBound.patience_s));
  EXPECT_EQ(publisher_.getNumSubscribers(), 2U);
}

TEST_F(BoundedPublisherTest, KeepsReadersWhileLittleWaits) {
  hung_.hang();
  publish();
  EXPECT_FALSE(publisher_.disconnectIfStuck(100.0));
  EXPECT_FALSE(publisher_.disconnectIfStuck(1000.0));
  EXPECT_EQ(publisher_.getNumSubscribers(), 2U);
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "reader") return hymm::runReader(argc, argv);
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "bounded_publisher_test");
  const ros::NodeHandle alive;  // the last one to go would end ROS
  return RUN_ALL_TESTS();
}
