#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <ros/ros.h>

namespace hymm {

/// Calls services without holding up the window: each call waits in a thread of its own, its answer
/// until poll() is asked for. An answer that comes after the object has gone goes nowhere.
class ServiceCalls {
 public:
  /// `answered` gets whether the service was reached, and its response.
  template <class Service>
  void call(const std::string& name, typename Service::Request request,
            std::function<void(bool, const typename Service::Response&)> answered) {
    std::thread([mailbox = mailbox_, name, request = std::move(request),
                 answered = std::move(answered)]() mutable {
      typename Service::Response response;
      const bool reached = ros::service::call(name, request, response);
      const std::lock_guard<std::mutex> lock(mailbox->mutex);
      mailbox->answers.push_back(
          [answered = std::move(answered), reached, response] { answered(reached, response); });
    }).detach();
  }

  /// Delivers what has come, in the caller's thread.
  void poll() {
    std::vector<std::function<void()>> answers;
    {
      const std::lock_guard<std::mutex> lock(mailbox_->mutex);
      answers.swap(mailbox_->answers);
    }
    for (const std::function<void()>& answer : answers) answer();
  }

 private:
  struct Mailbox {
    std::mutex mutex;
    std::vector<std::function<void()>> answers;
  };
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
};

}  // namespace hymm
