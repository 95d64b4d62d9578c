#pragma once

#include <string>

#include <boost/make_shared.hpp>
#include <ros/message_traits.h>
#include <rosbag/bag.h>

namespace hymm {

/// Writes a message so that a playback publishes it latched, as by a node named `writer`.
template <class Message>
void writeLatched(rosbag::Bag& bag, const std::string& topic, const ros::Time& time,
                  const Message& message, const std::string& writer) {
  auto header = boost::make_shared<ros::M_string>();
  (*header)["type"] = ros::message_traits::datatype(message);
  (*header)["md5sum"] = ros::message_traits::md5sum(message);
  (*header)["message_definition"] = ros::message_traits::definition(message);
  (*header)["callerid"] = "/" + writer;
  (*header)["latching"] = "1";
  bag.write(topic, time, message, header);
}

}  // namespace hymm
